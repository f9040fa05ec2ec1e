"""Owns frequency responses of linear models: G(jw) = C (jw I - A)^-1 B + D of one input to one output."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.linear_model import LinearModel, index_of
from models.problems import DesignError, Problem

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
POINTS = 300
"""Frequencies where none are given."""
SLOWEST_MODE = 1e-4
"""Modes slower than this (rad/s) do not decide where the frequencies begin: depth in layered water is one."""
SINGULAR = 1e-12
"""A state matrix whose smallest singular value is below this share of its largest has no gain at rest."""
MOST_POINTS = 100_000


@dataclass(frozen=True)
class FrequencyResponse:
    """Response of one output to one input.

    `frequencies` (k,) rad/s; `response` (k,) complex, in the unit of the output per that of the input; `dc_gain` in the
    same, None where the output runs away under a constant input.
    """

    input: str
    output: str
    unit: str
    frequencies: Array
    response: ComplexArray
    dc_gain: float | None

    @property
    def magnitude(self) -> Array:
        """Magnitude, (k,) in `unit`."""
        return np.abs(self.response)

    @property
    def magnitude_db(self) -> Array:
        """Magnitude in decibel, 20 log10, (k,); minus infinity where it is zero."""
        with np.errstate(divide="ignore"):
            return np.asarray(20.0 * np.log10(self.magnitude), dtype=np.float64)

    @property
    def phase(self) -> Array:
        """Phase without jumps, (k,) rad."""
        return np.unwrap(np.angle(self.response))

    def as_dict(self) -> dict[str, Any]:
        """Return the response as a JSON object; a magnitude of zero has no decibels."""
        decibels = [value if math.isfinite(value) else None for value in self.magnitude_db.tolist()]
        return {
            "input": self.input, "output": self.output, "unit": self.unit, "dc_gain": self.dc_gain,
            "frequencies": self.frequencies.tolist(), "magnitude": self.magnitude.tolist(),
            "magnitude_db": decibels, "phase": self.phase.tolist(),
        }  # fmt: skip


def frequency_response(
    model: LinearModel, *, input: str, output: str, frequencies: Array | None = None
) -> FrequencyResponse:
    """Return the response of an output to an input, by name, at frequencies (k,) in rad/s or over those of the modes.

    Raises
    ------
    DesignError
        Where a name is unknown, or the frequencies are not finite, positive and at most 100,000.

    """
    i = index_of(input, model.input_names, "input")
    o = index_of(output, model.output_names, "output")
    omega = spanning(model.A) if frequencies is None else _checked(np.atleast_1d(np.asarray(frequencies, dtype=float)))
    A, b, c, d = model.A, model.B[:, i], model.C[o], model.D[o, i]
    n = len(A)
    response = np.full(len(omega), complex(d))
    if n:
        systems = 1j * omega[:, None, None] * np.eye(n) - A
        response = np.linalg.solve(systems, np.broadcast_to(b[:, None], (len(omega), n, 1)))[:, :, 0] @ c + d
    unit = f"{model.outputs[o].unit} per {model.inputs[i].unit}"
    return FrequencyResponse(input, output, unit, omega, response, dc_gain(A, b, c, d))


def spanning(A: Array) -> Array:
    """Return frequencies (k,) rad/s from a decade below the slowest mode to a decade above the fastest."""
    sizes = np.abs(np.linalg.eigvals(A)) if len(A) else np.zeros(0)
    sizes = sizes[sizes > SLOWEST_MODE]
    low, high = (sizes.min(), sizes.max()) if len(sizes) else (1.0, 1.0)
    return np.logspace(math.log10(low) - 1.0, math.log10(high) + 1.0, POINTS)


def dc_gain(A: Array, b: Array, c: Array, d: float) -> float | None:
    """Return d - c A^-1 b, states that neither others nor the output feel left out; None where A is singular."""
    kept = np.arange(len(A))
    while len(kept):
        felt = (A[np.ix_(kept, kept)] != 0.0).any(axis=0) | (c[kept] != 0.0)
        if felt.all():
            break
        kept = kept[felt]
    if not len(kept):
        return float(d)
    rest = A[np.ix_(kept, kept)]
    values = np.linalg.svd(rest, compute_uv=False)
    if values[-1] <= SINGULAR * values[0]:
        return None
    return float(d - c[kept] @ np.linalg.solve(rest, b[kept]))


def _checked(omega: Array) -> Array:
    if not 0 < omega.size <= MOST_POINTS or omega.ndim != 1:
        message = f"{omega.size} frequencies: give 1 to {MOST_POINTS:,} of them"
        raise DesignError([Problem("/frequencies", message, limit=MOST_POINTS)])
    bad = ~(np.isfinite(omega) & (omega > 0.0))
    if bad.any():
        k = int(np.flatnonzero(bad)[0])
        message = f"{omega[k]:g} rad/s is not a frequency: they are finite and positive"
        raise DesignError([Problem(f"/frequencies/{k}", message, limit=0.0)])
    return omega
