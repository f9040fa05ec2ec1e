"""The spatial kernel against an independent simulator: momenta in world axes, rotation matrices, SciPy."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from models.assemble import assemble
from models.assemble_spatial import emerging_depth
from models.design import parse_design
from models.kernel.model import energies
from models.simulate import simulate
from models.water import density_at, water_table
from tests.models.spatial_reference import SpatialReference, simulate_spatial_reference
from tests.models.support import slope_at
from tests.strategies import spatial_designs, spatial_states

Q, V, OMEGA, WORKS, EXTENSIONS = slice(3, 7), slice(7, 10), slice(10, 13), slice(13, 16), 16


def reference_for(design):
    """The reference in the very water of the kernel, whose profile is tabulated and whose top layer is mixed."""
    mixed = emerging_depth(design)
    gravity = design.mission.environment.gravity
    table = water_table(design.mission.environment.water, gravity, mixed=mixed)

    def pressure(z):
        index = int(np.clip(np.floor((z - table.top) / table.spacing) + 1, 0, len(table.rows) - 1))
        row = table.rows[index]
        h = z - row[0]
        return row[5] + gravity * h * (row[1] + h * (row[2] / 2 + h * (row[3] / 3 + h * row[4] / 4)))

    return SpatialReference(design, lambda z: density_at(design.mission.environment.water, z, mixed=mixed), pressure)


def parts_of(assembly, y):
    rotation = Rotation.from_quat(y[Q], scalar_first=True).as_matrix()
    count = len(assembly.cells)
    return y[:3], rotation, y[V], y[OMEGA], dict(zip(assembly.cells, y[EXTENSIONS : EXTENSIONS + count], strict=True))


def comparable(design, y):
    """Compression of what emerges is a matter of taste; at 90 deg of attack the polynomials' lift has two values."""
    squeezed = any(getattr(c, "bulk_modulus", None) for c in design.vehicle.components)
    v_r = y[V] - Rotation.from_quat(y[Q], scalar_first=True).inv().apply([*current_at(design, y[2]), 0.0])
    across = abs(v_r[0]) < 1e-9 and getattr(design.vehicle.hydrodynamics, "law", None) == "polynomial"
    return (y[2] > 0.7 or not squeezed) and not across


def current_at(design, depth):
    """Current north and east at time zero, m/s."""
    return SpatialReference(design).current(float(depth), 0.0).velocity[:2]


@given(st.data(), spatial_designs())
def test_accelerations_equal_the_references(data, design):
    assembly = assemble(design)
    y = data.draw(spatial_states(assembly))
    position, rotation, v, omega, extensions = parts_of(assembly, y)
    assume(comparable(design, y))
    expected = np.concatenate(reference_for(design).acceleration(position, rotation, v, omega, extensions, 0.0))
    got = slope_at(assembly.params, y)[7:13]
    # rounding of forces that cancel: up to some hundred times the sum
    np.testing.assert_allclose(got, expected, rtol=1e-9, atol=1e-9 * (1.0 + np.abs(expected).max()))


@given(st.data(), spatial_designs())
def test_energies_equal_the_references(data, design):
    assembly = assemble(design)
    y = data.draw(spatial_states(assembly))
    position, rotation, v, omega, extensions = parts_of(assembly, y)
    assume(comparable(design, y))
    reference = reference_for(design)
    kinetic, potential = reference.energies(position, rotation, v, omega, extensions, 0.0)
    got = energies(0.0, y, assembly.params)
    assert got[0] == pytest.approx(kinetic, rel=1e-10)
    # from the same glider deeper down: where a floating part's potential begins is arbitrary
    deeper = y.copy()
    deeper[2] += 3.0
    _, below = reference.energies(deeper[:3], rotation, v, omega, extensions, 0.0)
    released = energies(0.0, deeper, assembly.params)[1] - got[1]
    assert released == pytest.approx(below - potential, rel=1e-7, abs=1e-6)  # the reference's quadrature


@given(st.data(), spatial_designs())
def test_kinematics_turn_velocities_to_the_world(data, design):
    assembly = assemble(design)
    y = data.draw(spatial_states(assembly))
    _, rotation, v, omega, _ = parts_of(assembly, y)
    slope = slope_at(assembly.params, y)
    np.testing.assert_allclose(slope[:3], rotation @ v, atol=1e-13)
    h = 1e-6
    ahead, behind = (
        Rotation.from_quat(y[Q] + sign * h * slope[Q], scalar_first=True).as_matrix() for sign in (1.0, -1.0)
    )
    spin = rotation.T @ (ahead - behind) / (2 * h)
    np.testing.assert_allclose([spin[2, 1], spin[0, 2], spin[1, 0]], omega, atol=1e-8)  # second order in h


def moving_design(source):
    """A composed glider off its plane of symmetry whose parts ramp and jump."""
    body = {
        "kind": "rigid", "name": "Body", "mass": 1.6, "position": [0.0, 0.0, -0.004], "volume": 1.65e-3,
        "center_of_mass": [0.002, 0.001, 0.012], "inertia": {"xx": 0.01, "yy": 0.03, "zz": 0.03, "xz": 1e-3},
        "bulk_modulus": 5e6,
    }  # fmt: skip
    piston = {
        "kind": "piston", "name": "Piston", "mass": 0.1, "position": [0.15, 0.03, 0.0], "volume": 5e-5,
        "volume_range": [2e-5, 8e-5], "area": 1e-3,
    }  # fmt: skip
    slide = {
        "kind": "movable_mass", "name": "Slide", "mass": 0.1, "position": [-0.05, 0.0, 0.01],
        "extension_range": [-0.05, 0.05], "neutral_extension": 0.0,
    }  # fmt: skip
    roller = {
        "kind": "rolling_mass", "name": "Roller", "mass": 0.2, "position": [0.0, 0.0, 0.02], "angle_range": [-1.0, 1.0],
        "inertia": {"xx": 1e-4, "yy": 2e-3, "zz": 2.1e-3},
    }  # fmt: skip
    told = {
        "Piston": [(0.5, -0.01, "step"), (2.0, 0.005, "ramp")],
        "Slide": [(1.0, 0.03, "ramp")],
        "Roller": [(0.2, 0.0, "step"), (1.5, 0.8, "ramp")],
    }
    forces = {
        "kind": "coefficients", "provenance": {"title": "Made up", "source": "Numbers for a test."},
        "drag_zero": 1.8, "drag_attack": 20.0, "side_sideslip": -6.0, "lift_attack": 15.0, "roll_sideslip": -0.3,
        "roll_rate": -0.5, "pitch_attack": -0.6, "pitch_rate": -1.0, "yaw_sideslip": 0.8, "yaw_rate": -1.0,
    }  # fmt: skip
    A = np.diag([0.1, 1.2, 2.5, 0.02, 0.06, 0.05])
    A[2, 4] = A[4, 2] = 0.05
    return parse_design({
        "format": "glider-design", "version": 1, "name": "Moving parts",
        "vehicle": {
            "components": [body, piston, slide, roller], "hydrodynamics": forces | source,
            "added_mass": {"matrix": A.tolist()}, "damping": {"roll": 0.02, "yaw": 0.02, "sway": 0.1},
        },
        "mission": {
            "environment": {
                "gravity": 9.81,
                "water": {"kind": "density_profile", "depths": [0.0, 10.0, 40.0], "densities": [998.0, 999.0, 1000.5]},
                "current": {"kind": "sheared", "surface_velocity": [0.2, -0.1], "shear": [-0.01, 0.02]},
            },
            "initial": {
                "position": [0.0, 0.0, 5.0], "pitch": -0.3, "roll": 0.2, "yaw": 1.0, "velocity": [0.3, 0.0, 0.02],
            },
            "control": {"schedules": [
                {"cell": cell, "points": [{"time": t, "extension": e, "shape": s} for t, e, s in points]}
                for cell, points in told.items()
            ]},
            "duration": 4.0,
            "solver": {"model": "spatial", "tolerance": 1e-12, "output_interval": 0.5},
        },
    })  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("source", [{}, {"rate_scaling": "speed", "includes_munk_moment": True}])
def test_a_glide_with_moving_parts_is_the_references(source):
    design = moving_design(source)
    run = simulate(design)
    _, states = simulate_spatial_reference(design, glider=reference_for(design), max_step=0.05)
    last, final = states[-1], run.final
    np.testing.assert_allclose([final[n] for n in "xyz"], last.position, atol=1e-8)
    rotation = Rotation.from_quat([final[f"q{i}"] for i in range(4)], scalar_first=True).as_matrix()
    np.testing.assert_allclose(rotation, last.R, atol=1e-8)
    np.testing.assert_allclose([final[n] for n in "uvw"], last.v, atol=1e-8)
    np.testing.assert_allclose([final[n] for n in "pqr"], last.omega, atol=1e-8)
    assert run.relative_residual < 1e-9
