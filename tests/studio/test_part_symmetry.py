"""Mirror images and partners: a mirror image of a mirror image is the part itself, and the glider stays in balance."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import TypeAdapter

from models.components import Component, MovableMass, RollingMass
from models.design import Design, parse_design
from models.mass_properties import component_center_of_mass, mass_balance
from models.presets import load_preset, preset_ids
from models.problems import DesignError
from server.editing import apply_patch
from studio.part_patches import mirror, moved
from studio.part_symmetry import is_its_own_image, mirrored, partners
from tests.studio.spiral import spiral_document

COMPONENT: TypeAdapter[Component] = TypeAdapter(Component)
ACROSS = np.array([1.0, -1.0, 1.0])


def image_of(component: Component) -> Component:
    return COMPONENT.validate_python(mirrored(component))


def with_part(part: Component) -> Design:
    document = load_preset("quad-bellows-glide").model_dump(mode="json")
    document["vehicle"]["components"].append(part.model_dump(mode="json"))
    return Design.model_validate(document)


ROLLER = RollingMass(
    kind="rolling_mass", name="Roller", mass=0.4, position=(0.1, 0.2, 0.05), pivot=(0.1, 0.18, 0.0),
    axis=(1.0, 0.3, -0.2), angle_range=(-1.0, 0.8), neutral_angle=0.1,
)  # fmt: skip
SLIDER = MovableMass(
    kind="movable_mass", name="Port slider", mass=0.4, position=(0.1, -0.2, 0.05), axis=(1.0, 0.5, 0.2),
    extension_range=(-0.1, 0.1), neutral_extension=0.02,
)  # fmt: skip


@pytest.mark.parametrize("preset", preset_ids())
def test_the_image_of_the_image_is_the_part(preset: str) -> None:
    for component in load_preset(preset).vehicle.components:
        assert image_of(image_of(component)) == component


@pytest.mark.parametrize("part", [ROLLER, SLIDER])
@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_a_mirrored_mass_moves_as_in_a_mirror(part: RollingMass | MovableMass, share: float) -> None:
    image = image_of(part)
    assert isinstance(image, RollingMass | MovableMass)
    low, high = part.stroke
    extension = low + share * (high - low)
    there = component_center_of_mass(part, extension) * ACROSS
    assert component_center_of_mass(image, extension) == pytest.approx(there, abs=1e-12)


def test_the_cells_of_the_quad_glider_are_partners_and_the_hull_has_none() -> None:
    design = load_preset("quad-bellows-glide")
    names = [c.name for c in design.vehicle.components]
    paired = {names[i]: names[j] for i, j in enumerate(partners(design.vehicle.components)) if j is not None}
    assert paired == {
        "Front port cell": "Front starboard cell", "Front starboard cell": "Front port cell",
        "Rear port cell": "Rear starboard cell", "Rear starboard cell": "Rear port cell",
    }  # fmt: skip
    assert all(is_its_own_image(c) for c in design.vehicle.components if c.name not in paired)


@pytest.mark.parametrize(("field", "value"), [("mass", 0.90001), ("pleats", 9), ("position", (0.6, 0.2001, 0.0))])
def test_what_differs_is_no_partner(field: str, value: object) -> None:
    components = list(load_preset("quad-bellows-glide").vehicle.components)
    components[5] = components[5].model_copy(update={field: value})
    assert partners(tuple(components))[4:6] == (None, None)


def test_names_colours_and_the_last_digits_may_differ() -> None:
    components = list(load_preset("quad-bellows-glide").vehicle.components)
    update = {"name": "Other", "color": "#123456", "position": (0.6, 0.2 + 1e-10, 0.0)}
    components[5] = components[5].model_copy(update=update)
    assert partners(tuple(components))[4] == 5


@pytest.mark.parametrize("part", [ROLLER, SLIDER])
def test_a_pair_leaves_the_centre_of_mass_in_the_plane(part: RollingMass | MovableMass) -> None:
    design = with_part(part)
    index = len(design.vehicle.components) - 1
    paired = apply_patch(design, mirror(design, index))
    assert partners(paired.vehicle.components)[index] == index + 1
    balance = mass_balance(paired.vehicle)
    assert balance.center_of_mass[1] == pytest.approx(0.0, abs=1e-12)
    assert balance.inertia[0, 1] == pytest.approx(0.0, abs=1e-12)
    assert balance.mass == pytest.approx(mass_balance(design.vehicle).mass + part.mass, rel=1e-12)


def test_both_are_named_by_their_side() -> None:
    roller, slider = with_part(ROLLER), with_part(SLIDER)
    named = apply_patch(roller, mirror(roller, 11)).vehicle.components
    assert [c.name for c in named[11:]] == ["Roller starboard", "Roller port"]
    named = apply_patch(slider, mirror(slider, 11)).vehicle.components
    assert [c.name for c in named[11:]] == ["Port slider", "Starboard slider"]


@pytest.mark.parametrize(("sense", "turned"), [("same", 0.08), ("opposite", -0.04)])
def test_the_schedule_comes_along_where_asked(sense: str, turned: float) -> None:
    design = with_part(SLIDER)
    points = [{"time": 5.0, "extension": 0.08, "shape": "ramp"}]
    patch = [
        {"op": "add", "path": "/mission/control/schedules/-", "value": {"cell": "Port slider", "points": points}},
        {"op": "add", "path": "/mission/initial/extensions/Port slider", "value": 0.08},
    ]
    design = apply_patch(design, patch)
    alone = apply_patch(design, mirror(design, 11))
    assert "Starboard slider" not in {s.cell for s in alone.mission.control.schedules}
    paired = apply_patch(design, mirror(design, 11, sense))  # type: ignore[arg-type]
    (schedule,) = [s for s in paired.mission.control.schedules if s.cell == "Starboard slider"]
    assert schedule.points[0].extension == pytest.approx(turned, abs=1e-12)
    assert (schedule.points[0].time, schedule.points[0].shape) == (5.0, "ramp")
    assert paired.mission.initial.extensions["Starboard slider"] == pytest.approx(turned, abs=1e-12)


def test_opposite_commands_stay_within_the_stops() -> None:
    lopsided = SLIDER.model_copy(update={"extension_range": (0.0, 0.1)})
    design = with_part(lopsided)
    patch = [{"op": "add", "path": "/mission/initial/extensions/Port slider", "value": 0.1}]
    design = apply_patch(design, patch)
    paired = apply_patch(design, mirror(design, 11, "opposite"))
    assert paired.mission.initial.extensions["Starboard slider"] == 0.0


def test_what_stands_in_the_plane_has_no_mirror_image() -> None:
    design = load_preset("canete-dual-bellows")
    with pytest.raises(DesignError) as refused:
        mirror(design, 1)
    (problem,) = refused.value.problems
    assert problem.pointer == "/mission/solver/model"
    assert (
        "Front bellows" in problem.message
        and problem.hint == "choose the spatial model first, then give it a position y"
    )
    with pytest.raises(DesignError, match="stands in the plane of symmetry") as refused:
        mirror(parse_design(spiral_document()), 2)
    (problem,) = refused.value.problems
    assert (problem.pointer, problem.hint) == ("/vehicle/components/2/position/1", "give it a position y first")


def test_what_has_a_partner_gets_no_second_one() -> None:
    with pytest.raises(DesignError, match="'Front port cell' is mirrored by 'Front starboard cell' already"):
        mirror(load_preset("quad-bellows-glide"), 4)


def test_moving_a_part_changes_nothing_but_the_order() -> None:
    design = load_preset("canete-dual-bellows")
    plain = design.model_dump(mode="json")
    for part in plain["vehicle"]["components"][1:]:
        part["color"] = None
    design = Design.model_validate(plain)
    other = apply_patch(design, moved(design, 2, 0))
    assert [c.name for c in other.vehicle.components] == ["Rear bellows", "Body", "Front bellows"]
    by_name = {c.name: c for c in other.vehicle.components}
    colors = {c.name: c.color for c in other.vehicle.components}
    # each keeps the colour that its place gave it before
    assert colors == {"Rear bellows": "#4fc3a1", "Body": "#9fb3c8", "Front bellows": "#f2b134"}
    for part in design.vehicle.components:
        assert by_name[part.name].model_copy(update={"color": None}) == part.model_copy(update={"color": None})
    assert mass_balance(other.vehicle).mass == pytest.approx(mass_balance(design.vehicle).mass, rel=1e-15)
    assert moved(design, 1, 1) == []
    for index, to in ((0, 3), (-1, 0), (3, 0)):
        with pytest.raises(DesignError, match="no such component"):
            moved(design, index, to)


def test_the_plane_of_symmetry_is_kept_to_the_last_digit() -> None:
    assert math.copysign(1.0, mirrored(load_preset("slocum-glide").vehicle.components[0])["position"][1]) == 1.0
