"""Owns the modes of a design at an operating point as the page shows and plays them.

Depth and heading are held for the eigenvalues, as they are where a trim is called stable. How the glider moves in a
mode follows from the linear model: with v the mode's eigenvector, its depth and heading go by A v / lambda, and its
place in the frame that turns with the trim by (lambda + Omega x) p = C v. SI units and radians.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly
from models.linear_model import LinearModel
from models.linearize import linearize
from models.modes import EXTENSION, Mode, Modes, modes_of
from models.operating_point import OperatingPoint
from models.vehicle_length import vehicle_length

ComplexArray = NDArray[np.complex128]
HELD = ("z", "psi")
TELLING = 0.05
"""Share of a state below which it is left out of the words."""
STILL = 1e-6
"""An eigenvalue below this has no motion of its own to show, 1/s."""
WORDS = {
    "u": "surge", "v": "sway", "w": "heave", "p": "roll rate", "q": "pitch rate", "r": "yaw rate", "phi": "roll",
    "theta": "pitch",
}  # fmt: skip
PLACES, ANGLES = ("ahead", "right", "down"), ("roll", "pitch", "yaw")
OVER_GROUND = ("x_dot", "y_dot")


def modes_document(assembly: Assembly, point: OperatingPoint) -> dict[str, Any]:
    """Return the modes at a point: eigenvalues, words, and each one's motion.

    Raises
    ------
    DesignError
        Where `linearize` does.

    """
    model = linearize(assembly, point)
    kept = model.without(*(name for name in HELD if name in model.state_names))
    modes = modes_of(kept.A, kept.state_names)
    length = vehicle_length(assembly.design.vehicle)
    leading = modes.leading
    return {
        "point": point.as_dict(),
        "speed": point.speed,
        "equilibrium": kept.is_equilibrium,
        "residual": kept.residual,
        "states": [{"name": name, "words": state_words(name)} for name in kept.state_names],
        "leading": None if leading is None else leading.name,
        "stable": modes.stable,
        "modes": [_mode_document(model, modes, mode, length) for mode in modes.modes],
        "notes": list(model.notes),
    }


def state_words(name: str) -> str:
    """Return a state in a word or two."""
    return f"'{name.removeprefix(EXTENSION)}'" if name.startswith(EXTENSION) else WORDS.get(name, name)


def participation(modes: Modes, mode: Mode) -> str:
    """Return in words which states take part in a mode, the largest share first."""
    order = np.argsort(-mode.shares, kind="stable")
    told = [f"{state_words(modes.states[k])} {100.0 * mode.shares[k]:.0f} %" for k in order if mode.shares[k] > TELLING]
    return ", ".join(told[:4])


def motion_of_mode(model: LinearModel, mode: Mode) -> dict[str, complex] | None:
    """Return the amplitudes of place (m) and angles (rad) that belong to a mode's eigenvector; None where it is still.

    `model` is the whole one, with depth and heading where it has them.
    """
    if abs(mode.eigenvalue) < STILL:
        return None
    names, s = model.state_names, mode.eigenvalue
    whole: ComplexArray = np.zeros(len(names), dtype=np.complex128)
    kept = [k for k, name in enumerate(names) if name not in HELD]
    whole[kept] = mode.eigenvector
    found = {place: 0j for place in (*PLACES, *ANGLES)}
    for held, what in (("psi", "yaw"), ("z", "down")):
        if held in names:
            k = names.index(held)
            whole[k] = (model.A[k] @ whole) / s
            found[what] = complex(whole[k])
    for state, what in (("phi", "roll"), ("theta", "pitch")):
        if state in names:
            found[what] = complex(whole[names.index(state)])
    rate = dict(zip(names, model.drift, strict=True)).get("psi", 0.0)
    over_ground = [model.C[model.output_names.index(n)] @ whole if n in model.output_names else 0j for n in OVER_GROUND]
    place = np.linalg.solve(np.array([[s, -rate], [rate, s]]), np.array(over_ground, dtype=np.complex128))
    found["ahead"], found["right"] = complex(place[0]), complex(place[1])
    return found


def _mode_document(model: LinearModel, modes: Modes, mode: Mode, length: float) -> dict[str, Any]:
    told = mode.as_dict()
    kept = ("name", "real", "imag", "period", "damping_ratio", "time_constant", "time_to_half", "time_to_double")
    motion = motion_of_mode(model, mode)
    return {name: told[name] for name in kept} | {
        "participation": participation(modes, mode),
        "shares": told["shares"],
        "motion": None if motion is None else _scaled(motion, length),
    }


def _scaled(motion: dict[str, complex], length: float) -> dict[str, list[float]] | None:
    """Return a motion scaled: its largest angle is 1 rad, or its largest move the length, whichever is sooner."""
    size = max(*(abs(motion[name]) for name in ANGLES), *(abs(motion[name]) / length for name in PLACES))
    if not (math.isfinite(size) and size > 0.0):
        return None
    return {name: [value.real / size, value.imag / size] for name, value in motion.items()}
