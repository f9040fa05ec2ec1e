from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh

from models.presets import load_preset, preset_ids
from studio import meshes
from studio.attitude import rotate
from studio.bodies import bodies, drawn_length, x_axis_to
from studio.meshes import Mesh

SECTIONS = meshes.SECTIONS
INSCRIBED = SECTIONS / 2.0 * math.sin(2.0 * math.pi / SECTIONS) / math.pi
"""Area of the polygon that stands for a circle, as a share of the circle's: exact for every body of revolution."""


def solid(mesh: Mesh) -> trimesh.Trimesh:
    joined = trimesh.Trimesh(mesh.vertices, mesh.faces, process=True)
    joined.merge_vertices()
    return joined


ALL = {
    "hull": meshes.hull(0.6, 0.016, nose_length=0.06, tail_length=0.1),
    "cylinder": meshes.cylinder(0.05, 0.009),
    "bellows": meshes.bellows(0.08, 0.016, 0.024, pleats=8),
    "ellipsoid": meshes.ellipsoid(0.08, 0.02),
    "wing": meshes.wing(0.5, 0.1, tip_chord=0.06, sweep=0.03, thickness=0.004),
    "fin": meshes.fin(0.2, 0.1, tip_chord=0.06, sweep=0.03, thickness=0.004),
    "arrow": meshes.arrow(),
    "sphere": meshes.sphere(0.01),
    "ring": meshes.ring(0.02, 0.003),
    "pair": meshes.both_sides(meshes.sphere(0.01), 0.05),
}


@pytest.mark.parametrize("name", ALL)
def test_every_mesh_is_closed_and_faces_outwards(name: str) -> None:
    mesh = solid(ALL[name])
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0.0


def test_volumes_are_those_of_the_solids() -> None:
    # rounding only: the polygons' share of the circle is taken out
    assert solid(ALL["cylinder"]).volume == pytest.approx(INSCRIBED * math.pi * 0.009**2 * 0.05, rel=1e-9)
    r, R = 0.016, 0.024
    frustums = math.pi / 3.0 * (r * r + r * R + R * R) * 0.08
    assert solid(ALL["bellows"]).volume == pytest.approx(INSCRIBED * frustums, rel=1e-9)
    assert solid(ALL["fin"]).volume == pytest.approx(0.2 * (0.1 + 0.06) / 2.0 * 0.004, rel=1e-9)
    assert solid(ALL["wing"]).volume == pytest.approx(0.5 * (0.1 + 0.06) / 2.0 * 0.004, rel=1e-9)


def test_curved_volumes_converge_to_the_solids() -> None:
    # the profile itself is a polygon here: 32 chords a half turn leave 0.5 % of an ellipsoid
    ellipsoid = 4.0 / 3.0 * math.pi * 0.04 * 0.02**2
    assert solid(ALL["ellipsoid"]).volume == pytest.approx(INSCRIBED * ellipsoid, rel=5e-3)
    ends = 2.0 / 3.0 * math.pi * 0.016**2 * (0.06 + 0.1)
    middle = math.pi * 0.016**2 * (0.6 - 0.16)
    assert solid(ALL["hull"]).volume == pytest.approx(INSCRIBED * (ends + middle), rel=2e-3)


def test_the_arrow_points_along_x_with_unit_length() -> None:
    low, high = ALL["arrow"].vertices.min(axis=0), ALL["arrow"].vertices.max(axis=0)
    assert (low[0], high[0]) == (0.0, 1.0)
    assert high[1] < 0.1


@pytest.mark.parametrize("direction", [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, 0, 2), (0.3, -0.4, 0.5)])
def test_the_axis_is_turned_onto_its_direction(direction: tuple[float, float, float]) -> None:
    turned = rotate(np.array([[1.0, 0.0, 0.0]]), x_axis_to(direction))[0]
    assert turned == pytest.approx(np.array(direction) / np.linalg.norm(direction), abs=1e-12)


@pytest.mark.parametrize("preset", preset_ids())
def test_every_component_of_the_presets_is_drawn(preset: str) -> None:
    for component in load_preset(preset).vehicle.components:
        drawn = bodies(component)
        assert drawn or (component.kind == "rigid" and not component.shapes)
        stretches = component.kind in ("bellows", "piston", "bladder")
        assert sum(body.grows for body in drawn) == (1 if stretches else 0)
        assert (drawn_length(component) is not None) == stretches


def test_a_piston_without_shapes_is_drawn_at_its_volume() -> None:
    piston = next(c for c in load_preset("three-cell-glider").vehicle.components if c.kind == "piston")
    (body,) = bodies(piston)
    assert solid(body.mesh).volume == pytest.approx(INSCRIBED * piston.volume, rel=1e-9)
    # its stack begins at the aft end, so that growth moves its middle by half
    assert body.offset[0] == pytest.approx(-body.sizes[0] / 2.0)
