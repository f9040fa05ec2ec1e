"""Linear models: slopes by other means, closed forms, symmetries, and what is refused."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from models.assemble import assemble
from models.design import parse_design
from models.linearize import linearize, motion_matrix
from models.operating_point import OperatingPoint, minimal_state, point_of
from models.presets import load_preset
from models.problems import DesignError
from models.simulate import simulate
from models.trim import design_from, find_trims
from tests.models.linear_support import DENSITY, GRAVITY, INERTIA, MASS, REST, differences, resting_design
from tests.models.support import PISTON, design_of, observed_orders
from tests.models.test_spatial_truths import changed


def spiral_point(preset_id="quad-bellows-spiral"):
    design = load_preset(preset_id)
    run = simulate(design)
    return design, OperatingPoint.from_run(run, float(run.times[-1]))


@pytest.mark.parametrize("preset_id", ["quad-bellows-spiral", "seawing-spiral", "movable-mass-twin"])
def test_slopes_are_those_of_the_quaternion_derivative(preset_id):
    """By plain differences of the kernel's own derivative, mapped through the quaternion, at random states."""
    assembly = assemble(load_preset(preset_id))
    random = np.random.default_rng(5)
    for _ in range(6):
        point = OperatingPoint(
            depth=9.0, roll=random.uniform(-1, 1), pitch=random.uniform(-1.2, 1.2), yaw=random.uniform(-3, 3),
            velocity=tuple(random.uniform(-0.4, 0.4, 3)), angular_velocity=tuple(random.uniform(-0.3, 0.3, 3)),
        )  # fmt: skip
        model, minimal = linearize(assembly, point), minimal_state(assembly, point)
        strokes = assembly.params.parts["stop_high"] - assembly.params.parts["stop_low"]
        steps = np.array([1e-2, *np.full(9, 1e-6), *(1e-4 * strokes)])
        wanted = differences(assembly, minimal, steps)
        # by row, for an acceleration of 1 m/s2 has rounding of 1e-9 in slopes over 1e-6
        scale = 1.0 + np.abs(wanted).max(axis=1)
        assert np.abs(model.A[:10, :10] - wanted[:, :10]).max(axis=1) / scale == pytest.approx(0.0, abs=1e-6)
        lagging = assembly.params.parts["inverse_lag"] > 0.0
        by_extension = model.B[:10].copy()
        by_extension[:, lagging] = model.A[:10, 10:]
        assert np.abs(by_extension - wanted[:, 10:]).max(axis=1) / scale == pytest.approx(0.0, abs=1e-6)


def test_the_drift_is_the_kernels_rate():
    assembly = assemble(load_preset("seawing-spiral"))
    point = OperatingPoint(
        depth=9.0, roll=0.2, pitch=-0.4, velocity=(0.4, 0.02, 0.01), angular_velocity=(0.1, 0.0, 0.05)
    )
    model = linearize(assembly, point)
    assert not model.is_equilibrium
    assert "not an equilibrium" in model.notes[0]
    speed_down = -math.sin(-0.4) * 0.4 + math.cos(-0.4) * (math.sin(0.2) * 0.02 + math.cos(0.2) * 0.01)
    assert model.drift[0] == pytest.approx(speed_down, rel=1e-12)


@pytest.mark.parametrize("yaw", [0.7, -2.5])
def test_eigenvalues_do_not_depend_on_the_heading(yaw):
    design, point = spiral_point("seawing-spiral")
    assembly = assemble(design)
    turned = OperatingPoint(**{**point.__dict__, "yaw": yaw})
    roots = [np.sort_complex(np.linalg.eigvals(linearize(assembly, at).A)) for at in (point, turned)]
    np.testing.assert_allclose(roots[0], roots[1], atol=1e-7)


def test_a_uniform_current_changes_nothing_but_the_way_over_ground():
    design = load_preset("seawing-spiral")
    carried = changed(design, environment={"current": {"kind": "uniform", "velocity": [0.3, -0.2]}})
    _, point = spiral_point("seawing-spiral")
    still, moved = linearize(design, point), linearize(carried, point)
    for name in ("A", "B", "C", "D", "drift"):
        np.testing.assert_allclose(getattr(moved, name), getattr(still, name), atol=1e-8, err_msg=name)
    by_name = [{s.name: s.value for s in model.outputs} for model in (still, moved)]
    assert by_name[1]["x_dot"] - by_name[0]["x_dot"] == pytest.approx(0.3, abs=1e-12)
    assert by_name[1]["y_dot"] - by_name[0]["y_dot"] == pytest.approx(-0.2, abs=1e-12)


def test_of_a_sheared_current_only_the_shear_acts():
    """Velocities are seen from the water at the point's depth: its speed there does not matter, its shear does."""
    design = load_preset("seawing-spiral")
    point = OperatingPoint(depth=9.0, roll=0.1, pitch=-0.4, yaw=0.8, velocity=(0.4, 0.02, 0.01))
    models = []
    for velocity, shear in (([0.0, 0.0], [0.02, -0.01]), ([0.3, -0.2], [0.02, -0.01]), ([0.3, -0.2], [0.0, 0.0])):
        current = {"kind": "sheared", "surface_velocity": velocity, "shear": shear}
        models.append(linearize(changed(design, environment={"current": current}), point))
    np.testing.assert_allclose(models[1].A, models[0].A, atol=2e-8)
    np.testing.assert_allclose(models[1].drift, models[0].drift, atol=1e-12)
    assert np.abs(models[2].A - models[0].A).max() > 1e-3
    # a velocity that is held is held over ground, also where the depth differs
    at, z = models[0].output_names.index, models[0].state_names.index("z")
    assert [models[0].C[at(name), z] for name in ("x_dot", "y_dot")] == pytest.approx([0.0, 0.0], abs=1e-9)


def test_the_motion_matrix_is_the_models_own_and_knows_no_current():
    design = load_preset("seawing-spiral")
    carried = changed(design, environment={"current": {"kind": "uniform", "velocity": [0.3, -0.2]}})
    found = []
    for each in (design, carried):
        assembly = assemble(each)
        found.append(motion_matrix(assembly, assembly.params, assembly.initial_state))
    names, A = found[0]
    np.testing.assert_allclose(found[1][1], A, atol=1e-8)
    point = OperatingPoint.from_run(simulate(design), 0.0)
    model = linearize(design, point)
    kept = [model.state_names.index(name) for name in names]
    np.testing.assert_allclose(model.A[np.ix_(kept, kept)], A, atol=1e-9)


def test_a_resting_body_rolls_as_a_pendulum():
    """With added inertia in roll but no added mass the body turns about its centre of mass: w2 = m g h / (I + A44)."""
    below, more = 0.004, 0.006
    model = linearize(resting_design(below=below, added={3: more}), REST)
    roots = np.linalg.eigvals(model.A)
    omega = math.sqrt(MASS * GRAVITY * below / (INERTIA["xx"] + more))
    assert np.abs(roots - 1j * omega).min() == pytest.approx(0.0, abs=1e-7)
    pitch = math.sqrt(MASS * GRAVITY * below / INERTIA["yy"])
    assert np.abs(roots - 1j * pitch).min() == pytest.approx(0.0, abs=1e-7)


@pytest.mark.parametrize("model", ["planar", "spatial"])
def test_damping_stops_heave(model):
    made = linearize(resting_design(added={2: 0.5}, damping={"heave": 0.3}, model=model), REST)
    # drag over the step of the differences, 2e-6 m/s, leaves 1e-5 of it
    assert np.abs(np.linalg.eigvals(made.A) + 0.3 / (MASS + 0.5)).min() == pytest.approx(0.0, abs=1e-4)


def test_layers_let_a_neutral_body_bob():
    """Density rho (1 + s (z - z0)): w2 = g s m / (m + A33), added mass being that at the surface's density."""
    rise = 1e-3
    ends = [DENSITY * (1.0 - 10.0 * rise), DENSITY * (1.0 + 10.0 * rise)]
    water = {"kind": "density_profile", "depths": [0.0, 20.0], "densities": ends}
    model = linearize(resting_design(added={2: 0.5}, water=water), REST)
    omega = math.sqrt(GRAVITY * rise * MASS / (MASS + 0.5 * ends[0] / DENSITY))
    roots = np.linalg.eigvals(model.A)
    assert np.abs(roots.imag - omega).min() == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("preset_id", ["three-cell-glider", "canete-dual-bellows", "slocum-glide"])
def test_space_is_the_plane_in_its_plane(preset_id):
    design = load_preset(preset_id)
    point = OperatingPoint(depth=1.0, pitch=-0.4, velocity=(0.2, 0.0, 0.03), angular_velocity=(0.0, 0.05, 0.0))
    plane = linearize(design, point)
    space = linearize(changed(design, solver={"model": "spatial"}), point)
    rows = [space.state_names.index(name) for name in plane.state_names]
    np.testing.assert_allclose(space.A[np.ix_(rows, rows)], plane.A, atol=2e-7)
    np.testing.assert_allclose(space.B[rows], plane.B, atol=2e-6)
    outputs = [space.output_names.index(name) for name in plane.output_names]
    np.testing.assert_allclose(space.C[np.ix_(outputs, rows)], plane.C, atol=2e-6)
    np.testing.assert_allclose(space.D[outputs], plane.D, atol=2e-5)
    beside = [i for i in range(len(space.A)) if i not in rows]
    assert np.abs(space.A[np.ix_(beside, rows)]).max() < 1e-8


def test_what_the_model_leaves_is_of_second_order():
    """Steps of a command from a trim, halved twice, against the full equations."""
    design = changed(load_preset("three-cell-glider"), solver={"tolerance": 1e-12}, duration=8.0)
    design = changed(design, environment={"bed_depth": None}, initial={"position": [0.0, 0.0, 50.0]})
    ends = {s.cell: s.points[-1].extension for s in design.mission.control.schedules}
    trim = find_trims(design, extensions=ends).stable[0]
    model = linearize(design, point_of(trim))
    command = np.array([float(name == "command of Rear bellows") for name in model.input_names])
    errors = []
    for step in (4e-4, 2e-4, 1e-4):
        document = design_from(trim, design).model_dump(mode="json")
        points = [{"time": 0.0, "extension": trim.extensions["Rear bellows"] - step}]
        document["mission"]["control"] = {"schedules": [{"cell": "Rear bellows", "points": points}]}
        run = simulate(parse_design(document))
        linear = model.step_response(-step * command, run.times)
        at = [(k, s) for k, s in enumerate(model.states) if s.name in run.values]
        errors.append(max(float(np.abs(run.values[s.name] - s.value - linear[:, k]).max()) for k, s in at))
    assert observed_orders(errors) == pytest.approx(2.0, abs=0.1)
    assert errors[0] > 1e-6  # there was something to see, above the tolerance


def test_a_lag_is_a_state_and_a_part_without_follows_at_once():
    lagging = PISTON | {"lag": 0.4, "rate_limit": 1e-3}
    quick = PISTON | {"name": "Quick", "position": [-0.15, 0.0, 0.0]}
    model = linearize(design_of(lagging, quick), OperatingPoint(depth=5.0, velocity=(0.3, 0.0, 0.02)))
    assert model.state_names[-1] == "extension of Piston" and len(model.states) == 6
    k = len(model.states) - 1
    assert model.A[k, k] == pytest.approx(-2.5) and model.B[k].tolist() == [pytest.approx(2.5), 0.0]
    assert not model.B[:k, 0].any() and model.B[:k, 1].any()
    row = model.output_names.index("extension of Quick")
    assert model.D[row].tolist() == [0.0, 1.0] and not model.C[row].any()
    lift = model.output_names.index("net_buoyancy")
    per_metre = DENSITY * GRAVITY * PISTON["area"]
    assert model.D[lift, 1] == pytest.approx(per_metre, rel=1e-6)
    assert model.C[lift, k] == pytest.approx(per_metre, rel=1e-6)
    assert any("rate limit of 'Piston'" in note for note in model.notes)


def test_a_part_under_way_drifts_toward_its_command():
    part = PISTON | {"lag": 0.5}
    point = OperatingPoint(depth=5.0, extensions={"Piston": 1e-3}, commands={"Piston": 2e-3})
    model = linearize(design_of(part), point)
    assert model.drift[-1] == pytest.approx(2e-3)
    assert model.inputs[0].value == 2e-3 and model.states[-1].value == 1e-3


def test_outputs_are_slopes_of_what_a_run_shows():
    """speed = |v|, alpha = atan2(w, u), z_dot by the attitude: in closed form."""
    u, w, theta = 0.3, 0.04, -0.3
    model = linearize(load_preset("three-cell-glider"), OperatingPoint(depth=1.0, pitch=theta, velocity=(u, 0.0, w)))
    of, at = model.output_names.index, model.state_names.index
    V = math.hypot(u, w)
    assert model.C[of("speed"), at("u")] == pytest.approx(u / V, abs=1e-8)
    assert model.C[of("alpha"), at("w")] == pytest.approx(u / V**2, abs=1e-7)
    assert model.C[of("alpha"), at("u")] == pytest.approx(-w / V**2, abs=1e-7)
    assert model.C[of("z_dot"), at("theta")] == pytest.approx(-math.cos(theta) * u - math.sin(theta) * w, abs=1e-8)
    assert [s.unit for s in model.outputs if s.name in ("speed", "alpha", "lift")] == ["m/s", "rad", "N"]


def test_at_rest_there_is_no_angle_of_attack():
    model = linearize(resting_design(), REST)
    assert not {"alpha", "beta", "speed", "flow_angle"} & set(model.output_names)
    assert model.is_equilibrium and any("at rest" in note for note in model.notes)


def test_a_point_of_a_run_is_that_of_its_trim():
    design, point = spiral_point("seawing-spiral")
    trim = point_of(find_trims(design).stable[0])
    assert point.roll == pytest.approx(trim.roll, abs=1e-6) and point.pitch == pytest.approx(trim.pitch, abs=1e-6)
    assert point.velocity == pytest.approx(trim.velocity, abs=1e-6)
    assert point.angular_velocity == pytest.approx(trim.angular_velocity, abs=1e-6)
    assert linearize(design, trim).residual < 1e-12


def test_velocities_of_a_run_in_a_current_are_those_through_the_water():
    design = changed(load_preset("seawing-spiral"), duration=60.0)
    carried = changed(design, environment={"current": {"kind": "uniform", "velocity": [0.3, -0.2]}})
    still, moved = (OperatingPoint.from_run(simulate(each), 40.0) for each in (design, carried))
    assert moved.velocity == pytest.approx(still.velocity, abs=1e-7)


def test_between_samples_a_point_of_a_run_is_interpolated():
    """Straight lines between the two samples about it; through north the shorter way, in a current relative to it."""
    current = {"current": {"kind": "uniform", "velocity": [0.3, -0.2]}}
    run = simulate(changed(load_preset("quad-bellows-spiral"), duration=120.0, environment=current))
    k = len(run.times) // 2
    a, b = float(run.times[k]), float(run.times[k + 1])
    ends = [OperatingPoint.from_run(run, time) for time in (a, b)]
    at = OperatingPoint.from_run(run, 0.75 * a + 0.25 * b)
    assert at.time == pytest.approx(0.75 * a + 0.25 * b, abs=1e-12)
    for name in ("depth", "roll", "pitch", "yaw", "velocity", "angular_velocity"):
        first, last = (np.array(getattr(end, name)) for end in ends)
        assert np.array(getattr(at, name)) == pytest.approx(0.75 * first + 0.25 * last, abs=1e-12), name
    for cell, extension in at.extensions.items():
        first, last = (end.extensions[cell] for end in ends)
        assert extension == pytest.approx(0.75 * first + 0.25 * last, abs=1e-15)
    assert ends[0].depth == run.values["z"][k] and ends[0].time == a
    psi = run.values["psi"].copy()
    psi[[k, k + 1]] = 3.1, -3.1
    over = OperatingPoint.from_run(replace(run, values=run.values | {"psi": psi}), 0.5 * (a + b))
    assert math.remainder(over.yaw - math.pi, math.tau) == pytest.approx(0.0, abs=1e-12)
    assert OperatingPoint.from_run(run, -1.0).time == 0.0
    assert OperatingPoint.from_run(run, 1e9) == OperatingPoint.from_run(run, float(run.times[-1]))


def test_the_model_can_be_sent():
    model = linearize(load_preset("seawing-spiral"), OperatingPoint(depth=5.0, velocity=(0.4, 0.0, 0.0)))
    sent = json.loads(json.dumps(model.as_dict(), allow_nan=False))
    assert np.array(sent["A"]).shape == (len(sent["states"]),) * 2
    assert len(sent["outputs"]) == len(sent["C"]) == len(sent["D"])
    assert all(
        signal["unit"] and signal["meaning"] for kind in ("states", "inputs", "outputs") for signal in sent[kind]
    )


def test_states_can_be_held():
    model = linearize(load_preset("seawing-spiral"), OperatingPoint(depth=5.0, velocity=(0.4, 0.0, 0.0)))
    held = model.without("z", "psi")
    assert held.state_names == model.state_names[1:3] + model.state_names[4:]
    np.testing.assert_array_equal(held.A, np.delete(np.delete(model.A, [0, 3], 0), [0, 3], 1))
    with pytest.raises(DesignError, match="no state named"):
        model.without("x")


@pytest.mark.parametrize(
    ("point", "pointer"),
    [
        (OperatingPoint(extensions={"Sail": 0.0}), "/extensions/Sail"),
        (OperatingPoint(extensions={"Front bellows": 9.0}), "/extensions/Front bellows"),
        (OperatingPoint(roll=0.1), "/roll"),
        (OperatingPoint(velocity=(0.1, 0.1, 0.0)), "/velocity/1"),
    ],
)
def test_points_that_do_not_fit_are_refused(point, pointer):
    with pytest.raises(DesignError) as refused:
        linearize(load_preset("three-cell-glider"), point)
    assert refused.value.problems[0].pointer == pointer


@pytest.mark.parametrize("pitch_deg", [89.95, -90.0, 90.05, 270.0])
def test_straight_up_and_down_are_refused_in_space(pitch_deg):
    with pytest.raises(DesignError, match=r"within 0\.1 deg") as refused:
        linearize(load_preset("seawing-spiral"), OperatingPoint(pitch=math.radians(pitch_deg)))
    assert refused.value.problems[0].pointer == "/pitch"


def test_in_the_plane_any_pitch_will_do():
    design = load_preset("three-cell-glider")
    for pitch in (math.pi / 2, 2.6, -math.pi):
        assert np.isfinite(linearize(design, OperatingPoint(pitch=pitch, velocity=(0.2, 0.0, 0.01))).A).all()


def test_upside_down_is_the_same_attitude_by_other_angles():
    """Pitch past 90 deg is roll and yaw turned by 180 deg: the same motion, the same eigenvalues."""
    design = load_preset("seawing-spiral")
    motion = {"depth": 9.0, "velocity": (0.4, 0.02, 0.01), "angular_velocity": (0.0, 0.05, 0.1)}
    over = OperatingPoint(roll=0.2, pitch=math.pi - 0.5, **motion)
    same = OperatingPoint(roll=0.2 - math.pi, pitch=0.5, yaw=math.pi, **motion)
    roots = [np.sort_complex(np.linalg.eigvals(linearize(design, at).A)) for at in (over, same)]
    np.testing.assert_allclose(roots[0], roots[1], atol=1e-7)
