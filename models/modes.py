"""Owns modes of motion: eigenvalues of a state matrix with period, damping, the states that take part, and a name.

The share of a state in a mode is its participation factor |v w|, the mode's right and left eigenvectors there, scaled
so that the shares of a mode add up to 1; it does not depend on units (Perez-Arriaga, Verghese and Schweppe, 1982, Eq.
14). Names follow from shares alone: see `name_of`.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
NEUTRAL = 1e-7
"""Growth below this (1/s) counts as none: rounding of the differences."""
STEADY = ("z", "psi")
MOSTLY = 0.9
"""A mode of which depth and heading hold more than this is how a glider goes on, and says nothing of its stability."""
OSCILLATIONS = {
    "phugoid": ("u", "theta"), "pitch oscillation": ("theta", "q"), "short period": ("w", "q"), "bobbing": ("z", "w"),
    "roll oscillation": ("phi", "p"), "dutch roll": ("v", "r"), "lateral phugoid": ("phi", "r"),
    "roll-sway oscillation": ("phi", "v"),
}  # fmt: skip
"""Oscillations by the two states that take part most."""
SUBSIDENCES = {
    "z": "depth", "psi": "heading", "phi": "spiral", "theta": "pitch return", "u": "surge", "v": "sway subsidence",
    "w": "heave subsidence", "p": "roll subsidence", "q": "pitch subsidence", "r": "yaw subsidence",
}  # fmt: skip
"""Modes without oscillation by the state that takes part most."""
EXTENSION = "extension of "


@dataclass(frozen=True)
class Mode:
    """One mode, a conjugate pair counted once: eigenvalue (1/s, its imaginary part not negative) and shares by state.

    `eigenvector` (states,), its largest entry 1, in the states' units.
    """

    name: str
    eigenvalue: complex
    shares: Array
    eigenvector: ComplexArray

    @property
    def growth(self) -> float:
        """Real part, 1/s: positive where the mode grows."""
        return self.eigenvalue.real

    @property
    def oscillates(self) -> bool:
        """Whether this is a conjugate pair."""
        return self.eigenvalue.imag != 0.0

    @property
    def period(self) -> float | None:
        """Period, s; None where it does not oscillate."""
        return 2.0 * math.pi / self.eigenvalue.imag if self.oscillates else None

    @property
    def damping_ratio(self) -> float | None:
        """Damping as a share of the critical one, negative where it grows; None of what is neutral and still."""
        size = abs(self.eigenvalue)
        return -self.growth / size if size > NEUTRAL else None

    @property
    def time_constant(self) -> float | None:
        """Time to fall to 1/e, or to grow to e, s; None where it does neither."""
        return 1.0 / abs(self.growth) if abs(self.growth) > NEUTRAL else None

    @property
    def time_to_half(self) -> float | None:
        """Time to half, s; None where it does not decay."""
        return math.log(2.0) / -self.growth if self.growth < -NEUTRAL else None

    @property
    def time_to_double(self) -> float | None:
        """Time to double, s; None where it does not grow."""
        return math.log(2.0) / self.growth if self.growth > NEUTRAL else None

    def as_dict(self) -> dict[str, Any]:
        """Return the mode as a JSON object."""
        return {
            "name": self.name, "real": self.eigenvalue.real, "imag": self.eigenvalue.imag,
            "period": self.period, "damping_ratio": self.damping_ratio, "time_constant": self.time_constant,
            "time_to_half": self.time_to_half, "time_to_double": self.time_to_double, "shares": self.shares.tolist(),
            "eigenvector": {"real": self.eigenvector.real.tolist(), "imag": self.eigenvector.imag.tolist()},
        }  # fmt: skip


@dataclass(frozen=True)
class Modes:
    """All modes of a matrix on named states, slowest to decay first."""

    states: tuple[str, ...]
    modes: tuple[Mode, ...]

    @property
    def participation(self) -> Array:
        """Shares, (states, modes); every column adds up to 1."""
        return np.array([mode.shares for mode in self.modes]).reshape(-1, len(self.states)).T

    @property
    def leading(self) -> Mode | None:
        """The mode that grows fastest or decays slowest, depth and heading aside; None if there is none."""
        at = [k for k, name in enumerate(self.states) if name in STEADY]
        telling = [mode for mode in self.modes if mode.shares[at].sum() <= MOSTLY]
        return max(telling, key=lambda mode: mode.growth, default=None)

    @property
    def growth(self) -> float:
        """Growth of the leading mode, 1/s; minus infinity where there is none."""
        return self.leading.growth if self.leading is not None else -math.inf

    @property
    def stable(self) -> bool:
        """Whether every mode but depth and heading decays."""
        return self.growth < -NEUTRAL

    def named(self, name: str) -> tuple[Mode, ...]:
        """Return the modes of a name, whatever their number."""
        return tuple(mode for mode in self.modes if mode.name == name or mode.name.startswith(f"{name} #"))

    def as_dict(self) -> dict[str, Any]:
        """Return the modes as a JSON object."""
        leading = self.leading
        return {
            "states": list(self.states),
            "modes": [mode.as_dict() for mode in self.modes],
            "leading": None if leading is None else leading.name,
            "growth": None if leading is None else leading.growth,
            "stable": self.stable,
        }


def modes_of(matrix: Array, states: Sequence[str]) -> Modes:
    """Return the modes of x' = A x, A (states, states)."""
    found: tuple[Any, Any, Any] = eig(matrix, left=True, right=True)  # type: ignore[assignment]
    values, left, right = found
    kept = [k for k in np.argsort(-values.real, kind="stable") if values[k].imag >= 0.0]
    shares = [shares_of(left[:, k], right[:, k]) for k in kept]
    names = numbered([name_of(share, states, bool(values[k].imag)) for k, share in zip(kept, shares, strict=True)])
    modes = []
    for k, name, share in zip(kept, names, shares, strict=True):
        vector = right[:, k].astype(np.complex128)
        value = complex(values[k])
        modes.append(Mode(name, value, share, vector / vector[np.abs(vector).argmax()]))
    return Modes(tuple(states), tuple(modes))


def shares_of(left: ComplexArray, right: ComplexArray) -> Array:
    """Return the participation factors of one mode, (states,), which add up to 1."""
    factors = np.abs(left * right)
    total = float(factors.sum())
    # the eigenvectors of an eigenvalue met twice can be at right angles: then the right one tells who takes part
    return factors / total if total > 1e-12 else np.abs(right) ** 2 / float((np.abs(right) ** 2).sum())


def name_of(shares: Array, states: Sequence[str], oscillates: bool) -> str:
    """Name a mode by who takes part.

    Where extensions hold more than half, it is the lag of the one that holds most. An oscillation is that of
    `OSCILLATIONS` whose two states hold most together; any other mode that of `SUBSIDENCES` whose state holds most.
    """
    share = dict(zip(states, shares.tolist(), strict=True))
    cells = {name: value for name, value in share.items() if name.startswith(EXTENSION)}
    if sum(cells.values()) > 0.5:
        return f"actuator lag of '{max(cells, key=lambda name: cells[name]).removeprefix(EXTENSION)}'"
    if oscillates:
        held = {name: sum(share.get(state, 0.0) for state in pair) for name, pair in OSCILLATIONS.items()}
        return max(held, key=lambda name: held[name])
    own = {name: value for name, value in share.items() if name not in cells}
    most = max(own, key=lambda name: own[name])
    return SUBSIDENCES.get(most, most)


def numbered(names: list[str]) -> list[str]:
    """Number the names that occur more than once, from 1."""
    often, seen = Counter(names), Counter[str]()
    numbered = []
    for name in names:
        seen[name] += 1
        numbered.append(f"{name} #{seen[name]}" if often[name] > 1 else name)
    return numbered
