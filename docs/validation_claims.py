"""Owns what docs/validation.md claims: for each check what was found and what is demanded, as numbers."""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from docs import validation_conservation as conservation
from docs import validation_energy as energy
from docs import validation_equations as equations
from docs import validation_linear as linear
from docs import validation_motions as motions
from docs import validation_seawing as seawing
from docs import validation_slocum as slocum
from docs import validation_symmetries as symmetries
from docs import validation_trims as trims
from docs import validation_water as water
from docs.formatting import bound, num, order_of


class Claim(NamedTuple):
    """One demand: the number of the check, what is measured, what was found and the most it may be.

    Errors have no `digits`: only their size matters.
    """

    check: int
    words: str
    found: float
    demanded: float
    unit: str = ""
    digits: int | None = None

    @property
    def shown(self) -> str:
        """What was found: with its digits, or as a bound."""
        if self.digits is not None:
            return num(self.found, self.digits)
        return exactly(self.found) if self.demanded == 0.0 else bound(self.found)

    @property
    def limit(self) -> str:
        """What is demanded, with its unit."""
        limit = order_of(self.demanded).removeprefix("1 × ") if self.digits is None else f"{self.demanded:g}"
        return f"{limit} {self.unit}".strip()


def exactly(value: float) -> str:
    """Return an error that should be zero to the last bit: 0, or else its bound."""
    return "0" if value == 0.0 else bound(value)


def equation_claims() -> list[Claim]:
    """Return the claims of checks 1 and 2."""
    planar = max(max(case[1:]) for case in equations.planar_differences())
    spatial = max(float(case.relative.max()) for case in equations.spatial_differences())
    drifts = [c.theory - c.order for c in conservation.convergences() if c.what == "drift"]
    states = [abs(c.theory - c.order) for c in conservation.convergences() if c.what == "state"]
    allowed = conservation.ALLOWED
    return [
        Claim(1, "planar M, V, G beside the symbolic ones, relative", planar, equations.DEMANDED["planar"]),
        Claim(1, "spatial accelerations beside the independent ones, relative", spatial, equations.DEMANDED["spatial"]),
        Claim(2, "order of the energy drift: how far below 4 and 5", max(drifts), allowed, digits=2),
        Claim(2, "order of the states: how far from 4 and 5", max(states), allowed, digits=2),
    ]


def symmetry_claims() -> list[Claim]:
    """Return the claims of check 3."""
    demanded, plane, moved = symmetries.DEMANDED, symmetries.plane_cases(), symmetries.moved_cases()
    words = {"mirror": "mirrored", "yaw": "turned", "current": "carried by a current"}
    return [
        Claim(3, "spatial beside planar, states, relative", max(c.difference for c in plane), demanded["plane"]),
        Claim(3, "motion out of the plane", max(c.off_plane for c in plane), demanded["off plane"], "m, rad"),
        *(
            Claim(
                3, f"{words[kind]}, paths and attitudes",
                max(max(c.places[kind], c.angles[kind]) for c in moved), demanded[kind], "m, rad",
            )
            for kind in words
        ),
    ]  # fmt: skip


def motion_claims() -> list[Claim]:
    """Return the claims of checks 4 and 5."""
    falls, demanded = motions.falls(), motions.DEMANDED
    terminal = max(abs(f.speed / f.expected - 1.0) for f in falls)
    approach = max(float(np.abs(f.approach[1] - np.tanh(f.approach[0])).max()) for f in falls)
    rest = max(motions.resting_speeds().values())
    return [
        Claim(4, "terminal speed beside √(W / P_D), relative", terminal, demanded["terminal"]),
        Claim(4, "approach beside tanh, share of the terminal speed", approach, demanded["approach"]),
        Claim(4, "speed picked up by a neutral glider at rest", rest, demanded["rest"], "m/s, rad/s"),
        *(
            Claim(
                5, f"departure from a trim, {model}",
                float(slocum.departure(slocum.started_at_trim(0.0, model)).max()), slocum.FIXED_POINT,
                "rad, m/s, rad/s",
            )
            for model in ("planar", "spatial")
        ),
    ]  # fmt: skip


def energy_claims() -> list[Claim]:
    """Return the claims of checks 6 and 10."""
    residual = max(b.relative[energy.DEFAULT_TOLERANCE] for b in energy.balances())
    load, expected, _ = energy.hotel_bill()
    return [
        Claim(6, "energy residual of any preset at the default tolerance, share", residual, energy.DEMANDED["balance"]),
        Claim(10, "bill of an expansion, relative", max(b.difference for b in energy.bills()), energy.DEMANDED["bill"]),
        Claim(10, "hotel load, relative", abs(load / expected - 1.0), energy.DEMANDED["bill"]),
    ]


def published_claims() -> list[Claim]:
    """Return the claims of checks 7 and 8."""
    spiral = [
        Claim(7, f"{row.quantity.words.lower()} of the spiral beside the published one", scale * abs(row.difference),
              scale * row.demanded, "%" if row.quantity.relative else "deg", 3)
        for row in seawing.rows() for scale in (100.0 if row.quantity.relative else 1.0,)
    ]  # fmt: skip
    root = Claim(7, "spiral beside the root of the independent equations, deg or share", seawing.largest_from_root(),
                 seawing.OWN_DIGITS)  # fmt: skip
    solved = Claim(7, "spiral by simulation beside the trim, states", trims.largest_difference(), trims.DEMANDED,
                   "rad, m/s, rad/s")  # fmt: skip
    steady = [
        slocum.differences(case, run) for case in (*slocum.glides(), *slocum.polar()) for run in case.runs.values()
    ]
    words = ("angle of attack", "pitch", "speed")
    glides = [
        Claim(8, f"{word} of steady glides beside the closed form, relative", largest, slocum.DEMANDED)
        for word, largest in zip(words, np.max(steady, axis=0).tolist(), strict=True)
    ]
    stated = slocum.published()["shallowest_deg"]
    shallowest = abs(math.degrees(slocum.shallowest()) - stated)
    return [*spiral, root, solved, *glides, Claim(8, "shallowest glide beside 6.315 deg", shallowest, 5e-4, "deg", 4)]


def water_claims() -> list[Claim]:
    """Return the claims of check 9."""
    data = water.published()
    largest = float(np.abs(water.densities() - np.array(data["rho"])).max())
    closed = [abs(case.period * case.omega / (2.0 * math.pi) - 1.0) for case in water.oscillations()]
    paths = [case.largest for case in water.oscillations()]
    return [
        Claim(9, "density beside the published check values", largest, data["agreement"]["rho"], "kg/m³", 4),
        Claim(9, "period of a float beside the closed form, relative", max(closed), water.DEMANDED["period"]),
        Claim(9, "its path, share of the amplitude", max(paths), water.DEMANDED["path"]),
    ]


def linear_claims() -> list[Claim]:
    """Return the claims of check 11."""
    steps = linear.step_responses()
    return [
        Claim(11, "order of what a linear step response leaves: how far from 2",
              max(float(abs(case.orders - 2.0).max()) for case in steps), linear.ALLOWED, digits=2),
        Claim(11, "what it leaves at the smallest step, share of the response",
              max(case.share for case in steps), linear.DEMANDED, digits=4),
    ]  # fmt: skip


@cache
def claims() -> tuple[Claim, ...]:
    """Return every claim, in the order of the checks."""
    groups = (
        equation_claims, symmetry_claims, motion_claims, energy_claims, published_claims, water_claims, linear_claims,
    )  # fmt: skip
    return tuple(sorted((claim for group in groups for claim in group()), key=lambda claim: claim.check))
