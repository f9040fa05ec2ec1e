"""Owns checks 5 and 8 of docs/validation.md: Graver's steady glides in closed form, held against simulated ones.

J. G. Graver, 2005, Underwater gliders: dynamics, control and design, PhD thesis, Princeton, chapter 4: drag
(K_D0 + K_D alpha^2) V^2, lift (K_L0 + K_L alpha) V^2, viscous moment (K_M0 + K_M alpha) V^2, and the Munk moment
(m_f3 - m_f1) v1 v3. Angles in rad; xi is the glide path angle, negative down, and pitch = xi + alpha.
"""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from models.design import Design, parse_design
from models.presets import load_preset
from models.run import Run
from models.simulate import simulate

Array = NDArray[np.float64]
DATA = Path(__file__).parents[1] / "tests" / "data" / "slocum_graver_2005.json"
PATH_ANGLES_DEG = (-8.0, -12.0, -16.0, -20.0, -25.0, -30.0, -37.0, -45.0, 25.0)
DESIGN_ANGLE_DEG = -25.0
DURATION = 900.0
START_PITCH_DEG, START_SPEED = 3.0, 0.8
"""How far off a glide its run starts: pitch, and share of the speed."""
DEMANDED = 1e-4
"""Four digits: relative difference of angle of attack, pitch and speed."""
FIXED_POINT = 1e-8
"""Largest departure from a trim in angles (rad) and speeds (m/s), at tolerance 1e-11."""
OFFSETS_DEG = (0.0, 0.01, 0.3, 5.0)


class Glide(NamedTuple):
    """A steady glide: path angle, angle of attack, pitch (rad), speed (m/s), ballast (kg), place of the mass (m)."""

    xi: float
    alpha: float
    theta: float
    speed: float
    ballast: float
    rp1: float

    @property
    def velocity(self) -> tuple[float, float]:
        """Horizontal speed and sinking speed, m/s."""
        return self.speed * math.cos(self.xi), -self.speed * math.sin(self.xi)


class Compared(NamedTuple):
    """A steady glide in closed form, and the last sample of the run of each model."""

    closed: Glide
    runs: dict[str, Run]


@cache
def published() -> dict[str, Any]:
    """Return the data file: the published parameters, and one glide from an independent script."""
    return dict(json.loads(DATA.read_text(encoding="utf-8")))


def shallowest() -> float:
    """Return the shallowest path angle (rad, positive): where the quadratic for alpha has one root (K_L0 = 0)."""
    k = published()["parameters"]
    return math.atan(2.0 * math.sqrt(k["KD"] * k["KD0"]) / k["KL"])


def largest_attack() -> float:
    """Return the angle of attack there, rad."""
    k = published()["parameters"]
    return math.sqrt(k["KD0"] / k["KD"])


def closed_form(xi: float, speed: float) -> Glide:
    """Return the steady glide at a path angle and speed.

    tan(xi) = -D / L gives K_D alpha^2 + K_L tan(xi) alpha + K_D0 + K_L0 tan(xi) = 0, whose smaller root is the glide.
    """
    k = published()["parameters"]
    b, c = k["KL"] * math.tan(xi), k["KD0"] + k["KL0"] * math.tan(xi)
    root = math.sqrt(b * b - 4.0 * k["KD"] * c)
    alpha = -2.0 * c / (b + math.copysign(root, b))
    theta = xi + alpha
    drag, lift = k["KD0"] + k["KD"] * alpha**2, k["KL0"] + k["KL"] * alpha
    force = (lift * math.cos(xi) - drag * math.sin(xi)) * speed**2
    ballast = k["m"] - k["mh"] - k["mbar"] + force / k["g"]
    munk = (k["mf3"] - k["mf1"]) * math.cos(alpha) * math.sin(alpha)
    moment = (munk + k["KM0"] + k["KM"] * alpha) * speed**2
    rp1 = -k["rp3"] * math.tan(theta) + moment / (k["mbar"] * k["g"] * math.cos(theta))
    return Glide(xi, alpha, theta, speed, ballast, rp1)


def at_ballast(xi: float, ballast: float) -> Glide:
    """Return the steady glide at a path angle with a given ballast: net weight grows with the squared speed."""
    k = published()["parameters"]
    neutral = k["m"] - k["mh"] - k["mbar"]
    share = (ballast - neutral) / (closed_form(xi, 1.0).ballast - neutral)
    return closed_form(xi, math.sqrt(share))


def designed(glide: Glide, model: str, *, tolerance: float = 1e-10, duration: float = DURATION) -> Design:
    """Return the preset with the ballast and mass of a glide, started off it."""
    document = load_preset("slocum-glide").model_dump(mode="json")
    for part in document["vehicle"]["components"]:
        if part["name"] == "Ballast":
            part["mass"] = glide.ballast
        elif part["kind"] == "movable_mass":
            part["extension_range"] = [-0.2, 0.2]
    mission = document["mission"]
    mission["initial"] |= {
        "position": [0.0, 0.0, 500.0], "pitch": glide.theta + math.radians(START_PITCH_DEG),
        "velocity": [START_SPEED * glide.speed, 0.0, 0.0], "extensions": {"Movable mass": glide.rp1},
    }  # fmt: skip
    mission["solver"] |= {"model": model, "tolerance": tolerance, "output_interval": 1.0}
    mission["duration"] = duration
    return parse_design(document)


def _compare(glide: Glide) -> Compared:
    return Compared(glide, {model: simulate(designed(glide, model)) for model in ("planar", "spatial")})


@cache
def glides() -> tuple[Compared, ...]:
    """Simulate the closed form's ballast and mass position at every path angle, at the source's design speed."""
    speed = published()["parameters"]["V_d"]
    return tuple(_compare(closed_form(math.radians(xi), speed)) for xi in PATH_ANGLES_DEG)


@cache
def polar() -> tuple[Compared, ...]:
    """Simulate the glides down at the preset's ballast: the mass alone sets the path angle."""
    ballast = published()["derived"]["glides"][0]["mb"]
    return tuple(_compare(at_ballast(math.radians(xi), ballast)) for xi in PATH_ANGLES_DEG if xi < 0.0)


def polar_line() -> Array:
    """Return horizontal and sinking speed (m/s) of the closed form, from the shallowest angle to 60 deg, (n, 2)."""
    ballast = published()["derived"]["glides"][0]["mb"]
    angles = -np.linspace(shallowest() + 1e-9, math.radians(60.0), 200)
    return np.array([at_ballast(float(xi), ballast).velocity for xi in angles])


def differences(compared: Compared, run: Run) -> tuple[float, float, float]:
    """Return how far a run ends from the closed form, relative: angle of attack, pitch, speed."""
    names = ("alpha", "theta", "speed")
    shares = [abs(run.final[name] / getattr(compared.closed, name) - 1.0) for name in names]
    return shares[0], shares[1], shares[2]


@cache
def started_at_trim(offset_deg: float = 0.0, model: str = "spatial") -> Run:
    """Simulate from the closed form's own state, with the pitch (at the same angle of attack) off by `offset_deg`."""
    glide = closed_form(math.radians(DESIGN_ANGLE_DEG), published()["parameters"]["V_d"])
    document = designed(glide, model, tolerance=1e-11, duration=600.0).model_dump(mode="json")
    document["mission"]["initial"] |= {
        "pitch": glide.theta + math.radians(offset_deg),
        "velocity": [glide.speed * math.cos(glide.alpha), 0.0, glide.speed * math.sin(glide.alpha)],
    }
    return simulate(parse_design(document))


def departure(run: Run) -> Array:
    """Return the largest departure of pitch, surge, heave and pitch rate from the trim over time, (samples,)."""
    glide = closed_form(math.radians(DESIGN_ANGLE_DEG), published()["parameters"]["V_d"])
    trim = {
        "theta": glide.theta, "u": glide.speed * math.cos(glide.alpha), "w": glide.speed * math.sin(glide.alpha),
        "q": 0.0,
    }  # fmt: skip
    return np.max([np.abs(run.values[name] - value) for name, value in trim.items()], axis=0)
