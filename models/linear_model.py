"""Owns the linear model: matrices on named states, inputs and outputs about an operating point, in SI units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from models.operating_point import OperatingPoint
from models.problems import DesignError, Problem, echo, pointer_to

Array = NDArray[np.float64]
STILL = 1e-5
"""Rates of change below this (SI units a second) count as none."""
DRIFTING = ("z", "psi")
"""States that change steadily in a steady motion."""


@dataclass(frozen=True, slots=True)
class Signal:
    """One state, input or output: its name, unit and meaning, and its value at the operating point."""

    name: str
    unit: str
    meaning: str
    value: float

    def as_dict(self) -> dict[str, Any]:
        """Return it as a JSON object."""
        return {"name": self.name, "unit": self.unit, "meaning": self.meaning, "value": self.value}


@dataclass(frozen=True)
class LinearModel:
    """x' = drift + A x + B c, y = C x + D c, with x, c, y the departures from the operating point.

    A (states, states), B (states, inputs), C (outputs, states), D (outputs, inputs); units are those of the signals,
    and of A and B those a second. `drift` (states,) is the rate of each state at the point itself: in a steady motion
    only depth and heading have one. `notes` says in words what the model leaves out here.
    """

    model: str
    point: OperatingPoint
    states: tuple[Signal, ...]
    inputs: tuple[Signal, ...]
    outputs: tuple[Signal, ...]
    A: Array
    B: Array
    C: Array
    D: Array
    drift: Array
    notes: tuple[str, ...]

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states."""
        return tuple(signal.name for signal in self.states)

    @property
    def input_names(self) -> tuple[str, ...]:
        """Names of the inputs."""
        return tuple(signal.name for signal in self.inputs)

    @property
    def output_names(self) -> tuple[str, ...]:
        """Names of the outputs."""
        return tuple(signal.name for signal in self.outputs)

    @cached_property
    def residual(self) -> float:
        """Largest rate of change at the point, depth and heading aside, in SI units a second."""
        kept = [i for i, name in enumerate(self.state_names) if name not in DRIFTING]
        return float(np.abs(self.drift[kept]).max(initial=0.0))

    @property
    def is_equilibrium(self) -> bool:
        """Whether nothing but depth and heading changes at the point."""
        return self.residual <= STILL

    def without(self, *names: str) -> LinearModel:
        """Return the model with some states held, such as "z" to freeze the water; as outputs they go too.

        Raises
        ------
        DesignError
            Where there is no state of that name.

        """
        gone = {index_of(name, self.state_names, "state") for name in names}
        kept = [i for i in range(len(self.states)) if i not in gone]
        shown = [i for i, name in enumerate(self.output_names) if name not in names]
        return replace(
            self, states=tuple(self.states[i] for i in kept), outputs=tuple(self.outputs[i] for i in shown),
            A=self.A[np.ix_(kept, kept)], B=self.B[kept], C=self.C[np.ix_(shown, kept)], D=self.D[shown],
            drift=self.drift[kept],
        )  # fmt: skip

    def as_dict(self) -> dict[str, Any]:
        """Return the model as a JSON object; matrices are lists of rows."""
        return {
            "model": self.model,
            "point": self.point.as_dict(),
            **{
                kind: [signal.as_dict() for signal in signals]
                for kind, signals in (("states", self.states), ("inputs", self.inputs), ("outputs", self.outputs))
            },
            **{name: getattr(self, name).tolist() for name in ("A", "B", "C", "D", "drift")},
            "is_equilibrium": self.is_equilibrium,
            "residual": self.residual,
            "notes": list(self.notes),
        }

    def step_response(self, inputs: Array, times: Array) -> Array:
        """Return the states' departures (times, states) after a step of the inputs (inputs,) at time zero.

        Exact, by the matrix exponential of [[A, B c + drift], [0, 0]] (Van Loan, 1978); `times` (times,) s, not
        negative.
        """
        n = len(self.states)
        whole = np.zeros((n + 1, n + 1))
        whole[:n, :n], whole[:n, n] = self.A, self.B @ np.asarray(inputs, dtype=np.float64) + self.drift
        return np.array([expm(whole * t)[:n, n] for t in np.asarray(times, dtype=np.float64)])


def index_of(name: str, names: Sequence[str], what: str) -> int:
    """Return where a signal is.

    Raises
    ------
    DesignError
        Where there is none of that name.

    """
    if name in names:
        return list(names).index(name)
    known = ", ".join(f"'{other}'" for other in names) or "none"
    raise DesignError([Problem(pointer_to(what), f"there is no {what} named {echo(name)}", hint=f"those are: {known}")])
