"""Owns sampled models: what a linear model does from one sample to the next under held commands that arrive late.

The state is [x, sums, held]: departures of the motion (and lagging extensions), the controller's sums of errors
(unit of the state times s), and the commands that are under way, newest first. SI units.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig, expm

from models.modes import Mode, Modes, name_of, numbered, shares_of

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
WHOLE = 1e-9
"""Delays within this share of a sample of a whole number of samples are that number."""
DEADBEAT = 1e-12
"""Eigenvalues smaller than this are as good as zero: what they belong to is gone after a few samples."""


@dataclass(frozen=True)
class SampledModel:
    """X+ = F X + G u, one sample on; the first `motion` entries of X are the motion, the next `sums` the integrals.

    F (states, states), G (states, cells); `states` and `cells` names; `sample_time` and `delay` s.
    """

    states: tuple[str, ...]
    cells: tuple[str, ...]
    F: Array
    G: Array
    motion: int
    sums: int
    sample_time: float
    delay: float

    def feedback(self, gains: Array) -> Array:
        """Return gains (cells, motion + sums) widened by zeros for the commands under way, (cells, states)."""
        wide = np.zeros((len(self.cells), len(self.states)))
        wide[:, : self.motion + self.sums] = gains
        return wide

    def closed(self, gains: Array) -> Array:
        """Return F - G K, (states, states)."""
        return self.F - self.G @ self.feedback(gains)

    def loop(self, gains: Array, frequencies: Array) -> ComplexArray:
        """Return K (z I - F)^-1 G at z = exp(j w T), (frequencies, cells, cells): what comes back of each command."""
        z = np.exp(1j * frequencies * self.sample_time)
        systems = z[:, None, None] * np.eye(len(self.states)) - self.F
        answer = np.linalg.solve(systems, np.broadcast_to(self.G, (len(z), *self.G.shape)))
        return np.asarray(self.feedback(gains) @ answer, dtype=np.complex128)

    def modes(self, matrix: Array) -> Modes:
        """Return the modes of X+ = `matrix` X as those in continuous time: s = log(z) / T, 1/s.

        A real negative z changes sign at every sample, and counts as an oscillation of half the sampling frequency.
        """
        found = eig(matrix, left=True, right=True)
        values, left, right = (np.asarray(part, dtype=np.complex128) for part in found)
        size = np.maximum(np.abs(values), DEADBEAT)
        rates = (np.log(size) + 1j * np.abs(np.angle(values))) / self.sample_time
        kept = [k for k in np.argsort(-rates.real, kind="stable") if values[k].imag >= 0.0]
        shares = [shares_of(left[:, k], right[:, k]) for k in kept]
        names = [name_of(share, self.states, bool(rates[k].imag)) for k, share in zip(kept, shares, strict=True)]
        modes = []
        for k, name, share in zip(kept, numbered(names), shares, strict=True):
            vector = right[:, k] / right[np.abs(right[:, k]).argmax(), k]
            modes.append(Mode(name, complex(rates[k]), share, vector))
        return Modes(self.states, tuple(modes))


def radius_of(matrix: Array) -> float:
    """Return the largest magnitude of the eigenvalues: below 1 what departs comes back."""
    return float(np.abs(np.linalg.eigvals(matrix)).max(initial=0.0))


def held_over(A: Array, B: Array, time: float) -> tuple[Array, Array]:
    """Return exp(A t) and its integral times B over a time, s (Franklin, Powell and Workman, 1998, 4.3.3)."""
    n, m = B.shape
    whole = np.zeros((n + m, n + m))
    whole[:n, :n], whole[:n, n:] = A * time, B * time
    moved = expm(whole)
    return moved[:n, :n], moved[:n, n:]


def split_delay(delay: float, sample_time: float) -> tuple[int, float]:
    """Return a delay as whole samples and a rest, s."""
    whole = math.floor(delay / sample_time + WHOLE)
    rest = max(delay - whole * sample_time, 0.0)
    return whole, 0.0 if rest <= WHOLE * sample_time else rest


def sampled_model(
    A: Array, B: Array, *, states: tuple[str, ...], cells: tuple[str, ...], sample_time: float, delay: float = 0.0,
    sums: int = 0,
) -> SampledModel:  # fmt: skip
    """Return the sampled model of x' = A x + B u, the first `sums` states being summed by the controller.

    A delay of d whole samples and a rest e acts by u(k - d - 1) until e and by u(k - d) from then on (Franklin, Powell
    and Workman, 1998, 4.3.4). The sums are the controller's: s(k + 1) = s(k) + T x(k).
    """
    n, m = B.shape
    whole, rest = split_delay(delay, sample_time)
    under_way = whole + (rest > 0.0)
    size = n + sums + m * under_way
    F, G = np.zeros((size, size)), np.zeros((size, m))
    F[:n, :n], _ = held_over(A, B, sample_time)
    after, new = held_over(A, B, sample_time - rest)
    F[range(n, n + sums), range(n, n + sums)] = 1.0
    F[range(n, n + sums), range(sums)] = sample_time
    first = n + sums
    for target, age in ((new, whole), (after @ held_over(A, B, rest)[1], whole + 1)):
        if age == 0:
            G[:n] += target
        elif age <= under_way:
            F[:n, first + (age - 1) * m : first + age * m] += target
    if under_way:
        G[first : first + m] = np.eye(m)
        F[first + m :, first : size - m] = np.eye(size - first - m)
    names = (
        *states, *(f"integral of {name}" for name in states[:sums]),
        *(f"command of {cell} under way, {age + 1}" for age in range(under_way) for cell in cells),
    )  # fmt: skip
    return SampledModel(names, cells, F, G, n, sums, sample_time, delay)
