"""Owns the glides that docs/paper.md compares: the preset, edited, and what each prints at 6, 10 and 20 s."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from docs.printed_model import Forms, Glide, PrintedModel
from models.design import Design, parse_design
from models.hydrodynamics import PolarTable
from models.mass_properties import trim_ballast
from models.presets import load_preset
from models.run import Run
from models.simulate import simulate

Array = NDArray[np.float64]
Edit = Callable[[dict[str, Any]], None]
PRESET = "canete-dual-bellows"
TIMES = (6.0, 10.0, 20.0)
"""Instants at which glides are compared, s: amid the dive, at the switch, at the end."""
DEEP = 5.0
"""Start depth of the sensitivity runs, m: no variant reaches the surface from there."""


class Sample(NamedTuple):
    """Depth gained (m), distance (m) and pitch (deg) at one instant."""

    depth: float
    distance: float
    pitch: float


@dataclass(frozen=True)
class Case:
    """One glide of a comparison: its path from the start, and how it ended."""

    label: str
    time: Array
    distance: Array
    depth: Array
    pitch: Array
    ending: str
    reference: bool = False

    def at(self, t: float) -> Sample | None:
        """Return the sample at t; None where the glide ended before."""
        if self.time[-1] < t - 1e-9:
            return None
        return Sample(*(float(np.interp(t, self.time, y)) for y in (self.depth, self.distance, self.pitch)))


@dataclass(frozen=True)
class Study:
    """Several glides that differ in one part of the model."""

    name: str
    title: str
    cases: tuple[Case, ...]
    pitch_relative: bool = False
    """Draw the pitch as its difference from the reference's: the curves would coincide."""


@cache
def preset() -> Design:
    """Return the preset as it is."""
    return load_preset(PRESET)


@cache
def preset_run() -> Run:
    """Return the preset's glide."""
    return simulate(preset())


def edited(*edits: Edit, trimmed: bool = False) -> Design:
    """Return the preset with its document changed; `trimmed` makes it neutral again."""
    document = preset().model_dump(mode="json")
    for edit in edits:
        edit(document)
    design = parse_design(document)
    return trim_ballast(design)[0] if trimmed else design


def deep(document: dict[str, Any]) -> None:
    """Start at `DEEP`."""
    document["mission"]["initial"]["position"] = [0.0, 0.0, DEEP]


def pitch_damping(factor: float) -> Edit:
    """Scale C33."""
    return lambda d: d["vehicle"]["damping"].update(pitch=factor * d["vehicle"]["damping"]["pitch"])


def center_of_mass(l_gz: float) -> Edit:
    """Put the centre of mass l_gz (m) below the origin."""
    return lambda d: d["vehicle"]["mass_properties"].update(center_of_mass=[0.0, 0.0, l_gz])


def force_law(law: str, speed: float | None) -> Edit:
    """Choose the law and the data's speed (m/s; None: their mean)."""
    return lambda d: d["vehicle"]["hydrodynamics"].update(law=law, speed=speed)


def added_mass(*, munk_twice: bool) -> Edit:
    """Turn the added mass on; `munk_twice` leaves the Munk moment in the table as well."""

    def edit(document: dict[str, Any]) -> None:
        document["vehicle"]["added_mass"]["enabled"] = True
        document["vehicle"]["hydrodynamics"]["includes_munk_moment"] = not munk_twice

    return edit


def bellows_as_printed(document: dict[str, Any]) -> None:
    """Take Eq. 10 as printed."""
    for component in document["vehicle"]["components"]:
        if component["kind"] == "bellows":
            component["as_printed"] = True


def body_volume_as_printed(document: dict[str, Any]) -> None:
    """Give the body all of Table II's V0 and leave the cells' volumes on top of it."""
    declared = document["vehicle"]["mass_properties"]["mass"]
    document["vehicle"]["components"][0]["volume"] = declared / document["mission"]["environment"]["water"]["density"]


def solver(**changes: Any) -> Edit:
    """Change the solver's settings."""
    return lambda d: d["mission"]["solver"].update(changes)


def table() -> PolarTable:
    """Return the preset's hydrodynamic data."""
    return preset().vehicle.hydrodynamics


def case_of_run(label: str, run: Run, *, reference: bool = False) -> Case:
    """Make a case of a run."""
    d = run.data
    x, z = d["x"].values, d["z"].values
    pitch = np.degrees(d["theta"].values)
    return Case(label, d["time"].values, x - x[0], z - z[0], pitch, run.status.name, reference)


def case_of_glide(label: str, glide: Glide) -> Case:
    """Make a case of a glide by the paper's equations in world axes."""
    x, z, theta = glide.state[:3]
    return Case(label, glide.time, x - x[0], z - z[0], np.degrees(theta), glide.ending)


def _deep_case(label: str, *edits: Edit, reference: bool = False, trimmed: bool = False) -> Case:
    return case_of_run(label, simulate(edited(deep, *edits, trimmed=trimmed)), reference=reference)


def damping_study() -> Study:
    """Return the glides with C33 scaled from a tenth to ten times."""
    C33 = preset().vehicle.damping.pitch
    cases = [
        _deep_case(f"{factor * C33:g} N m s", pitch_damping(factor), reference=factor == 1.0)
        for factor in (0.1, 0.3, 1.0, 3.0, 10.0)
    ]
    return Study("c33", "Pitch damping C33", tuple(cases))


def center_study() -> Study:
    """Return the glides with the centre of mass 0.5 to 3 mm below the centre of buoyancy."""
    heights = (0.5, 0.75, 1.0, 1.5, 2.0, 3.0)
    cases = [_deep_case(f"{h:g} mm", center_of_mass(1e-3 * h), reference=h == 1.0) for h in heights]
    return Study("lgz", "Height l_gz of the centre of mass", tuple(cases))


def source_study() -> Study:
    """Return the glides by the data of each speed and their mean, by either law."""
    cases = []
    for law, name in (("pchip", "PCHIP"), ("polynomial", "polynomials")):
        for speed in (*table().speeds, None):
            source = "mean" if speed is None else f"{speed:g} m/s"
            reference = law == "pchip" and speed is None
            cases.append(_deep_case(f"{name}, {source}", force_law(law, speed), reference=reference))
    return Study("source", "Data and law of the forces", tuple(cases), pitch_relative=True)


def added_mass_study() -> Study:
    """Return the glides without added mass, with it, and with the Munk moment counted twice."""
    cases = (
        _deep_case("off (preset)", reference=True),
        _deep_case("on", added_mass(munk_twice=False)),
        _deep_case("on, Munk moment twice", added_mass(munk_twice=True)),
    )
    return Study("added-mass", "Added mass", cases)


def printed_study() -> Study:
    """Return the glides with one of the paper's printed forms at a time, from the preset's own depth or deeper."""
    turned = PrintedModel(edited(deep), Forms(rotation=True)).glide()
    cases = (
        _deep_case("here", reference=True),
        _deep_case("Eq. 10 as printed", bellows_as_printed, trimmed=True),
        case_of_glide("Eqs. 6, 7 as printed", turned),
        _deep_case("V0 of Table II plus cells", body_volume_as_printed),
    )
    return Study("printed", "Forms as the paper prints them", cases)


def sensitivity_studies() -> tuple[Study, ...]:
    """Return the four studies of what the paper leaves open."""
    return damping_study(), center_study(), source_study(), added_mass_study()
