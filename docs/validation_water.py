"""Owns check 9 of docs/validation.md: densities by TEOS-10, and a float about its neutral depth in stratified water."""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import gsw
import numpy as np
from numpy.typing import NDArray

from models.design import Design, parse_design
from models.environment import Teos10Water
from models.run import Run
from models.simulate import simulate
from models.water import density_at
from tests.models.support import document

Array = NDArray[np.float64]
DATA = Path(__file__).parents[1] / "tests" / "data" / "teos10_gsw_manual.json"
GRAVITY, SURFACE, SLOPE, DEEPEST = 9.81, 1000.0, 0.02, 200.0
"""Density rho = SURFACE + SLOPE z, kg/m3 and kg/m4, down to DEEPEST, m."""
MASS, NEUTRAL, BULK_MODULUS = 50.0, 100.0, 2.5e10
"""The float, and the stiffness of the one that gives way, Pa; water itself has 2.2e9."""
PERIODS = 5
DEMANDED = {"period": 1e-6, "path": 1e-6}
"""Relative difference of the period, and the largest of the path as a share of the amplitude."""


class Oscillation(NamedTuple):
    """A float let go `amplitude` (m) below its neutral depth: closed frequency (rad/s) and the run."""

    name: str
    amplitude: float
    omega: float
    run: Run

    @property
    def closed(self) -> Array:
        """Height below the neutral depth by the closed form, m."""
        return self.amplitude * np.cos(self.omega * self.run.times)

    @property
    def simulated(self) -> Array:
        """Height below the neutral depth, m."""
        return self.run.values["z"] - NEUTRAL

    @property
    def period(self) -> float:
        """The simulated period, s: from the first to the last passing through the neutral depth."""
        z, t = self.simulated, self.run.times
        passing = np.flatnonzero(z[:-1] * z[1:] < 0.0)
        dt = t[1] - t[0]
        times = [t[k] + _crossing(z[k], z[k + 1], *(self.run.values["z_dot"][k : k + 2] * dt)) * dt for k in passing]
        return float(2.0 * (times[-1] - times[0]) / (len(times) - 1))

    @property
    def largest(self) -> float:
        """Largest difference of the path from the closed form as a share of the amplitude."""
        return float(np.abs(self.simulated - self.closed).max() / self.amplitude)


def _crossing(z0: float, z1: float, m0: float, m1: float) -> float:
    """Return where in [0, 1] the cubic with these ends and end slopes is zero."""
    cubic = [2.0 * (z0 - z1) + m0 + m1, -3.0 * (z0 - z1) - 2.0 * m0 - m1, m0, z0]
    roots = np.roots(cubic)
    real = roots[np.abs(roots.imag) < 1e-9].real
    return float(real[(real >= 0.0) & (real <= 1.0)][0])


@cache
def published() -> dict[str, Any]:
    """Return the data file."""
    return dict(json.loads(DATA.read_text(encoding="utf-8")))


@cache
def densities() -> Array:
    """Return our densities at the published points, kg/m3, through the table that the kernel reads."""
    data = published()
    pressure, salinity = np.array(data["p"]), np.array(data["SA"])
    depths = -gsw.z_from_p(pressure, data["latitude_deg"])
    water = Teos10Water(
        kind="teos10", depths=tuple(depths.tolist()), salinities=tuple(data["SA"]), salinity_kind="absolute",
        temperatures=tuple(gsw.t_from_CT(salinity, np.array(data["CT"]), pressure).tolist()),
        latitude=data["latitude_deg"],
    )  # fmt: skip
    return density_at(water, depths)


def neutral_density() -> float:
    """Return the density at the neutral depth, kg/m3."""
    return SURFACE + SLOPE * NEUTRAL


def neutral_pressure() -> float:
    """Return the gauge pressure there, Pa."""
    return GRAVITY * NEUTRAL * (SURFACE + 0.5 * SLOPE * NEUTRAL)


def volume_for(bulk_modulus: float | None) -> float:
    """Return the volume without pressure that floats at the neutral depth, m3."""
    kept = 1.0 if bulk_modulus is None else 1.0 - neutral_pressure() / bulk_modulus
    return MASS / (neutral_density() * kept)


def frequency(added: float, bulk_modulus: float | None) -> float:
    """Return the frequency of small heave about the neutral depth, rad/s.

    (m + A33) z'' = g m - g rho(z) V(p(z)), hence omega^2 = g V0 (rho' (1 - p/K) - rho^2 g / K) / (m + A33): with a
    stiff hull N^2 m / (m + A33), N^2 = g rho' / rho.
    """
    V, rho = volume_for(bulk_modulus), neutral_density()
    softness = 0.0 if bulk_modulus is None else 1.0 / bulk_modulus
    slope = SLOPE * (1.0 - neutral_pressure() * softness) - rho**2 * GRAVITY * softness
    return math.sqrt(GRAVITY * V * slope / (MASS + added))


def float_design(amplitude: float, added: float, bulk_modulus: float | None) -> Design:
    """Return a float without drag in the linear profile, at rest `amplitude` below its neutral depth."""
    body = {
        "kind": "rigid", "name": "Float", "mass": MASS, "volume": volume_for(bulk_modulus), "position": [0.0, 0.0, 0.0],
        "center_of_mass": [0.0, 0.0, 0.05], "inertia": {"xx": 1.0, "yy": 1.0, "zz": 1.0}, "bulk_modulus": bulk_modulus,
    }  # fmt: skip
    changed: dict[str, Any] = document(initial={"position": [0.0, 0.0, NEUTRAL + amplitude]})
    changed["vehicle"] |= {
        "components": [body], "damping": {},
        "hydrodynamics": {
            "kind": "coefficients", "drag_zero": 1e-300,
            "provenance": {"title": "None", "source": "No forces: the float swings undamped."},
        },
    }  # fmt: skip
    if added:
        matrix = np.zeros((6, 6))
        matrix[2, 2] = added
        changed["vehicle"]["added_mass"] = {"matrix": matrix.tolist(), "density": SURFACE}
    length = PERIODS * 2.0 * math.pi / frequency(added, bulk_modulus)
    profile = {"kind": "density_profile", "depths": [0.0, DEEPEST], "densities": [SURFACE, SURFACE + SLOPE * DEEPEST]}
    changed["mission"] |= {
        "environment": {"water": profile, "gravity": GRAVITY}, "duration": length,
        "solver": {"model": "spatial", "tolerance": 1e-11, "output_interval": length / 1000.0},
    }  # fmt: skip
    return parse_design(changed)


@cache
def oscillations() -> tuple[Oscillation, ...]:
    """Let go a stiff float without and with added mass, 20 m off, and one that gives way, 0.02 m off."""
    cases = (
        ("stiff, without added mass", 20.0, 0.0, None),
        ("stiff, with added mass", 20.0, MASS / 2.0, None),
        ("compressible, with added mass", 0.02, MASS / 2.0, BULK_MODULUS),
    )
    return tuple(
        Oscillation(name, amplitude, frequency(added, K), simulate(float_design(amplitude, added, K)))
        for name, amplitude, added, K in cases
    )
