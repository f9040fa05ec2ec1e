"""Owns the comparison of the quad glider with its movable-mass twin at equal energy, which docs/control.md tells of.

Both fly with the same loops, net buoyancy by `Drive` and pitch. The twin's net buoyancy is then changed until both take
the same energy an hour, over one straight and one turning cycle of the yo-yo. The moments that the loops add to are set
for each glider so that its steady pitch is what is wanted. Every command is obeyed: there is no deadband.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from docs.control_studies import HOUR, flown, turned
from models.presets.quad_control import BANK, SLOPE, Drive, cascade
from models.run import Run

STIFFNESS = 1.2
"""Weight times metacentric height, N m/rad: what a radian of pitch takes besides the loop."""
STRAIGHT: dict[str, Any] = {"kind": "heading", "heading": 0.0}
TURNING = 0.25
"""Bank wanted in the turning cycle, rad; without an integral about half of it is reached."""
BANKS = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0)
STEP, WITHIN, STEP_DEPTH, STEP_TIME = math.radians(45.0), math.radians(2.0), 20.0, 400.0
"""Step of the heading, within what it counts as settled (rad), depth at which it is asked for (m), time watched (s)."""
MISSING = 0.01
"""More of the wish for heave, pitch and roll missing than this counts as beyond the cells, N and N m."""


class Glider(NamedTuple):
    """A glider of the comparison: the twin or not, its drive, and its moments on dives and climbs (N m)."""

    twin: bool
    drive: Drive
    dive_moment: float
    climb_moment: float

    def controller(self, guidance: dict[str, Any], **changes: Any) -> dict[str, Any]:
        """Return its controller."""
        made = cascade(guidance, self.drive, deadband=0.0, **changes)
        made["pitch"] |= {"dive_moment": self.dive_moment, "climb_moment": self.climb_moment}
        return made


class Cycle(NamedTuple):
    """A whole cycle of a yo-yo: time (s), energy (J), way through the water (m), of that what steering took (J)."""

    time: float
    energy: float
    way: float

    @property
    def per_hour(self) -> float:
        """Energy an hour, J."""
        return self.energy * HOUR / self.time

    @property
    def per_km(self) -> float:
        """Energy per kilometre, J/km."""
        return 1e3 * self.energy / self.way


class Turn(NamedTuple):
    """A steady turn in a dive: bank (rad), radius (m), pitch (rad), and what is missing of the wish (N and N m)."""

    bank: float
    radius: float
    pitch: float
    missing: float


class Step(NamedTuple):
    """A step of the heading: run, time to settle (s), and what it took beyond going straight on (J)."""

    run: Run
    settled: float
    energy: float


def tuned(twin: bool, drive: Drive) -> Glider:
    """Return a glider whose moments give the pitch wanted on dives and climbs."""
    glider = Glider(twin, drive, -drive.moment, drive.moment)
    for _ in range(2):
        run = flown(glider.controller(STRAIGHT), _longest(drive), twin=twin)
        off = []
        for phase, target in ((0.0, drive.dive), (1.0, drive.climb)):
            inside = _steady(run, phase)
            off.append((target - float(np.median(run.values["theta"][inside]))) * (SLOPE["proportional"] + STIFFNESS))
        glider = glider._replace(dive_moment=glider.dive_moment + off[0], climb_moment=glider.climb_moment + off[1])
    return glider


def _longest(drive: Drive) -> float:
    """Return a time in which three dives begin, s."""
    return 3.2 * HOUR / drive.heave + HOUR


def _steady(run: Run, phase: float) -> np.ndarray:
    """Return which samples are of a phase and in the middle of the band, (samples,)."""
    z = run.values["z"]
    return np.asarray((run.values["phase"] == phase) & (z > 35.0) & (z < 70.0))


def cycle(glider: Glider, guidance: dict[str, Any]) -> Cycle:
    """Return the second cycle of a yo-yo, from one beginning of a dive to the next."""
    run = flown(glider.controller(guidance), _longest(glider.drive), twin=glider.twin)
    begin, end = [event.time for event in run.events if event.kind == "dive"][:2]
    k = np.searchsorted(run.times, [begin, end])
    v = run.values
    way = np.hypot(np.diff(v["x"][k[0] : k[1] + 1]), np.diff(v["y"][k[0] : k[1] + 1])).sum()
    return Cycle(end - begin, float(v["battery_energy"][k[1]] - v["battery_energy"][k[0]]), float(way))


def both_cycles(glider: Glider) -> tuple[Cycle, Cycle]:
    """Return the straight and the turning cycle."""
    return cycle(glider, STRAIGHT), cycle(glider, {"kind": "roll", "roll": TURNING})


def rate(cycles: tuple[Cycle, Cycle]) -> float:
    """Return the energy an hour over both cycles, J."""
    return HOUR * (cycles[0].energy + cycles[1].energy) / (cycles[0].time + cycles[1].time)


def of_equal_energy(quad: Glider) -> Glider:
    """Return the twin with the net buoyancy at which it takes the quad glider's energy an hour."""
    wanted = rate(both_cycles(quad))

    def excess(heave: float) -> float:
        return rate(both_cycles(tuned(True, replace(quad.drive, heave=heave)))) - wanted

    heave = brentq(excess, 0.93 * quad.drive.heave, 1.12 * quad.drive.heave, xtol=2e-3 * quad.drive.heave)
    return tuned(True, replace(quad.drive, heave=float(heave)))


def steady_turn(glider: Glider, bank: float) -> Turn:
    """Return the turn at the end of a long dive in which so much bank is asked for, limited by the cells alone."""
    controller = glider.controller({"kind": "roll", "roll": bank}, vertical=_sinking(glider))
    controller["lateral"]["roll_loop"] = BANK | {"limit": 2.0}
    run = flown(controller, _longest(glider.drive) / 4.0, twin=glider.twin)
    last = np.flatnonzero((run.values["z"] > 60.0) & (run.values["z"] < 85.0))
    v = {name: column[last] for name, column in run.values.items()}
    short = sum(np.abs(v[f"{axis}_missing"]) for axis in ("heave", "pitch_moment", "roll_moment"))
    radius = np.hypot(v["x_dot"], v["y_dot"]) / np.abs(v["turn_rate"])
    return Turn(*(float(np.median(x)) for x in (np.abs(v["phi"]), radius, v["theta"], short)))


def _sinking(glider: Glider) -> dict[str, Any]:
    """Return the guidance of a dive without end."""
    return {"kind": "heave", "heave": -glider.drive.heave}


def heading_step(glider: Glider) -> Step:
    """Return a step of the heading in a steady dive: started from the state of a straight one at `STEP_DEPTH`."""
    before = flown(glider.controller(STRAIGHT), 600.0, twin=glider.twin)
    k = int(np.searchsorted(before.values["z"], STEP_DEPTH))
    state = {name: float(column[k]) for name, column in before.values.items()}
    initial = {
        "position": [0.0, 0.0, state["z"]], "roll": state["phi"], "pitch": state["theta"], "yaw": state["psi"],
        "velocity": [state["u"], state["v"], state["w"]], "angular_velocity": [state["p"], state["q"], state["r"]],
        "extensions": dict(zip(before.cells, before.cell_values["extension"][k].tolist(), strict=True)),
    }  # fmt: skip
    guidance = ({"kind": "heading", "heading": STEP}, STRAIGHT)
    run, straight = (
        flown(glider.controller(g, vertical=_sinking(glider)), STEP_TIME, twin=glider.twin, interval=1.0,
              initial=initial)
        for g in guidance
    )  # fmt: skip
    settled = float(run.times[np.flatnonzero(np.abs(turned(run.values["psi"] - STEP)) > WITHIN)[-1]])
    taken = float(run.values["battery_energy"][-1] - straight.values["battery_energy"][-1])
    return Step(run, settled, taken)


def _travel(run: Run) -> float:
    """Return the longest time that a part travels between dive and climb, s."""
    inside = _steady(run, 0.0) | _steady(run, 1.0)
    rates = [part.rate_limit for _, part in run.design.vehicle.actuated]
    spans = np.ptp(run.cell_values["extension"][inside], axis=0)
    return float(max(span / rate for span, rate in zip(spans, rates, strict=True) if rate is not None))


class Compared(NamedTuple):
    """One glider's figures: cycles, turns by the bank asked for, the step, speed (m/s) and path (rad) of a dive.

    `travel` is how long the part that travels longest needs from dive to climb, s.
    """

    glider: Glider
    cycles: tuple[Cycle, Cycle]
    turns: tuple[Turn, ...]
    step: Step
    speed: float
    path: float
    travel: float

    @property
    def within(self) -> tuple[Turn, ...]:
        """The turns that its cells can make."""
        return tuple(turn for turn in self.turns if turn.missing < MISSING)

    def radius_at(self, bank: float) -> float:
        """Return the radius at a bank (rad), between two turns: radius times the sine of bank hardly changes, m."""
        banks = [turn.bank for turn in self.within]
        products = [turn.radius * math.sin(turn.bank) for turn in self.within]
        return float(np.interp(bank, banks, products)) / math.sin(bank)


def figures_of(glider: Glider) -> Compared:
    """Fly all that is compared."""
    run = flown(glider.controller(STRAIGHT), _longest(glider.drive), twin=glider.twin)
    steady, v = _steady(run, 0.0), run.values
    down, level = (float(np.median(x[steady])) for x in (v["z_dot"], np.hypot(v["x_dot"], v["y_dot"])))
    turns = tuple(steady_turn(glider, bank) for bank in BANKS)
    return Compared(
        glider, both_cycles(glider), turns, heading_step(glider), math.hypot(down, level), math.atan2(-down, level),
        _travel(run),
    )  # fmt: skip


@cache
def compared(drive: Drive) -> tuple[Compared, Compared, Compared]:
    """Return the quad glider, the twin at the same net buoyancy, and the twin at the same energy."""
    quad = tuned(False, drive)
    return figures_of(quad), figures_of(tuned(True, drive)), figures_of(of_equal_energy(quad))
