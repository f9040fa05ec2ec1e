"""Owns what a run gives reason to doubt: data left behind, energy that does not add up, weight that turns it over."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.hydrodynamics import PolarTable
from models.hydrodynamics_angles import AngleTable
from models.hydrodynamics_coefficients import CoefficientForm
from models.margins import down_along, immersed, offset_along
from models.moments import moment_in_words
from models.problems import Problem, pointer_to
from models.run import Run
from models.water import profile_range

POINTER = "/vehicle/hydrodynamics"
SLOWEST = 1e-3
"""Below this speed (m/s) the direction of the flow means nothing."""
MOST_SIDESLIP = np.deg2rad(30.0)
"""Sideslip beyond which a table measured without any says little, rad."""
MOST_SQUEEZED = 0.1
"""Share of its volume beyond which a part's constant stiffness says little."""
LEAST_OFFSET = 1e-6
"""Centres closer than this (m) are one."""
ROLL_OVER = "weight and buoyancy do not right it in roll"
SHORT, SELDOM = 0.05, 0.02
"""A controller is short of what it asks for by more than the first share, in more than the second of a run."""
LARGEST_RESIDUAL = 1e-3
"""Share of the energy exchanged above which a run is not to be trusted."""

Flags = NDArray[np.bool_]
Spans = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class Doubt(Problem):
    """What is doubtful about samples of a run; `times` are the stretches that they cover, s, in order."""

    times: Spans = ()

    def as_dict(self) -> dict[str, Any]:
        """Return it as the JSON object that every problem is: the stretches are for who draws the run."""
        return Problem(self.pointer, self.message, self.limit, self.hint).as_dict()


def spans(run: Run, flags: Flags) -> Spans:
    """Return the stretches of time (s) that marked samples cover; a lone one reaches half-way to its neighbours."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    middles = (run.times[1:] + run.times[:-1]) / 2.0
    borders = np.concatenate([run.times[:1], middles, run.times[-1:]])
    return tuple((float(borders[a]), float(borders[b])) for a, b in edges.reshape(-1, 2).tolist())


def run_warnings(run: Run) -> Iterator[Problem]:
    """Yield everything about a run that its reader should know, each with the number that shows it."""
    yield from inaccurate(run)
    yield from outside_data(run)
    yield from squeezed_too_far(run)
    yield from turning_over(run)
    yield from short_of_control(run)


def inaccurate(run: Run) -> Iterator[Problem]:
    """Yield a warning where the balance of energy leaves too much unexplained."""
    residual = run.relative_residual
    if not residual <= LARGEST_RESIDUAL:
        fixed = run.design.mission.solver.method == "rk4"
        yield Problem(
            f"/mission/solver/{'step' if fixed else 'tolerance'}",
            f"the run is not accurate: {100.0 * residual:.2g} % of the energy exchanged is unexplained",
            limit=LARGEST_RESIDUAL,
            hint="use a smaller step, or the adaptive method" if fixed else "use a smaller tolerance",
        )


def outside_data(run: Run) -> Iterator[Problem]:
    """Yield a warning for each way in which samples left the data that forces and water come from."""
    match run.design.vehicle.hydrodynamics:
        case PolarTable() as source:
            yield from _outside_polar(run, source)
            yield from sideways_in_table(run, source)
        case AngleTable() as source:
            yield from _outside_angles(run, source)
        case CoefficientForm() as source:
            yield from _outside_coefficients(run, source)
    if run.model == "spatial":
        yield from _outside_water(run)


def _outside_polar(run: Run, table: PolarTable) -> Iterator[Problem]:
    speed, moving = run.values["speed"], run.values["speed"] > 0.0
    past = np.abs(run.values["alpha"]) > np.pi / 2
    if past.any():
        largest = np.rad2deg(np.abs(run.values["alpha"]).max())
        yield Doubt(
            f"{POINTER}/row_alpha_deg",
            f"{_share(past)} of the run is past 90 deg of attack (up to {largest:.0f} deg), where nothing was "
            "measured: the data are reflected",
            limit=90.0, times=spans(run, past),
        )  # fmt: skip
    low, high = table.speeds[0], table.speeds[-1]
    for off, what, bound in (
        (moving & (speed < low), "slower than", low),
        (speed > high, "faster than", high),
    ):
        if off.any():
            yield Doubt(
                f"{POINTER}/row_speed",
                f"{_share(off)} of the run is {what} the data's {bound:g} m/s: coefficients are held there",
                limit=bound, times=spans(run, off),
            )  # fmt: skip


def _outside_angles(run: Run, table: AngleTable) -> Iterator[Problem]:
    slips = (-table.beta_deg[-1] if table.mirrored else table.beta_deg[0], table.beta_deg[-1])
    for name, field, (low, high) in (
        ("alpha", "alpha_deg", (table.alpha_deg[0], table.alpha_deg[-1])),
        ("beta", "beta_deg", slips),
    ):
        yield from _outside_angle(
            run, name, field, (low, high), "drag, side force, lift and moments of its edge are held"
        )


def _outside_coefficients(run: Run, source: CoefficientForm) -> Iterator[Problem]:
    for name, limit in (("alpha", source.alpha_limit_deg), ("beta", source.beta_limit_deg)):
        if name in run.values:
            yield from _outside_angle(run, name, f"{name}_limit_deg", (-limit, limit), "the formulas go on")


def _outside_angle(run: Run, name: str, field: str, bounds: tuple[float, float], rule: str) -> Iterator[Problem]:
    angle = np.rad2deg(run.values[name])
    moving = run.values["speed"] > SLOWEST
    off = moving & ((angle < bounds[0] - 1e-9) | (angle > bounds[1] + 1e-9))
    if off.any():
        what = {"alpha": "angles of attack", "beta": "sideslips"}[name]
        worst = angle[off][np.abs(angle[off]).argmax()]
        yield Doubt(
            f"{POINTER}/{field}",
            f"{_share(off)} of the run is outside the {what} of the data, {bounds[0]:g} to {bounds[1]:g} deg "
            f"(at worst {worst:.0f} deg): {rule}",
            limit=bounds[1], times=spans(run, off),
        )  # fmt: skip


def _outside_water(run: Run) -> Iterator[Problem]:
    environment, z = run.design.mission.environment, run.values["z"]
    current = environment.current
    for field, depths in (("water", profile_range(environment.water)), ("current", getattr(current, "depths", None))):
        if depths is None:
            continue
        for off, where, bound in (
            (z < depths[0], f"above the first level of the {field} at {depths[0]:g} m", depths[0]),
            (
                z > depths[-1] + 1e-6,
                f"below the deepest level of the {field} at {depths[-1]:g} m (down to {z.max():.4g} m)", depths[-1],
            ),
        ):  # fmt: skip
            if off.any():
                pointer = f"/mission/environment/{field}/depths"
                message = f"{_share(off)} of the run is {where}: its values are held there"
                yield Doubt(pointer, message, limit=bound, times=spans(run, off))
    times = getattr(current, "times", (0.0,))
    late = (run.times < times[0]) | (run.times > times[-1])
    if len(times) > 1 and late.any():
        yield Doubt(
            "/mission/environment/current/times",
            f"{_share(late)} of the run is outside the times of the current, {times[0]:g} to {times[-1]:g} s: "
            "it is held there",
            limit=times[-1], times=spans(run, late),
        )  # fmt: skip


def short_of_control(run: Run) -> Iterator[Problem]:
    """Yield a warning for each of heave, pitch and roll moment that a controller asks for and the cells do not make."""
    for name, words, unit in (
        ("heave", "heave", "N"), ("pitch_moment", "pitch moment", "N m"), ("roll_moment", "roll moment", "N m"),
    ):  # fmt: skip
        asked, left = run.values.get(f"{name}_wanted"), run.values.get(f"{name}_missing")
        if asked is None or left is None or not np.isfinite(left).any():
            return
        missing, wanted = np.nan_to_num(np.abs(left)), np.nan_to_num(np.abs(asked))
        short = missing > SHORT * wanted.max()
        if np.mean(short) > SELDOM:
            worst = int(missing.argmax())
            yield Doubt(
                "/mission/control/controller/allocation",
                f"{_share(short)} of the run the cells make less {words} than is asked for, by up to "
                f"{missing[worst]:.3g} of {wanted[worst]:.3g} {unit}",
                limit=0.0, hint="ask for less, give cells longer strokes, or weigh what matters more",
                times=spans(run, short),
            )  # fmt: skip


def squeezed_too_far(run: Run) -> Iterator[Problem]:
    """Yield a warning where pressure leaves the range in which a stiffness describes compression."""
    if run.model != "spatial":
        return
    pressure = run.values["pressure"]
    deepest = float(pressure.max())
    for i, component in enumerate(run.design.vehicle.components):
        stiffness = getattr(component, "bulk_modulus", None)
        if stiffness is not None and deepest > MOST_SQUEEZED * stiffness:
            yield Doubt(
                pointer_to("vehicle", "components", i, "bulk_modulus"),
                f"pressure takes {min(100.0 * deepest / stiffness, 100.0):.0f} % of the volume of '{component.name}': "
                "a constant stiffness is meant for a few",
                limit=MOST_SQUEEZED, hint="give a larger one, or stay shallower",
                times=spans(run, pressure > MOST_SQUEEZED * stiffness),
            )  # fmt: skip


def turning_over(run: Run) -> Iterator[Problem]:
    """Yield a warning where weight and buoyancy turn the glider over rather than right it, in all or in roll."""
    x, y, z = offset_along(run)
    kx, ky, kz = down_along(run)
    below = immersed(run)
    across = y * ky + z * kz
    for what, righting in (("the centre of buoyancy lies below that of mass", x * kx + across), (ROLL_OVER, across)):
        off = below & (righting < -LEAST_OFFSET)
        if off.any():
            first = int(off.argmax())
            yield Doubt(
                "/vehicle/components",
                f"{what} for {_share(off)} of the run, first at "
                f"{moment_in_words(run.times[first], run.times[-1])} "
                f"(by up to {-1e3 * righting[off].min():.3g} mm): it tends to turn over",
                limit=0.0, hint="place weight lower, or keep the cells that cause it from extending so far",
                times=spans(run, off),
            )  # fmt: skip
            return


def sideways_in_table(run: Run, table: PolarTable) -> Iterator[Problem]:
    """Yield a warning where a table measured without sideslip is used across the flow."""
    if run.model != "spatial":
        return
    off = (run.values["speed"] > SLOWEST) & (np.abs(run.values["beta"]) > MOST_SIDESLIP)
    if off.any():
        worst = np.rad2deg(np.abs(run.values["beta"][off]).max())
        yield Doubt(
            f"{POINTER}/lateral",
            f"{_share(off)} of the run has more than {np.rad2deg(MOST_SIDESLIP):.0f} deg of sideslip (up to "
            f"{worst:.0f} deg), for which the table was not measured",
            limit=30.0, times=spans(run, off),
        )  # fmt: skip


def _share(flags: Flags) -> str:
    share = 100.0 * float(np.mean(flags))
    return f"{share:.0f} %" if share >= 0.5 else "less than 1 %"
