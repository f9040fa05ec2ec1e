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


def test_a_fin_stands_on_the_tail_and_the_sampler_under_the_hull() -> None:
    design = load_preset("quad-bellows-glide")
    fin, shape = new_rigid(design, "fin")
    root = fin.position[2] + shape.offset[2]
    assert fin.position[0] < -0.8 and root == pytest.approx(-0.0534333, abs=1e-3)
    sampler, tube = new_rigid(design, "core_sampler")
    assert sampler.position[2] == pytest.approx(0.0534333 + tube.radius, abs=1e-3)
