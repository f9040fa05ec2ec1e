"""What the palette adds weighs and displaces what its stated material and shape would, and floats where it says so."""

from __future__ import annotations

import math
from typing import Any

import pytest

from models.assemble import assemble
from models.components import Rigid
from models.design import Design, parse_design
from models.mass_properties import mass_balance
from models.presets import load_preset, preset_ids
from models.shapes import CylinderShape, FinShape, WingShape
from server.editing import apply_patch
from studio.changes import added
from studio.part_kinds import LEAD, NAMES, POLYETHYLENE, SAMPLER
from tests.studio.spiral import spiral_document


def with_new(design: Design, kind: str) -> Design:
    return apply_patch(design, added(design, kind))


def new_rigid(design: Design, kind: str) -> tuple[Rigid, Any]:
    part = with_new(design, kind).vehicle.components[-1]
    assert isinstance(part, Rigid)
    return part, part.shapes[0]


@pytest.mark.parametrize("preset", preset_ids())
@pytest.mark.parametrize("kind", sorted(set(NAMES) - {"rolling_mass"}))
def test_every_kind_can_be_simulated_in_every_glider(preset: str, kind: str) -> None:
    assert assemble(with_new(load_preset(preset), kind)).design.vehicle.components[-1].name.startswith(NAMES[kind])


def test_what_rolls_can_be_added_in_three_dimensions() -> None:
    assemble(with_new(parse_design(spiral_document()), "rolling_mass"))


@pytest.mark.parametrize("preset", ["canete-dual-bellows", "quad-bellows-glide"])
def test_masses_and_volumes_are_those_of_shape_and_material(preset: str) -> None:
    design = load_preset(preset)
    # three figures are kept
    for kind, density in (("wing", POLYETHYLENE), ("fin", POLYETHYLENE), ("ballast", LEAD), ("core_sampler", SAMPLER)):
        part, shape = new_rigid(design, kind)
        assert part.mass == pytest.approx(density * part.volume, rel=6e-3)
        match shape:
            case WingShape() | FinShape():
                drawn = shape.span * (shape.chord + (shape.tip_chord or shape.chord)) / 2.0 * shape.thickness
            case CylinderShape():
                drawn = math.pi * shape.radius**2 * shape.length
            case _:
                raise AssertionError(shape)
        assert part.volume == pytest.approx(drawn, rel=2e-2)


@pytest.mark.parametrize("kind", ["bellows", "piston", "bladder"])
def test_a_new_cell_floats_by_itself(kind: str) -> None:
    design = load_preset("three-cell-glider")
    before, after = mass_balance(design.vehicle), mass_balance(with_new(design, kind).vehicle)
    assert after.net_buoyancy(1000.0, 9.8) == pytest.approx(before.net_buoyancy(1000.0, 9.8), abs=1e-3)


@pytest.mark.parametrize("kind", ["bellows", "piston", "bladder", "movable_mass"])
def test_what_moves_grows_with_the_vehicle_and_still_floats(kind: str) -> None:
    small, large = load_preset("canete-dual-bellows"), load_preset("slocum-glide")  # 0.6 and 1.5 m long
    before, after = mass_balance(large.vehicle), mass_balance(with_new(large, kind).vehicle)
    part, usual = (with_new(design, kind).vehicle.components[-1] for design in (large, small))
    assert not isinstance(part, Rigid) and not isinstance(usual, Rigid)
    low, high = part.stroke
    assert high - low == pytest.approx(2.5 * (usual.stroke[1] - usual.stroke[0]), rel=1e-2)
    assert part.mass == pytest.approx(2.5**3 * usual.mass, rel=4e-2)  # in the sea it displaces more
    assert low < part.neutral < high
    if kind != "movable_mass":
        assert after.net_buoyancy(1025.0, 9.8) == pytest.approx(before.net_buoyancy(1025.0, 9.8), abs=0.1)


@pytest.mark.parametrize("size", [1e-3, 1e3])
@pytest.mark.parametrize("kind", ["bellows", "piston", "bladder", "movable_mass"])
def test_no_vehicle_makes_what_moves_absurd(kind: str, size: float) -> None:
    document = load_preset("canete-dual-bellows").model_dump(mode="json")
    for part in document["vehicle"]["components"]:
        part["shapes"] = []
        part["position"] = [size * x for x in part["position"]]
    design = parse_design(document)
    part = with_new(design, kind).vehicle.components[-1]
    assert not isinstance(part, Rigid)
    assert 0.003 < part.stroke[1] - part.stroke[0] < 1.0


def test_a_fin_stands_on_the_tail_and_the_sampler_under_the_hull() -> None:
    design = load_preset("quad-bellows-glide")
    fin, shape = new_rigid(design, "fin")
    root = fin.position[2] + shape.offset[2]
    assert fin.position[0] < -0.8 and root == pytest.approx(-0.0534333, abs=1e-3)
    sampler, tube = new_rigid(design, "core_sampler")
    assert sampler.position[2] == pytest.approx(0.0534333 + tube.radius, abs=1e-3)
