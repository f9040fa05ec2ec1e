"""Stability over a run: margins by closed forms and by other means, and their changes of sign in a made-up schedule."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from models.assemble import assemble
from models.design import parse_design
from models.hydrodynamic_law import build_law
from models.kernel import spatial_layout
from models.kernel.model import loads
from models.linearize import motion_matrix
from models.margins import down_along, hydrodynamics, hydrostatics, offset_along
from models.presets import load_preset
from models.problems import DesignError
from models.run_warnings import turning_over
from models.simulate import simulate
from models.stability import QUANTITIES, Quantity, stability_over, stretches_lost, warning_of
from models.trim import design_from, find_trims
from models.vehicle_length import vehicle_length
from tests.models.linear_support import quaternion_of
from tests.models.support import document, polar
from tests.models.test_spatial_truths import changed

HULL, SLIDE = 0.9, 0.1
"""Masses, kg."""


def sliding(end=-0.05, duration=10.0, model="planar", **mission):
    """A neutral body: 0.9 kg at 4 mm below its centre, 0.1 kg that slides up from there to `end` (down is +)."""
    hull = {
        "kind": "rigid", "name": "Hull", "mass": HULL, "volume": 1e-3, "position": [0.0, 0.0, 0.0],
        "center_of_mass": [0.0, 0.0, 0.004], "inertia": {"xx": 0.01, "yy": 0.02, "zz": 0.02},
        "shapes": [{"kind": "hull", "length": 0.5, "radius": 0.05, "nose_length": 0.1, "tail_length": 0.1}],
    }  # fmt: skip
    slide = {
        "kind": "movable_mass", "name": "Slide", "mass": SLIDE, "position": [0.0, 0.0, 0.004], "axis": [0.0, 0.0, 1.0],
        "extension_range": [-0.1, 0.1], "neutral_extension": 0.0,
    }  # fmt: skip
    changed = document(hull, initial={"position": [0.0, 0.0, 50.0]}, duration=duration, **mission)
    changed["vehicle"]["components"] = [hull, slide]
    changed["vehicle"]["damping"] = {"pitch": 5.0, "roll": 5.0, "yaw": 5.0}
    points = [{"time": 0.0, "extension": 0.0}, {"time": duration, "extension": end, "shape": "ramp"}]
    changed["mission"] |= {
        "control": {"schedules": [{"cell": "Slide", "points": points}]},
        "solver": {"model": model, "output_interval": 0.1},
    }
    return parse_design(changed)


@pytest.mark.parametrize("model", ["planar", "spatial"])
def test_a_change_of_sign_is_found_when_it_happens(model):
    """The centre of mass passes the centre of buoyancy where 0.1 e = -4 mm x 1 kg, e = -5 mm t: at 8 s."""
    run = simulate(sliding(model=model))
    history = stability_over(run)
    np.testing.assert_allclose(history.hydrostatic_margin, 0.004 - SLIDE * 0.005 * run.times, atol=1e-9)
    told = [w for w in history.warnings if "centre of buoyancy" in w.message]
    assert len(told) == 1 and "first lost at 8.00 s" in told[0].message and told[0].limit == 0.0
    assert "longest below 0 from 8.00 to 10.00 s, at worst -0.001 m at 10.00 s" in told[0].message
    assert "small motions are not stable all the while" in told[0].message
    assert told[0].pointer == "/vehicle/components"
    (change,) = [c for c in history.changes if c.name == "hydrostatic_margin"]
    assert change.lost and change.time == pytest.approx(8.0, abs=1e-6)
    worst = history.extreme("hydrostatic_margin")
    assert worst.time == pytest.approx(10.0) and worst.value == pytest.approx(-0.001, abs=1e-9)
    assert any(w.message.startswith("the growth of small motions") for w in history.warnings)
    assert any(change.name == "growth" and change.lost for change in history.changes)
    (told,) = turning_over(run)
    assert told.pointer == "/vehicle/components" and "first at 8.1 s" in told.message and "1 mm" in told.message


def test_what_stays_upright_is_not_warned_of():
    run = simulate(sliding(end=0.05))
    assert list(turning_over(run)) == []
    assert not [w for w in stability_over(run).warnings if w.pointer == "/vehicle/components"]


def test_changes_of_sign_are_kept_one_by_one_and_told_in_one_message():
    run = simulate(sliding(end=0.05))
    theta = np.full(len(run.times), 0.0)
    theta[1::2] = math.pi  # overturned at every other sample
    history = stability_over(replace(run, values=run.values | {"theta": theta}))
    changes = [c for c in history.changes if c.name == "hydrostatic_margin"]
    assert len(changes) == len(run.times) - 1
    assert [c.lost for c in changes[:3]] == [True, False, True]
    (told,) = [w.message for w in history.warnings if "centre of buoyancy" in w.message]
    assert f"changes sign {len(changes)} times: first lost at 0.05 s" in told


WAVE = Quantity("pitch_margin", "the margin", "1", "/vehicle/hydrodynamics", 1e-6)
NONE = (np.zeros(1), np.full(1, np.nan))


def test_the_longest_stretch_is_told_with_its_worst_value_and_growth():
    """sin t from -0.1 to 12 s: below 0 at first, from pi to 2 pi, and from 3 pi to the end."""
    times = np.linspace(-0.1, 12.0, 12101)
    values = np.where(times < 6.0, 1.0, 0.5) * np.sin(times)
    stretches = stretches_lost(WAVE, times, values)
    assert np.array(stretches) == pytest.approx(
        np.array([[-0.1, 0.0], [math.pi, 2.0 * math.pi], [3.0 * math.pi, 12.0]]), abs=1e-5
    )
    growth = np.array([0.0, 4.0, 5.0, 8.0]), np.array([0.3, -0.2, -0.1, 0.4])
    told = warning_of(WAVE, times, values, growth)
    assert told is not None
    assert "changes sign 4 times: first lost at the start, -0.10 s (until 0.00 s)" in told.message
    assert "longest below 0 from 3.14 to 6.28 s, at worst -1 at 4.71 s" in told.message
    assert "not stable all the while (growth up to 0.114 1/s)" in told.message  # a line from -0.1 at 5 s, at 2 pi
    steady = warning_of(WAVE, times, values, (growth[0], -np.abs(growth[1])))
    assert steady is not None and "; small motions are stable all the while (growth at most -0.1 1/s)" in steady.message
    assert warning_of(WAVE, times, values, NONE).message.endswith("at 4.71 s")


def test_what_never_has_the_right_sign_is_told_and_what_always_has_is_not():
    times = np.arange(5.0)
    told = warning_of(WAVE, times, np.array([np.nan, -1.0, -3.0, -2.0, np.nan]), NONE)
    assert told is not None and told.message == "the margin is below 0 all the time, at worst -3 at 2.00 s"
    assert warning_of(WAVE, times, np.ones(5), NONE) is None
    assert warning_of(WAVE, times, np.full(5, np.nan), NONE) is None


def test_a_preset_that_starts_at_rest_is_warned_of_once_for_each_quantity():
    """Its pitch margin changes sign often while it falls broadside; what counts is that it stays negative then."""
    history = stability_over(simulate(load_preset("quad-bellows-glide")))
    assert len([c for c in history.changes if c.name == "pitch_margin"]) > 5
    (told,) = [w.message for w in history.warnings if "margin in pitch" in w.message]
    assert "first lost at 12.00 s" in told and "stable all the while" in told and "not stable" not in told
    assert len(history.warnings) == len({(w.pointer, w.message.split(" changes ")[0]) for w in history.warnings}) <= 3


def test_stiffness_is_how_the_moment_at_rest_changes():
    """Turned about its own axes from several attitudes; in one density, where depth does not matter."""
    design = changed(
        load_preset("quad-bellows-spiral"), environment={"water": {"density": 999.0}, "surface": "end"}, duration=100.0
    )
    run, assembly = simulate(design), assemble(design)
    still = hydrostatics(run)
    p = assembly.params
    weight = float(p.space[0]["mass"] * p.space[0]["gravity"])
    for i in range(5, len(run.times), 97):
        angles = [float(run.values[n][i]) for n in ("phi", "theta", "psi")]
        extensions = run.cell_values["extension"][i]
        q, h = quaternion_of(np.array(angles)), 1e-5
        for axis, wanted in ((0, still.roll[i]), (1, still.pitch[i])):
            moments = []
            for sign in (1.0, -1.0):
                y = np.zeros(len(assembly.initial_state))
                turn = np.zeros(4)
                turn[0], turn[1 + axis] = math.cos(h / 2), sign * math.sin(h / 2)
                a, b = q[1:], turn[1:]  # q times turn: about the body's own axis
                y[3:7] = [q[0] * turn[0] - a @ b, *(q[0] * b + turn[0] * a + np.cross(a, b))]
                y[spatial_layout.Z] = run.values["z"][i]
                y[spatial_layout.EXTENSIONS : spatial_layout.EXTENSIONS + 4] = extensions
                out = np.zeros(6)
                loads(0.0, y, p, out)
                moments.append(out[3 + axis])
            assert -(moments[0] - moments[1]) / (2 * h) / weight == pytest.approx(wanted, abs=1e-7)


def test_the_margin_is_one_offset_along_gravity():
    run = simulate(load_preset("seawing-spiral"))
    still = hydrostatics(run)
    for i in (0, 50, 500):
        phi, theta = run.values["phi"][i], run.values["theta"][i]
        down = np.array([-math.sin(theta), math.cos(theta) * math.sin(phi), math.cos(theta) * math.cos(phi)])
        offset = [run.values[f"com_{a}"][i] - run.values[f"cob_{a}"][i] for a in "xyz"]
        assert still.margin[i] == pytest.approx(float(np.dot(offset, down)), abs=1e-12)
        np.testing.assert_allclose(still.offset[i], offset, atol=1e-15)


def glide_in(table, model="planar", lateral=None, **vehicle):
    changed = document(
        initial={"position": [0.0, 0.0, 50.0], "pitch": -0.2, "velocity": [0.4, 0.0, 0.02]}, duration=1.0
    )
    changed["vehicle"]["hydrodynamics"] = table | ({} if lateral is None else {"lateral": lateral})
    changed["vehicle"] |= vehicle
    changed["mission"]["solver"] = {"model": model}
    return parse_design(changed)


@pytest.mark.parametrize("model", ["planar", "spatial"])
def test_the_pitch_margin_is_that_of_the_laws_slopes(model):
    """x_n = -dM/dZ over alpha, from lift, drag and moment of the fitted law: Z = -D sin a - L cos a."""
    design = glide_in(polar(), model)
    run, law = simulate(design), build_law(design.vehicle.hydrodynamics)
    found = hydrodynamics(run, assemble(design))

    def z_and_m(alpha):
        lift, drag, moment = law(alpha)
        return np.array([-drag * math.sin(alpha) - lift * math.cos(alpha), moment])

    for i in range(0, len(run.times), 7):
        alpha, h = float(run.values["alpha"][i]), 1e-5
        slope = (z_and_m(alpha + h) - z_and_m(alpha - h)) / (2 * h)
        neutral = -slope[1] / slope[0]
        wanted = (run.values["com_x"][i] - neutral) / found.length
        assert found.pitch[i] == pytest.approx(wanted, abs=1e-5)


def test_the_munk_moment_counts_where_the_table_lacks_it():
    """Moment and force of a level flow: M_a = t' + (A33 - A11) V2, and the neutral point moves by it."""
    added = {"enabled": True, "matrix": np.diag([0.2, 0.5, 1.4, 0.01, 0.02, 0.02]).tolist(), "density": 1000.0}
    margins = []
    for held in (True, False):
        for model in ("planar", "spatial"):
            design = glide_in(polar(includes_munk_moment=held), model, added_mass=added)
            run = simulate(design)
            first = run.select(np.arange(1))
            margins.append((hydrodynamics(first, assemble(design)).pitch[0], first, design))
    assert margins[0][0] == pytest.approx(margins[1][0], abs=1e-9)  # planar and spatial
    assert margins[2][0] == pytest.approx(margins[3][0], abs=1e-9)
    alpha, h = float(margins[0][1].values["alpha"][0]), 1e-5
    law = build_law(margins[0][2].vehicle.hydrodynamics)
    z = [-law(a)[1] * math.sin(a) - law(a)[0] * math.cos(a) for a in (alpha + h, alpha - h)]
    per_alpha = (z[0] - z[1]) / (2 * h)
    munk = 1.2 * math.cos(2.0 * alpha)  # d/da of (A33 - A11) cos a sin a
    length = hydrodynamics(margins[0][1], assemble(margins[0][2])).length
    assert (margins[2][0] - margins[0][0]) * length == pytest.approx(munk / per_alpha, rel=1e-4)


def test_the_yaw_margin_is_that_of_the_lateral_coefficients():
    """x_n = N_b / Y_b where roll and yaw hold the Munk moment."""
    lateral = {"source": "Made up.", "includes_munk_moment": True, "sway_sideslip": -20.0, "yaw_sideslip": 3.0}
    design = glide_in(polar(), "spatial", lateral)
    run = simulate(design)
    found = hydrodynamics(run, assemble(design))
    wanted = (run.values["com_x"] - 3.0 / -20.0) / found.length
    np.testing.assert_allclose(found.yaw, wanted, atol=1e-6)
    assert found.yaw[0] > 0.0  # the force acts behind: it turns the nose into the flow


@pytest.mark.parametrize("surge", [0.3, -0.3])
@pytest.mark.parametrize("mass_ahead", [0.15, -0.15])
def test_positive_margins_right_it_whichever_way_it_moves(surge, mass_ahead):
    """Turned by a small angle while it moves on, by the kernel's own loads about the centre of mass."""
    lateral = {"source": "Made up.", "includes_munk_moment": True, "sway_sideslip": -20.0, "yaw_sideslip": 0.3}
    made = glide_in(polar(), "spatial", lateral).model_dump(mode="json")
    made["vehicle"]["components"][0]["center_of_mass"] = [mass_ahead, 0.0, 0.0]
    made["mission"]["initial"] |= {"pitch": 0.0, "velocity": [surge, 0.0, 0.0]}
    design = parse_design(made)
    assembly, run = assemble(design), simulate(design).select(np.arange(1))
    found, center = hydrodynamics(run, assembly), run.values["com_x"][0]

    def moments(pitch_up: float, to_starboard: float) -> tuple[float, float]:
        y, out = assembly.initial_state.copy(), np.zeros(6)
        y[spatial_layout.V], y[spatial_layout.W] = -surge * to_starboard, surge * pitch_up
        loads(0.0, y, assembly.params, out)
        return out[4] + center * out[2], out[5] - center * out[1]

    h = 1e-5
    in_pitch = (moments(h, 0.0)[0] - moments(-h, 0.0)[0]) / (2 * h)
    in_yaw = (moments(0.0, h)[1] - moments(0.0, -h)[1]) / (2 * h)
    assert abs(in_pitch) > 0.1 and abs(in_yaw) > 0.1
    assert (found.pitch[0] > 0.0) == (in_pitch < 0.0)
    assert (found.yaw[0] > 0.0) == (in_yaw < 0.0)
    assert (found.yaw[0] > 0.0) == (surge * mass_ahead > 0.0)  # the mass first


def test_without_side_force_there_is_no_neutral_point_in_yaw():
    design = glide_in(polar(), "spatial")
    assert np.isnan(hydrodynamics(simulate(design), assemble(design)).yaw).all()


def test_at_rest_there_is_no_hydrodynamic_margin():
    run = simulate(sliding(model="spatial"))
    history = stability_over(run.select(np.arange(1)))
    assert np.isnan(history.pitch_margin).all() and history.extreme("pitch_margin") is None
    json.dumps(history.as_dict(), allow_nan=False)


def test_growth_is_that_of_the_motion_matrix():
    design = changed(load_preset("seawing-spiral"), duration=60.0)
    run, assembly = simulate(design), assemble(design)
    history = stability_over(run, 7)
    assert len(history.growth) == 7 and history.growth_times[[0, -1]].tolist() == [0.0, 60.0]
    _names, A = motion_matrix(assembly, assembly.params, assembly.initial_state)
    assert history.growth[0] == pytest.approx(np.linalg.eigvals(A).real.max(), abs=1e-9)


def test_every_preset_has_a_history_that_can_be_sent():
    for preset_id in ("three-cell-glider", "slocum-glide"):
        history = stability_over(simulate(load_preset(preset_id)), 20)
        sent = json.loads(json.dumps(history.as_dict(), allow_nan=False))
        assert all(len(sent[q.name]) in (len(sent["times"]), len(sent["growth_times"])) for q in QUANTITIES)
        assert history.extreme("hydrostatic_margin").value > 0.0


def test_growth_is_told_at_steep_instants_too():
    """Straight up at rest the mass 4 mm below the axis hangs beside it; frozen there, that neither rights nor damps."""
    design = changed(sliding(end=0.05, model="spatial"), initial={"pitch": math.pi / 2, "velocity": [0.0, 0.0, 0.0]})
    history = stability_over(simulate(design), 5)
    assert np.isfinite(history.growth).all()


@pytest.mark.parametrize("current", [None, [0.3, -0.2]])
def test_growth_near_the_vertical_is_that_of_a_steady_dive(current):
    """A body that sinks nose down: by a run, by its trim, and with Euler angles a little beside the vertical."""
    made = sliding(end=0.0, model="spatial").model_dump(mode="json")
    made["vehicle"]["components"][0] |= {"center_of_mass": [0.02, 0.0, 0.0], "volume": 9.9e-4}
    made["vehicle"]["components"][1] |= {"position": [0.02, 0.0, 0.0]}
    made["mission"]["solver"]["tolerance"] = 1e-10
    if current:
        made["mission"]["environment"] = {"current": {"kind": "uniform", "velocity": current}}
    trim = next(t for t in find_trims(parse_design(made)).solutions if t.pitch < -1.5)
    design = design_from(trim, parse_design(made))
    assembly, run = assemble(design), simulate(design)
    assert abs(math.degrees(trim.pitch) + 90.0) < 0.1
    assert stability_over(run, 3).growth == pytest.approx(trim.growth, abs=1e-6)
    y = assembly.initial_state.copy()
    tilted = quaternion_of(np.array([0.0, trim.pitch + 5e-3, 0.0]))
    y[spatial_layout.Q0 : spatial_layout.Q3 + 1] = tilted
    _names, A = motion_matrix(assembly, assembly.params, y)
    assert np.linalg.eigvals(A).real.max() == pytest.approx(trim.growth, abs=0.02 * (1.0 + abs(trim.growth)))


def test_floating_gliders_are_not_said_to_turn_over():
    """At the surface the centre of buoyancy is that of what is immersed; the preset floats between its dives."""
    design = load_preset("quad-bellows-yo-yo")
    run = simulate(changed(design, duration=3000.0))
    assert (run.values["z"] < 0.1).any()
    raw = sum(offset * down for offset, down in zip(offset_along(run), down_along(run), strict=True))
    assert raw.min() < -1e-4 and list(turning_over(run)) == []


def test_samples_are_positive():
    with pytest.raises(DesignError, match="at least 1"):
        stability_over(simulate(sliding(duration=1.0)), 0)


@pytest.mark.parametrize(
    ("preset_id", "length"), [("quad-bellows-spiral", 2.0), ("seawing-spiral", 2.0), ("slocum-glide", 1.5)]
)
def test_the_length_is_that_of_the_shapes(preset_id, length):
    assert vehicle_length(load_preset(preset_id).vehicle) == pytest.approx(length)


def test_length_from_wings_positions_and_nothing():
    base = document()
    assert vehicle_length(parse_design(base).vehicle) == pytest.approx(0.15 + 0.15 * 0.05 / 0.95)  # positions
    wing = {"kind": "wing", "span": 1.0, "chord": 0.2, "tip_chord": 0.1, "sweep": 0.3, "offset": [0.1, 0.0, 0.0]}
    base["vehicle"]["components"][0]["shapes"] = [wing]
    assert vehicle_length(parse_design(base).vehicle) == pytest.approx(
        0.4
    )  # from the nose of the root to the tip's tail
    tilted = {"kind": "cylinder", "length": 0.2, "radius": 0.05, "axis": [0.0, 0.0, 1.0]}
    base["vehicle"]["components"][0]["shapes"] = [tilted]
    assert vehicle_length(parse_design(base).vehicle) == pytest.approx(0.1)  # its width
    base["vehicle"]["components"] = base["vehicle"]["components"][:1]
    base["vehicle"]["components"][0]["shapes"] = []
    base["mission"]["control"] = {}
    assert vehicle_length(parse_design(base).vehicle) == 1.0
