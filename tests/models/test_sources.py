"""The sources of force behind one contract: coefficients, tables over both angles, lateral coefficients, and ranges."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from models.assemble import assemble
from models.design import parse_design
from models.hydrodynamic_grid import build_grid_law
from models.hydrodynamics_angles import QUANTITIES, AngleTable
from models.problems import DesignError
from models.run_warnings import run_warnings
from models.simulate import simulate
from tests.models.support import slope_at
from tests.models.test_spatial_oracle import moving_design
from tests.strategies import coefficients, numbers

PROVENANCE = {"title": "Made up", "source": "Closed forms for a test."}
ALPHA, BETA = np.linspace(-180.0, 180.0, 73), np.linspace(0.0, 90.0, 37)


def smooth(alpha, beta):
    """X, Y, Z, K, M, N per squared speed of a symmetric vehicle: smooth, periodic in alpha, Y, K, N odd in beta."""
    cb, sb = np.cos(beta), np.sin(beta)
    return np.array([
        -2.0 - np.cos(alpha) * cb, -5.0 * sb, -8.0 * np.sin(alpha) * cb, -0.2 * sb * np.cos(alpha),
        -0.5 * np.sin(2 * alpha) * cb**2, 0.7 * sb * np.cos(alpha),
    ])  # fmt: skip


def angle_table(alpha=ALPHA, beta=BETA, **changes):
    a, b = np.meshgrid(np.radians(alpha), np.radians(beta), indexing="ij")
    grids = dict(zip(QUANTITIES, (np.round(grid, 15).tolist() for grid in smooth(a, b)), strict=True))
    return {
        "kind": "angle_table", "provenance": PROVENANCE, "alpha_deg": alpha.tolist(), "beta_deg": beta.tolist(),
        "includes_munk_moment": False,
    } | grids | changes  # fmt: skip


def with_source(source, **mission):
    document = moving_design({}).model_dump(mode="json")
    document["vehicle"]["hydrodynamics"] = source
    document["mission"] |= mission
    return parse_design(document)


def test_the_law_goes_through_its_table():
    law = build_grid_law(AngleTable.model_validate(angle_table()))
    for a in (-180.0, -45.0, 0.0, 10.0, 175.0):
        for b in (-90.0, -30.0, 0.0, 2.5, 90.0):
            np.testing.assert_allclose(law(np.radians(a), np.radians(b)), smooth(*np.radians([a, b])), atol=1e-14)


def test_between_its_points_the_law_closes_in_on_a_smooth_one():
    """PCHIP's slopes are of second order away from extremes: halving the grid divides the error by four or more."""
    rng = np.random.default_rng(1)
    places = np.column_stack([rng.uniform(-np.pi, np.pi, 400), rng.uniform(-1.5, 1.5, 400)])
    errors = []
    for count in (37, 73, 145):
        table = angle_table(np.linspace(-180.0, 180.0, count), np.linspace(0.0, 90.0, count // 2 + 1))
        law = build_grid_law(AngleTable.model_validate(table))
        errors.append(max(np.abs(law(a, b) - smooth(a, b)).max() for a, b in places))
    assert errors[0] < 0.02 * 8.0 and errors[1] < errors[0] / 3.0 and errors[2] < errors[1] / 3.0


@given(numbers(-1.0, 1.0), numbers(-1.0, 1.0), numbers(-1.0, 1.0))
def test_the_kernel_reads_the_same_law(u, v, w):
    design = with_source(angle_table(reference_point=[0.1, -0.02, 0.03]))
    assembly = assemble(design)
    moved = forces_of(assembly, [u, v, w])
    speed2 = u * u + v * v + w * w
    if speed2 < 1e-6:
        return
    law = build_grid_law(design.vehicle.hydrodynamics)
    expected = speed2 * law(np.arctan2(w, u), np.arcsin(np.clip(v / np.sqrt(speed2), -1.0, 1.0)))
    expected[3:] += np.cross([0.1, -0.02, 0.03], expected[:3])
    density = surface_density(assembly)
    np.testing.assert_allclose(moved, expected * density / 1000.0, atol=1e-10)


def test_beyond_its_edges_drag_still_opposes_the_motion():
    law = build_grid_law(AngleTable.model_validate(angle_table(np.linspace(-20.0, 20.0, 9), np.linspace(0.0, 20.0, 5))))
    for alpha in np.radians([-170.0, -60.0, 21.0, 90.0, 180.0]):
        for beta in np.radians([-80.0, 0.0, 30.0]):
            direction = np.array([np.cos(alpha) * np.cos(beta), np.sin(beta), np.sin(alpha) * np.cos(beta)])
            assert law(alpha, beta)[:3] @ direction < -1.0
            edge = np.clip(alpha, *np.radians([-20.0, 20.0])), np.clip(beta, *np.radians([-20.0, 20.0]))
            np.testing.assert_allclose(np.linalg.norm(law(alpha, beta)[:3]), np.linalg.norm(law(*edge)[:3]), rtol=1e-12)


@pytest.mark.parametrize("velocity", [[-0.5, 0.1, 0.2], [0.3, 0.5, 0.0], [0.1, -0.2, -0.6]])
def test_the_kernel_holds_the_edges_as_the_law_does(velocity):
    design = with_source(angle_table(np.linspace(-20.0, 20.0, 9), np.linspace(0.0, 20.0, 5)))
    assembly = assemble(design)
    u, v, w = velocity
    speed2 = u * u + v * v + w * w
    expected = speed2 * build_grid_law(design.vehicle.hydrodynamics)(np.arctan2(w, u), np.arcsin(v / np.sqrt(speed2)))
    got = forces_of(assembly, velocity) * 1000.0 / surface_density(assembly)
    np.testing.assert_allclose(got, expected, atol=1e-10)


def surface_density(assembly):
    return assembly.params.water[0, 1]


def forces_of(assembly, velocity):
    """Forces and moments of the source alone: what the slope changes when the source is there."""
    p = assembly.params
    y = assembly.initial_state.copy()
    y[2], y[3:7], y[7:10], y[10:13] = -1.0, [1.0, 0.0, 0.0, 0.0], velocity, 0.0
    still = p._replace(current=np.zeros_like(p.current), damping=np.zeros((6, 6)))
    silent = still._replace(grid=np.zeros_like(p.grid), table=quiet(p.table), coefficients=np.zeros(14))
    difference = slope_at(still, y)[7:13] - slope_at(silent, y)[7:13]
    return matrix_of(assembly) @ difference


def quiet(table):
    table = table.copy()
    table[:, 1:] = 0.0
    return table


def matrix_of(assembly):
    """M_RB + M_A at the initial state, read off the response to its inverse."""
    from models.added_mass import added_mass
    from models.mass_properties import initial_extensions, mass_balance

    design = assembly.design
    balance = mass_balance(design.vehicle, initial_extensions(design))
    x, y, z = balance.mass * balance.center_of_mass
    M = np.zeros((6, 6))
    M[:3, :3] = balance.mass * np.eye(3)
    M[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    M[3:, :3] = M[:3, 3:].T
    M[3:, 3:] = balance.inertia_about_origin
    return M + added_mass(design)


@given(st.data(), coefficients(), numbers(-1.0, 1.0), numbers(-1.0, 1.0), numbers(-1.0, 1.0))
def test_the_coefficient_form_is_that_of_the_literature(data, source, u, v, w):
    """Flow-frame force (-D, SF, -L) and moment (K, M, N), turned to the body by alpha and beta."""
    source |= {"includes_munk_moment": False, "reference_point": [0.0, 0.0, 0.0]}
    V2 = u * u + v * v + w * w
    if V2 < 1e-6:
        return
    a, b = np.arctan2(w, u), np.arcsin(np.clip(v / np.sqrt(V2), -1.0, 1.0))
    ca, sa, cb, sb = np.cos(a), np.sin(a), np.cos(b), np.sin(b)
    turn = np.array([[ca * cb, -ca * sb, -sa], [sb, cb, 0.0], [sa * cb, -sa * sb, ca]])
    drag = source["drag_zero"] + source["drag_attack"] * a * a + source["drag_sideslip"] * b * b
    lift = source["lift_zero"] + source["lift_attack"] * a
    pitch = source["pitch_zero"] + source["pitch_attack"] * a
    force = turn @ [-drag, source["side_sideslip"] * b, -lift] * V2
    moment = turn @ [source["roll_sideslip"] * b, pitch, source["yaw_sideslip"] * b] * V2
    assembly = assemble(with_source(source))
    density = assembly.params.water[0, 1] / source["reference_density"]
    got = forces_of(assembly, [u, v, w])
    np.testing.assert_allclose(got, density * np.concatenate([force, moment]), atol=1e-9)


def test_a_hull_without_a_fin_goes_broadside():
    """The stand-in hull in space: its Munk moment in yaw turns it across the flow, and the designer is warned."""
    from models.presets import load_preset

    document = load_preset("three-cell-glider").model_dump(mode="json")
    document["mission"]["solver"]["model"] = "spatial"
    document["mission"]["initial"]["yaw"] = 1e-3
    document["mission"]["initial"]["angular_velocity"] = [0.0, 0.0, 1e-3]
    design = parse_design(document)
    warnings = [w.message for w in assemble(design).warnings]
    assert any("no side force or yaw moment data" in message for message in warnings)
    run = simulate(design)
    assert np.abs(run.values["beta"]).max() > 0.5


def test_the_munk_moment_of_the_stand_in_in_yaw():
    """N = -(A22 - A11) u v: -0.47 N m a radian of sideslip at 1 m/s, in the equations whatever the table holds."""
    from models.presets import load_preset

    document = load_preset("canete-dual-bellows").model_dump(mode="json")
    document["mission"]["solver"]["model"] = "spatial"
    document["vehicle"]["added_mass"]["enabled"] = True
    for includes in (True, False):
        document["vehicle"]["hydrodynamics"]["includes_munk_moment"] = includes
        assembly = assemble(parse_design(document))
        y = assembly.initial_state.copy()
        y[7:10] = np.cos(0.01), np.sin(0.01), 0.0
        yaw = matrix_of(assembly)[5] @ slope_at(assembly.params, y)[7:13]
        assert yaw / 0.01 == pytest.approx(-0.473, abs=0.001)


def test_leaving_the_range_is_told():
    short = angle_table(np.linspace(-10.0, 10.0, 21), np.linspace(0.0, 4.0, 9))
    run = simulate(with_source(short, duration=2.0))
    told = [w for w in run_warnings(run) if w.pointer == "/vehicle/hydrodynamics/alpha_deg"]
    share = np.mean((np.abs(np.degrees(run.values["alpha"])) > 10.0) & (run.values["speed"] > 1e-3))
    assert share > 0.0 and len(told) == 1
    assert (
        f"{100 * share:.0f} % of the run is outside the angles of attack of the data, -10 to 10 deg" in told[0].message
    )
    form = moving_design({"alpha_limit_deg": 5.0, "beta_limit_deg": 3.0})
    pointers = {w.pointer for w in run_warnings(simulate(form))}
    assert {"/vehicle/hydrodynamics/alpha_limit_deg", "/vehicle/hydrodynamics/beta_limit_deg"} <= pointers


def test_leaving_the_water_profile_is_told():
    shallow = {"kind": "density_profile", "depths": [0.0, 5.2], "densities": [998.0, 999.0]}
    current = {"kind": "tabulated", "depths": [0.0, 5.1], "north": [[0.1, 0.0]], "east": [[0.0, 0.0]]}
    document = moving_design({}).model_dump(mode="json")
    document["mission"]["environment"] |= {"water": shallow, "current": current}
    run = simulate(parse_design(document))
    assert run.values["z"].max() > 5.2
    messages = {w.pointer: w.message for w in run_warnings(run)}
    assert "below the deepest level of the water at 5.2 m" in messages["/mission/environment/water/depths"]
    assert "below the deepest level of the current at 5.1 m" in messages["/mission/environment/current/depths"]


@pytest.mark.parametrize(("change", "told"), [
    ({"alpha_deg": [0.0, 10.0, 5.0]}, "alpha_deg must rise"),
    ({"yaw": [[0.0] * 37] * 72}, "yaw has 72 rows, alpha_deg has 73 angles"),
    ({"roll": [*[[0.0] * 37] * 72, [0.0] * 36]}, "roll at alpha = 180.0 deg has 36 entries"),
    ({"sway": [[0.3] + [1.0] * 36] * 73}, "a vehicle that is not symmetric needs negative sideslips too"),
])  # fmt: skip
def test_a_table_with_holes_is_refused(change, told):
    with pytest.raises(DesignError) as refused:
        with_source(angle_table() | change)
    assert told in str(refused.value)


def test_a_seam_that_does_not_close_is_refused():
    table = angle_table()
    table["heave"][-1][3] += 1.0
    with pytest.raises(DesignError, match="one direction"):
        with_source(table)
