"""The formulas of strip theory against limits and closed forms; the quad-bellows glider against what its notes say."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from models.design import parse_design
from models.hydrodynamic_law import coefficients_by_speed
from models.mass_properties import mass_balance
from models.presets import quad_glider as glider
from models.presets import quad_hydrodynamics as water
from models.presets import strip_theory as strips
from models.presets.strip_theory import Bar, Fin
from models.run import Status
from models.simulate import simulate
from models.water import density_at, gravity_of

RHO = 1000.0
TRAPEZIUM = Fin(span=0.3, chord=0.24, tip_chord=0.15, sweep=0.07, thickness=0.008, leading_x=-0.7, root_z=-0.05)
SPECK = Fin(span=1e-4, chord=1e-4, tip_chord=1e-4, sweep=0.0, thickness=1e-6, leading_x=-0.8, root_z=-0.2)
"""A fin so small that it is a point."""


@pytest.mark.parametrize(("ratio", "limit"), [(1e6, 2.0 * math.pi), (1e-4, 0.5 * math.pi * 1e-4)])
def test_lift_slope_has_the_limits_of_thin_aerofoil_and_slender_wing(ratio, limit):
    assert strips.helmbold_slope(ratio) == pytest.approx(limit, rel=1e-4)


def test_lift_slope_of_the_scaled_wing_is_near_that_of_the_cfd():
    """Half the angle at which the CFD's lift is still linear; its wing nears the stall at 5 deg."""
    angles, forces = coefficients_by_speed(water.standin())[0.5]
    slope = forces[0, 1] / angles[1] / (0.5 * RHO * 0.5 * 0.1)
    assert strips.helmbold_slope(5.0) == pytest.approx(slope, rel=0.1)


def test_fin_integrals_are_exact_for_a_trapezium():
    def chord(s):
        return 0.24 - 0.09 * s

    def middle(s):
        return -0.7 - 0.07 * s - 0.5 * chord(s)

    def height(s):
        return -0.05 - 0.3 * s

    for powers in ((1, 0, 0), (1, 1, 0), (1, 0, 2), (2, 2, 0), (4, 0, 0), (2, 1, 1)):
        i, j, k = powers
        expected = 0.3 * quad(lambda s, i=i, j=j, k=k: chord(s) ** i * middle(s) ** j * height(s) ** k, 0, 1)[0]
        got = TRAPEZIUM.integral(lambda c, x, z, i=i, j=j, k=k: c**i * x**j * z**k)
        assert got == pytest.approx(expected, rel=1e-12)
    assert TRAPEZIUM.integral(lambda c, x, z: c) == pytest.approx(TRAPEZIUM.area, rel=1e-14)


def test_a_point_of_a_fin_acts_as_a_force_at_its_arm():
    """Y = Y_b (v + x r - z p), K = -z Y, N = x Y: a fin behind and above steadies yaw, and rolls away from sideslip."""
    c = strips.fin_coefficients(SPECK, density=RHO, body_factor=1.5)
    x, z, Y = -0.8, -0.2, c["Y_b"]
    assert Y < 0.0 < c["N_b"]
    expected = {
        "K_b": -z * Y, "N_b": x * Y, "Y_p": -z * Y, "Y_r": x * Y, "K_p": z * z * Y, "K_r": -z * x * Y,
        "N_p": -x * z * Y, "N_r": x * x * Y,
    }  # fmt: skip
    for name, value in expected.items():
        assert c[name] == pytest.approx(value, rel=1e-3), name


@given(st.floats(0.05, 1.0), st.floats(0.02, 0.5), st.floats(0.02, 0.5), st.floats(-1.0, -0.2))
def test_a_fin_behind_and_above_damps_every_turn(span, chord, tip_chord, leading_x):
    fin = Fin(span, chord, tip_chord, 0.02, 0.005, leading_x, -0.05)
    c = strips.fin_coefficients(fin, density=RHO, body_factor=1.5)
    assert c["N_b"] > 0.0 > c["Y_b"]
    assert c["K_b"] < 0.0
    damping = np.array([[c["K_p"], c["K_r"]], [c["N_p"], c["N_r"]]])
    assert (np.diag(damping) < 0.0).all()


@pytest.mark.parametrize("ratio", [1.0, 5.0, 20.0])
def test_roll_damping_of_an_elliptic_wing_is_the_closed_form(ratio):
    slope = strips.roll_damping_slope(ratio, lambda eta: 4.0 / math.pi * np.sqrt(1.0 - eta**2))
    assert slope == pytest.approx(0.25 * math.pi * ratio / (ratio + 4.0), rel=1e-10)


def test_roll_damping_of_a_long_rectangle_is_that_of_strips():
    """K = -(rho/2) 2 pi c V p times the integral of y^2 over the span, which is -(2 pi / 6) rho S b^2 V p / 4."""
    span, chord = 1e4, 1.0
    by_strips = -0.5 * RHO * 2.0 * math.pi * chord * 2.0 * quad(lambda y: y * y, 0.0, 0.5 * span)[0]
    assert strips.wing_roll_damping(span, chord, density=RHO) == pytest.approx(by_strips, rel=5e-3)
    assert strips.roll_damping_slope(5.0) == pytest.approx(strips.roll_damping_slope(5.0, terms=120), rel=1e-4)


def test_a_wing_about_its_three_quarter_chord_lifts_nothing_when_it_pitches():
    rates = strips.wing_pitch_rate(2.0, 0.4, 0.1, density=RHO)
    assert rates["Z_q"] == pytest.approx(0.0, abs=1e-9)
    aft = strips.wing_pitch_rate(2.0, 0.4, -0.5, density=RHO)
    assert aft["M_q"] < 0.0
    assert aft["M_q"] == pytest.approx(0.5 * aft["Z_q"], rel=1e-14)


def test_wing_yaw_damping_is_the_integral_of_its_strips():
    got = strips.wing_yaw_damping(1.6, 0.3, drag=0.02, density=RHO)
    assert got == pytest.approx(-RHO * 0.02 * 0.3 * 2.0 * quad(lambda y: y * y, 0.0, 0.8)[0], rel=1e-12)


def test_side_of_a_hull_is_that_of_its_outline():
    length, radius, nose, tail = 2.0, 0.05, 0.2, 0.33

    def radius_at(x):
        beyond = max(x - (0.5 * length - nose), 0.0) / nose, max(-x - (0.5 * length - tail), 0.0) / tail
        return radius * math.sqrt(max(1.0 - max(beyond) ** 2, 0.0))

    area, first = strips.hull_side(length, radius, nose, tail)
    corners = {"points": [-0.67, 0.8], "limit": 200}
    assert area == pytest.approx(quad(lambda x: 2.0 * radius_at(x), -1.0, 1.0, **corners)[0], rel=1e-6)
    assert first == pytest.approx(quad(lambda x: 2.0 * radius_at(x) * x, -1.0, 1.0, **corners)[0], rel=1e-5)


def test_crossflow_opposes_sideslip_and_acts_at_the_centroid():
    c = strips.crossflow(0.2, 0.2 * 0.3, 0.2 * 0.1, drag=1.1, density=RHO)
    assert c["Y_bb"] == pytest.approx(-0.5 * RHO * 1.1 * 0.2)
    assert c["N_bb"] == pytest.approx(0.3 * c["Y_bb"])
    assert c["K_bb"] == pytest.approx(-0.1 * c["Y_bb"])


def test_linearised_damping_takes_the_same_work_over_a_swing():
    amplitude, quadratic = 0.07, 31.0
    rate = lambda t: amplitude * math.cos(t)  # noqa: E731
    work = quad(lambda t: quadratic * abs(rate(t)) ** 3, 0.0, 2.0 * math.pi, limit=200)[0]
    linear = strips.linearised(quadratic, amplitude) * quad(lambda t: rate(t) ** 2, 0.0, 2.0 * math.pi)[0]
    assert linear == pytest.approx(work, rel=1e-9)


@pytest.mark.parametrize("reach", [(-1.0, 1.0), (0.2, 0.9), (-0.3, 0.8)])
def test_strip_damping_is_the_integral_over_its_reach(reach):
    expected = 0.5 * RHO * 1.2 * 0.1 * quad(lambda s: abs(s) ** 3, *reach, points=[0.0])[0]
    assert strips.strip_moment_damping(0.1, reach, drag=1.2, density=RHO) == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize(("long_per_short", "coefficient"), [(1.0, 0.579), (2.0, 0.757), (3.0, 0.830), (5.0, 0.897)])
def test_added_mass_of_a_plate_is_near_the_tabulated(long_per_short, coefficient):
    """DNV-RP-H103 (2011), appendix A: coefficients on (pi/4) a^2 b of rectangular plates."""
    assert strips.plate_factor(1.0 / long_per_short) == pytest.approx(coefficient, rel=0.05)


def test_added_mass_of_a_long_plate_needs_no_factor():
    assert strips.plate_factor(0.0) == 1.0


def test_added_mass_of_a_point_of_a_fin_is_that_of_its_velocity():
    """T = m (v + x r - z p)^2 / 2."""
    A = strips.fin_added_mass(SPECK, density=RHO)
    across = np.array([0.0, 1.0, 0.0, 0.2, 0.0, -0.8])
    np.testing.assert_allclose(A, A[1, 1] * np.outer(across, across), atol=1e-3 * A[1, 1])


@pytest.mark.parametrize(
    "A",
    [strips.fin_added_mass(TRAPEZIUM, density=RHO), strips.bar_added_mass(Bar(0.5, 0.06, 0.3, 0.1), density=RHO),
     np.array(water.added_mass()["matrix"])],
)  # fmt: skip
def test_added_mass_is_symmetric_and_positive(A):
    np.testing.assert_array_equal(A, A.T)
    assert np.linalg.eigvalsh(A)[0] >= -1e-12 * np.abs(A).max()


def test_a_bar_along_the_flow_is_blunt_and_across_it_a_cylinder():
    bar, angles = Bar(0.4, 0.06, 0.3, 0.1), np.array([0.0, 0.5 * math.pi])
    lift, drag, moment = strips.bar_forces(bar, angles, density=RHO)
    assert lift == pytest.approx([0.0, 0.0], abs=1e-12)
    section, side = 0.25 * math.pi * 0.06**2, 0.06 * 0.4
    assert drag == pytest.approx(
        [0.5 * RHO * strips.BLUNT_CYLINDER * section, 0.5 * RHO * strips.CYLINDER_CROSSFLOW * side]
    )
    assert moment == pytest.approx([0.0, 0.3 * drag[1]], abs=1e-12)


def test_friction_of_a_turbulent_plate_at_a_million():
    assert strips.friction(1e6) == pytest.approx(0.00447, rel=2e-3)


def test_tube_stiffness_follows_from_its_strains():
    r, t, E, nu, pressure = 0.05, 0.002, 70e9, 0.3, 1e6
    hoop, axial = pressure * r / t, 0.5 * pressure * r / t
    strain = 2.0 * (hoop - nu * axial) / E + (axial - nu * hoop) / E
    assert strips.tube_bulk_modulus(r, t, young=E, poisson=nu) == pytest.approx(pressure / strain, rel=1e-12)


def kirchhoff(mass, c, damping, nu, roll, pitch, heaviness, arm):
    """Accelerations of a glider by Kirchhoff's equations, forces of sideslip and turning only; to be differentiated."""
    speed = math.sqrt(nu[0] ** 2 + nu[2] ** 2)
    P = mass @ nu
    forces = np.zeros(6)
    for i, force in ((1, "Y"), (3, "K"), (5, "N")):
        forces[i] = speed * sum(c.get(f"{force}_{by}", 0.0) * nu[j] for by, j in (("b", 1), ("p", 3), ("r", 5)))
    down = np.array([-math.sin(pitch), math.sin(roll) * math.cos(pitch), math.cos(roll) * math.cos(pitch)])
    weight = np.concatenate([heaviness * down, np.cross([arm[0], 0.0, arm[1]], down)])
    turning = np.concatenate([np.cross(nu[3:], P[:3]), np.cross(nu[3:], P[3:]) + np.cross(nu[:3], P[:3])])
    return np.linalg.solve(mass, forces - damping @ nu + weight - turning)


def test_lateral_matrix_is_the_derivative_of_kirchhoffs_equations():
    generator = np.random.default_rng(7)
    half = generator.normal(size=(6, 6))
    parity = np.arange(6) % 2
    mass = (half @ half.T + 10.0 * np.eye(6)) * (parity[:, None] == parity)  # symmetric from port to starboard
    c = {f"{force}_{by}": float(generator.normal()) for force in "YKN" for by in "bpr"}
    damping, pitch, load = np.diag(generator.uniform(0.0, 1.0, 6)), -0.5, (3.0, (0.2, 0.9))
    nu = np.array([0.4, 0.0, 0.05, 0.0, 0.0, 0.0])

    def rates(state):
        moved = nu + np.array([0.0, state[0], 0.0, state[1], 0.0, state[2]])
        change = kirchhoff(mass, c, damping, moved, state[3], pitch, *load)
        return np.array([change[1], change[3], change[5], state[1] + state[2] * math.tan(pitch)])

    step = 1e-6
    expected = np.column_stack([(rates(step * e) - rates(-step * e)) / (2.0 * step) for e in np.eye(4)])
    got = strips.lateral_matrix(mass, c, damping, velocity=(0.4, 0.05), pitch=pitch, heaviness=load[0], arm=load[1])
    np.testing.assert_allclose(got, expected, atol=1e-7)


def test_the_cfd_is_scaled_by_the_square_and_the_cube_of_the_length():
    """Against the table without fin and core sampler: their share is taken off by the formulas tested above."""
    small, large = water.standin(), water.polar()
    speed, alpha = np.array(large["row_speed"]), np.radians(large["row_alpha_deg"])
    rows = np.array([large["row_lift"], large["row_drag"], large["row_moment"]]) / speed**2
    rows -= strips.bar_forces(water.SAMPLER, alpha, density=RHO)
    rows[1] -= strips.fin_drag(water.FIN, speed=water.CRUISE, density=RHO, viscosity=1e-6)
    bare = np.array([small.row_lift, small.row_drag, small.row_moment]) / np.array(small.row_speed) ** 2
    powers = water.SCALE ** np.array([[2.0], [2.0], [3.0]])
    np.testing.assert_allclose(rows, bare * powers, rtol=1e-4, atol=2e-3)
    A = water.added_mass_parts()["hull, wing and ring cells"]
    assert A[2, 2] == pytest.approx(4.62 * water.SCALE**3)
    assert A[2, 4] == pytest.approx(0.0789 * water.SCALE**4)
    assert A[5, 5] == pytest.approx(0.0144 * water.SCALE**5)


DOCUMENTS = {**{name: glider.quad_glider(name) for name in glider.MISSIONS}, "twin": glider.movable_mass_twin()}


@pytest.fixture(scope="module")
def runs():
    return {name: simulate(parse_design(document)) for name, document in DOCUMENTS.items()}


@pytest.mark.parametrize("document", DOCUMENTS.values(), ids=DOCUMENTS)
def test_the_glider_is_level_and_neutral_between_surface_and_bottom(document):
    design = parse_design(document)
    balance, lake = mass_balance(design.vehicle), design.mission.environment
    apart = balance.center_of_mass - balance.center_of_buoyancy
    np.testing.assert_allclose(apart, [0.0, 0.0, glider.METACENTRIC_HEIGHT], atol=1e-7)
    assert 29.0 < balance.mass < 31.5
    surface, bottom = (glider.floats(document["vehicle"]["components"], z) - balance.mass for z in (0.0, 100.0))
    assert surface == pytest.approx(-bottom, abs=1e-6)
    pressure = 100.0 * 1000.0 * gravity_of(lake)
    squeezed = balance.volume * (density_at(lake.water, 100.0) - density_at(lake.water, 0.0))
    assert bottom - surface == pytest.approx(squeezed - 0.0248 * 1000.0 * pressure / glider.BULK_MODULUS, rel=0.02)


def lateral_modes(*, fin):
    """Return the lateral eigenvalues of the straight dive, with or without the fin in coefficients and added mass."""
    run = simulate(parse_design(DOCUMENTS["glide"]))
    at = int(np.searchsorted(run.times, 300.0))
    u, w, theta, net = (float(run.values[name][at]) for name in ("u", "w", "theta", "net_buoyancy"))
    vehicle = run.design.vehicle
    balance = mass_balance(vehicle, dict(zip(run.cells, run.cell_values["extension"][at].tolist(), strict=True)))
    parts = [A for name, A in water.added_mass_parts().items() if fin or name != "fin"]
    r, m = balance.center_of_mass, balance.mass
    S = np.array([[0.0, -r[2], r[1]], [r[2], 0.0, -r[0]], [-r[1], r[0], 0.0]])
    rigid = np.block([[m * np.eye(3), -m * S], [m * S, balance.inertia_about_origin]])
    g = gravity_of(run.design.mission.environment)
    arm = m * g * r - (m * g + net) * balance.center_of_buoyancy
    chosen = [c for name, c in water.lateral_parts().items() if fin or name != "fin"]
    total = {f"{f}_{b}": sum(c.get(f"{f}_{b}", 0.0) for c in chosen) for f in "YKN" for b in "bpr"}
    D = np.diag([0.0, 0.0, 0.0, *(water.damping()[name] for name in ("roll", "pitch", "yaw"))])
    matrix = strips.lateral_matrix(
        rigid + sum(parts), total, D, velocity=(u, w), pitch=theta, heaviness=-net, arm=(arm[0], arm[2])
    )
    return np.linalg.eigvals(matrix)


def test_the_fin_outweighs_the_munk_moment_and_makes_the_glide_stable():
    A = sum(water.added_mass_parts().values())
    assert water.lateral_totals()["N_b"] > 1.5 * -strips.munk_yaw_slope(A)
    assert lateral_modes(fin=True).real.max() < -0.05
    assert lateral_modes(fin=False).real.max() > 0.05


@pytest.mark.slow
def test_every_mission_runs_to_its_end_and_balances_its_energy(runs):
    for name, run in runs.items():
        assert run.status is Status.completed, name
        assert run.relative_residual < 1e-6, name
        assert len(run.times) < 20_000, name
        moving = run.values["speed"] > 0.05
        assert np.abs(run.values["alpha"][moving]).max() < math.radians(60.0), name
        assert np.abs(run.values["beta"][moving]).max() < math.radians(15.0), name


@pytest.mark.slow
def test_the_straight_glide_is_steady(runs):
    steady = (runs["glide"].times > 150.0) & (runs["glide"].times < 320.0)
    pitch = np.degrees(runs["glide"].values["theta"][steady])
    assert pitch.mean() == pytest.approx(-30.5, abs=0.5)
    assert np.ptp(pitch) < 0.5
    assert np.abs(runs["glide"].values["y"]).max() < 1e-6


@pytest.mark.slow
def test_the_spiral_turns_to_the_lower_side_and_the_s_turn_both_ways(runs):
    spiral, s_turn = runs["spiral"], runs["s-turn"]
    late = spiral.times > 400.0
    assert np.degrees(spiral.values["phi"][late]).mean() == pytest.approx(15.2, abs=0.5)
    assert spiral.values["turn_radius"][late].mean() == pytest.approx(18.7, abs=0.5)
    assert np.unwrap(spiral.values["psi"])[-1] == pytest.approx(1.2 * 2.0 * math.pi, abs=0.3)
    heading = np.degrees(np.unwrap(s_turn.values["psi"]))
    assert heading.min() < -140.0
    assert heading[-1] - heading.min() > 140.0


@pytest.mark.slow
def test_the_yo_yo_reaches_the_bottom_ten_times_and_the_surface_between(runs):
    t, z = runs["yo-yo"].times, runs["yo-yo"].values["z"]
    for k in range(glider.CYCLES):
        cycle = (t >= k * glider.PERIOD) & (t < (k + 1) * glider.PERIOD)
        assert z[cycle].max() == pytest.approx(100.0, abs=3.0)
        assert (z[cycle] < 0.3).sum() > 120


@pytest.mark.slow
def test_the_twin_glides_as_the_quad_does_and_turns_alike(runs):
    quad_run, twin = runs["spiral"], runs["twin"]
    before, late = (quad_run.times > 100.0) & (quad_run.times < 120.0), quad_run.times > 500.0
    for name, tolerance in (("theta", math.radians(1.0)), ("speed", 0.01)):
        assert twin.values[name][before].mean() == pytest.approx(quad_run.values[name][before].mean(), abs=tolerance)
    assert twin.values["phi"][late].mean() == pytest.approx(quad_run.values["phi"][late].mean(), abs=math.radians(3.0))
