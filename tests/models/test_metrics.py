"""Metrics of runs against closed forms, and against each other where they are two ways to one number."""

import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from models.built_in_metrics import BUILT_IN, WHOLE_ONLY
from models.energy import energy_bill
from models.metrics import DEFAULT_METRICS, evaluate, metrics_for
from models.presets import load_preset, preset_ids
from models.run import Event
from models.simulate import simulate
from tests.models.metric_support import CELL, PLANAR, SPATIAL, refined, run_of, value

STATISTICS = ("maximum", "minimum", "mean", "first", "final", "rms", "standard_deviation", "span", "travel",
              "time_integral")  # fmt: skip
SPEED, GLIDE = 0.3, math.radians(25.0)


def statistic(name, of="z", **more):
    return {"kind": "statistic", "of": of, "statistic": name, **more}


def over_time(begin, end):
    return {"kind": "time", "begin": begin, "end": end}


@pytest.fixture(scope="module")
def yo_yo():
    """Four dives to 100 m, as a sine."""
    t = np.linspace(0.0, 4000.0, 4001)
    phase = 2.0 * np.pi * t / 1000.0
    return run_of(t, z=50.0 * (1.0 - np.cos(phase)), z_dot=0.1 * np.pi * np.sin(phase), x=0.2 * t)


@pytest.fixture(scope="module")
def surfacing():
    """A simulated glide of several dives, with its bill."""
    return simulate(load_preset("quad-bellows-yo-yo"))


def straight(t):
    down, along = SPEED * math.sin(GLIDE), SPEED * math.cos(GLIDE)
    return run_of(
        t, x=0.6 * along * t, y=0.8 * along * t, z=2.0 + down * t, speed=np.full(len(t), SPEED),
        z_dot=np.full(len(t), down), battery_energy=5.0 + 2.0 * t,
    )  # fmt: skip


def test_a_straight_glide():
    run = straight(np.array([0.0, 7.0, 11.0, 300.0, 300.5]))
    along = 300.5 * SPEED * math.cos(GLIDE)
    expected = {
        "range": along, "way": along, "duration": 300.5, "glide_ratio": 1.0 / math.tan(GLIDE),
        "mean_glide_angle": GLIDE, "mean_speed": SPEED, "mean_sink_rate": SPEED * math.sin(GLIDE),
        "mean_horizontal_speed": SPEED * math.cos(GLIDE), "mean_vertical_speed": SPEED * math.sin(GLIDE),
        "course": math.atan2(0.8, 0.6), "energy": 606.0, "energy_per_km": 606.0 / (1e-3 * along),
        "mean_power": 606.0 / 300.5, "bed_clearance": 118.0 - 300.5 * SPEED * math.sin(GLIDE),
        "final_depth": 2.0 + 300.5 * SPEED * math.sin(GLIDE), "minimum_depth": 2.0, "dives": 1.0,
    }  # fmt: skip
    found = evaluate(run, metrics_for(run.design, list(expected)))
    assert found == pytest.approx(list(expected.values()), rel=1e-12)
    assert math.isnan(value(run, "turn_radius"))  # it does not turn


def test_a_planar_glide_has_a_range_too():
    t = np.linspace(0.0, 100.0, 11)
    run = run_of(t, design=PLANAR, x=-2.0 * t, z=t)
    assert [value(run, name) for name in ("range", "way", "glide_ratio")] == pytest.approx([200.0, 200.0, 2.0])


@pytest.mark.parametrize("turn", [1.0, -1.0])
@pytest.mark.parametrize("drift", [0.0, 0.15])
def test_a_turn_has_its_radius_through_the_water(turn, drift):
    radius, rate = 18.0, 0.012
    t = np.linspace(0.0, 1500.0, 3001)
    around = {"turn_rate": np.full(len(t), turn * rate), "psi": np.angle(np.exp(1j * turn * rate * t))}
    run = run_of(
        t, x_dot=radius * rate * np.cos(rate * t) + drift, y_dot=turn * radius * rate * np.sin(rate * t),
        x=radius * np.sin(rate * t) + drift * t, y=turn * radius * (1 - np.cos(rate * t)),
        current_x=np.full(len(t), drift), **around,
    )  # fmt: skip
    assert value(run, "turn_radius") == pytest.approx(radius, rel=1e-12)
    assert value(run, "heading_change") == pytest.approx(turn * rate * 1500.0, rel=1e-12)
    if drift == 0.0:  # the chords are shorter than the arcs by (rate dt)^2 / 24
        assert value(run, "way") == pytest.approx(radius * rate * 1500.0, rel=2e-6)


def test_an_unsteady_turn_has_no_radius():
    t = np.linspace(0.0, 100.0, 101)
    run = run_of(t, turn_rate=0.05 + 0.01 * np.sin(t), x_dot=np.ones(101))
    assert math.isnan(value(run, "turn_radius"))
    assert value(run, statistic("mean", "turn_rate")) == pytest.approx(0.05, rel=1e-2)


def test_the_radius_is_that_to_which_a_spiral_settles():
    run = simulate(load_preset("quad-bellows-spiral"))
    assert value(run, "turn_radius") == pytest.approx(run.final["turn_radius"], rel=1e-3)


def test_a_sine(yo_yo):
    """To (omega dt)^2 / 12 of what goes straight between samples, 3.3e-6."""
    found = [value(yo_yo, statistic(name)) for name in STATISTICS]
    root = math.sqrt(0.5)
    expected = [100.0, 0.0, 50.0, 0.0, 0.0, math.hypot(50.0, 50.0 * root), 50.0 * root, 100.0, 800.0, 2e5]
    assert found == pytest.approx(expected, rel=1e-5, abs=1e-9)
    assert value(yo_yo, {"kind": "time_beyond", "of": "z", "above": 75.0}) == pytest.approx(4000.0 / 3.0, rel=1e-5)
    assert value(yo_yo, statistic("percentile", percent=100.0 / 3.0)) == pytest.approx(25.0, rel=1e-5)
    assert value(yo_yo, "dives") == 4.0
    assert value(yo_yo, "glide_ratio") == pytest.approx(1.0)


def test_phases_of_a_sine(yo_yo):
    spans = {
        "dive": [({"number": 1}, 0.0, 1000.0), ({"number": -1}, 3000.0, 4000.0)],
        "descent": [({"number": 2}, 1000.0, 1500.0), ({}, 0.0, 3500.0)],
        "climb": [({"number": 3}, 2500.0, 3000.0), ({}, 500.0, 4000.0)],
        "last": [({"seconds": 30.5}, 3969.5, 4000.0), ({"seconds": 1e6}, 0.0, 4000.0)],
        "time": [({"begin": 0.25, "end": 7.5}, 0.25, 7.5), ({"begin": 100.0}, 100.0, 4000.0)],
        "while": [({"of": "z_dot", "below": 0.0}, 500.0, 4000.0)],
    }  # fmt: skip
    for kind, cases in spans.items():
        for fields, begin, end in cases:
            over = {"kind": kind, **fields}
            edges = [value(yo_yo, statistic(name, "x", over=over)) for name in ("first", "final")]
            assert edges == pytest.approx([0.2 * begin, 0.2 * end], rel=1e-9), over
    sinking = {"kind": "while", "of": "z_dot", "above": 0.0}
    second = {"kind": "both", "of": [sinking, {"kind": "dive", "number": 2}]}
    assert value(yo_yo, statistic("time_integral", "x", over=second)) == pytest.approx(0.2 * 500.0 * 1250.0, rel=1e-9)
    assert value(yo_yo, statistic("travel", over=sinking)) == pytest.approx(400.0)


@pytest.mark.parametrize("over", [
    {"kind": "dive", "number": 5}, {"kind": "climb", "number": -5}, {"kind": "time", "begin": 5000.0},
    {"kind": "while", "of": "z", "above": 101.0}, {"kind": "between_events", "begin": {"event": "bed"}},
    {"kind": "both", "of": [over_time(0.0, 5.0), over_time(5.0, 9.0)]},
])  # fmt: skip
def test_what_is_of_a_phase_that_is_not_there_is_missing(yo_yo, over):
    for metric in (statistic("mean"), {"kind": "time_beyond", "of": "z", "above": 1.0},
                   {"kind": "event_count", "event": "surface"}):  # fmt: skip
        assert math.isnan(value(yo_yo, metric | {"over": over}))


def test_events():
    events = (Event(3.0, "surface"), Event(4.0, "end_of_stroke", CELL), Event(5.0, "end_of_stroke", "Rear port cell"),
              Event(8.0, "surface"), Event(10.0, "surface"))  # fmt: skip
    run = run_of([0.0, 10.0], events=events, x=np.array([0.0, 20.0]))

    def at(event, **more):
        return value(run, {"kind": "event_time", "event": event, **more})

    assert at("surface") == 3.0 and at("surface", number=-1) == 10.0 and at("surface", number=2) == 8.0
    assert at("end_of_stroke", cell="Rear port cell") == 5.0
    assert math.isnan(at("surface", number=4)) and math.isnan(at("bed"))
    assert at("surface", over=over_time(3.5, 9.0)) == 8.0
    assert value(run, "end_stops") == 2.0 and value(run, "surfacings") == 3.0
    counted = [value(run, {"kind": "event_count", "event": "surface", "over": over_time(a, b)})
               for a, b in ((0.0, 3.0), (3.0, 8.0), (8.0, 10.0))]  # fmt: skip
    assert counted == [0.0, 1.0, 2.0]  # each once
    between = {"kind": "between_events", "begin": {"event": "surface"}, "end": {"event": "surface", "number": 2}}
    assert value(run, {"kind": "built_in", "of": "range", "over": between}) == pytest.approx(10.0)
    backward = {"kind": "between_events", "begin": {"event": "surface", "number": 2}, "end": {"event": "surface"}}
    assert math.isnan(value(run, statistic("mean", over=backward)))


def test_magnitudes_turn_where_the_output_crosses_zero():
    run = run_of([0.0, 2.0], theta=np.array([-1.0, 1.0]))
    assert value(run, statistic("mean", "theta")) == 0.0
    assert value(run, statistic("mean", "theta", absolute=True)) == 0.5
    assert value(run, statistic("minimum", "theta", absolute=True)) == 0.0
    beyond = {"kind": "time_beyond", "of": "theta", "above": 0.5, "absolute": True}
    assert value(run, beyond) == pytest.approx(1.0)


def test_what_is_not_a_number_counts_for_nothing():
    radius = np.array([math.nan, 2.0, 4.0, math.nan, 7.0, math.nan])
    run = run_of(np.arange(6.0), turn_radius=radius)
    found = {name: value(run, statistic(name, "turn_radius")) for name in ("mean", "maximum", "first", "final")}
    assert found == {"mean": 3.0, "maximum": 7.0, "first": 2.0, "final": 7.0}
    nowhere = run_of(np.arange(6.0), turn_radius=np.full(6, math.nan))
    assert all(math.isnan(value(nowhere, statistic(name, "turn_radius"))) for name in STATISTICS)


def test_cells():
    t = np.array([0.0, 1.0, 4.0])
    extension = np.zeros((3, 4))
    extension[:, 0] = [0.01, -0.02, 0.005]
    extension[:, 3] = [0.0, 0.0, 0.004]
    run = run_of(t, cells={"extension": extension})
    assert value(run, statistic("travel", "extension", cell=CELL)) == pytest.approx(0.055)
    assert value(run, "cell_travel") == pytest.approx(0.059)


def test_composition():
    run = straight(np.linspace(0.0, 100.0, 11))
    ratio = {"kind": "ratio", "of": ["way", "vertical_travel"]}
    assert value(run, ratio) == pytest.approx(value(run, "glide_ratio"))
    nested = {"kind": "sum", "of": [ratio, {"kind": "difference", "of": ["glide_ratio", ratio]}, ratio]}
    assert value(run, nested) == pytest.approx(2.0 * value(run, "glide_ratio"))
    assert value(run, {"kind": "product", "of": ["mean_power", "duration"]}) == pytest.approx(value(run, "energy"))
    assert math.isnan(value(run, {"kind": "ratio", "of": ["way", "surfacings"]}))  # by zero
    assert math.isnan(value(run, {"kind": "sum", "of": ["way", "turn_radius"]}))


LINES = st.integers(2, 12).flatmap(
    lambda n: st.tuples(
        st.lists(st.integers(1, 50), min_size=n, max_size=n).map(lambda steps: 0.1 * np.cumsum(steps)),
        st.lists(st.integers(-20, 20), min_size=n, max_size=n).map(lambda levels: 0.5 * np.array(levels)),
        st.lists(st.floats(0.0, 60.0), max_size=20),
    )
)
"""Times, values at them, and further times."""


@given(LINES, st.booleans(), st.integers(1, 99), st.integers(-21, 21))
def test_samples_on_the_lines_change_nothing(lines, absolute, percent, limit):
    times, levels, more = lines
    run = run_of(times, z=levels, x=np.cumsum(np.abs(levels)))
    again = refined(run, more)
    over = over_time(float(times[0]), float(times[-1]) + 1.0)
    limit = 0.5 * limit + 0.2  # no line lies on it
    requests = [statistic(name, absolute=absolute, over=over) for name in STATISTICS]
    requests += [{"kind": "time_beyond", "of": "z", "above": limit, "absolute": absolute, "over": over}]
    requests += [statistic("mean", "x", over={"kind": "while", "of": "z", "below": limit})]
    requests += [{"kind": "built_in", "of": name, "over": {"kind": "last", "seconds": 1.25}}
                 for name in ("range", "way", "mean_sink_rate", "maximum_depth", "vertical_travel")]  # fmt: skip
    metrics = metrics_for(run.design, [{"name": str(k), **request} for k, request in enumerate(requests)])
    assert evaluate(again, metrics) == pytest.approx(evaluate(run, metrics), rel=1e-9, abs=1e-9, nan_ok=True)
    # a percentile is where the time below is the share asked for; flat stretches make it jump
    level = value(again, statistic("percentile", percent=percent))
    below, above = (value(run, {"kind": "time_beyond", "of": "z", side: level + shift})
                    for side, shift in (("below", -1e-6), ("above", 1e-6)))  # fmt: skip
    length = value(run, "duration")
    assert below <= 0.01 * percent * length + 1e-9 and above <= (1.0 - 0.01 * percent) * length + 1e-9


@given(LINES, st.integers(-21, 21), st.floats(0.05, 0.95))
def test_parts_make_the_whole(lines, limit, share):
    times, levels, _ = lines
    run = run_of(times, z=levels)
    limit = 0.5 * limit + 0.2
    length, cut = value(run, "duration"), float(times[0] + share * (times[-1] - times[0]))
    sides = [value(run, {"kind": "time_beyond", "of": "z", side: limit}) for side in ("above", "below")]
    assert sum(sides) == pytest.approx(length, abs=1e-9)
    parts = [over_time(0.0, cut), over_time(cut, 1e3)]
    for name in ("time_integral", "travel"):
        found = [value(run, statistic(name, over=part)) for part in parts]
        assert sum(found) == pytest.approx(value(run, statistic(name)), abs=1e-9)
    mean, rms, deviation = (value(run, statistic(name)) for name in ("mean", "rms", "standard_deviation"))
    assert math.hypot(mean, deviation) == pytest.approx(rms, abs=1e-9)


@given(LINES, st.floats(0.0, 1e4))
def test_the_clock_does_not_matter(lines, shift):
    times, levels, _ = lines
    early, late = run_of(times, z=levels, x=levels), run_of(times + shift, z=levels, x=levels)
    begin, end = float(times[0]) + 0.03, float(times[-1]) - 0.03
    for request in (statistic("mean"), {"kind": "time_beyond", "of": "z", "above": 0.3},
                    {"kind": "built_in", "of": "way"}):  # fmt: skip
        a = value(early, request | {"over": over_time(begin, end)})
        b = value(late, request | {"over": over_time(begin + shift, end + shift)})
        assert a == pytest.approx(b, rel=1e-6, abs=1e-7)  # times of 1e4 s keep 1e-12 of them


def test_energy_is_that_of_the_bill(surfacing):
    bill = energy_bill(surfacing)
    assert value(surfacing, "energy") == pytest.approx(bill.whole.total, rel=1e-12)
    assert value(surfacing, "energy_per_km") == pytest.approx(bill.whole.per_km, rel=1e-12)
    assert value(surfacing, "way") == pytest.approx(bill.whole.distance, rel=1e-12)
    assert value(surfacing, "dives") == len(bill.dives) > 2
    for k, dive in enumerate(bill.dives, start=1):
        over = {"kind": "dive", "number": k}
        found = [value(surfacing, {"kind": "built_in", "of": name, "over": over})
                 for name in ("energy", "way", "maximum_depth", "duration", "dives")]  # fmt: skip
        assert found == pytest.approx([dive.total, dive.distance, dive.depth, dive.end - dive.begin, 1.0], rel=1e-9)


@pytest.mark.parametrize("preset_id", preset_ids())
def test_presets_have_their_metrics(preset_id):
    design = load_preset(preset_id)
    run = simulate(design)
    names = [name for name, built_in in BUILT_IN.items() if run.model in built_in.models]
    found = dict(zip(names, evaluate(run, metrics_for(design, names)), strict=True))
    assert found["range"] <= found["way"] * (1.0 + 1e-12)
    assert found["vertical_travel"] >= found["maximum_depth"] - found["minimum_depth"]
    assert found["duration"] == run.times[-1]
    assert found["energy_residual"] == run.relative_residual
    assert math.tan(found["mean_glide_angle"]) * found["glide_ratio"] == pytest.approx(1.0)
    whole = over_time(0.0, 1e9)
    again = [{"kind": "built_in", "of": name, "over": whole} for name in names if name not in WHOLE_ONLY]
    values = evaluate(run, metrics_for(design, again))
    assert values == pytest.approx([found[n] for n in names if n not in WHOLE_ONLY], nan_ok=True)
    missing = {name for name in DEFAULT_METRICS[run.model] if math.isnan(found[name])}
    assert missing <= {"turn_radius"}


def test_what_a_run_lacks_is_missing():
    """A case may be of another model, or of other cells, than the design that the metrics were checked against."""
    requests = [*BUILT_IN, statistic("travel", "extension", cell=CELL), statistic("mean", "phi"),
                {"kind": "ratio", "of": ["range", "energy"]}]  # fmt: skip
    metrics = metrics_for(SPATIAL, requests)
    found = dict(zip((m.name for m in metrics), evaluate(simulate(PLANAR), metrics), strict=True))
    lacking = {name for name, built_in in BUILT_IN.items() if "planar" not in built_in.models}
    assert {name for name, number in found.items() if math.isnan(number)} == lacking | {
        "bed_clearance", f"travel of extension of {CELL}", "mean of phi", "range per energy",
    }  # fmt: skip


def test_a_run_of_one_sample_has_what_needs_no_time():
    run = run_of([0.0], z=np.array([3.0]))
    names = [name for name in BUILT_IN]
    found = dict(zip(names, evaluate(run, metrics_for(SPATIAL, names)), strict=True))
    assert found["maximum_depth"] == 3.0 and found["range"] == 0.0 and found["duration"] == 0.0
    assert math.isnan(found["mean_sink_rate"]) and math.isnan(found["glide_ratio"])
    assert value(run, statistic("mean")) == value(run, statistic("rms")) == 3.0


def test_a_run_that_diverged_gives_numbers_or_none():
    t = np.linspace(0.0, 10.0, 11)
    wild = np.concatenate([np.linspace(1.0, 1e200, 8), [math.inf, math.nan, math.nan]])
    run = run_of(t, **{name: wild for name in ("x", "y", "z", "speed", "phi", "turn_rate", "kinetic_energy")})
    requests = [*BUILT_IN, statistic("rms"), statistic("mean", over={"kind": "dive", "number": 1})]
    assert not any(math.isinf(number) for number in evaluate(run, metrics_for(SPATIAL, requests)))


def test_metrics_travel_to_other_processes():
    metrics = metrics_for(SPATIAL, ["range", statistic("mean", over={"kind": "dive", "number": 1})])
    assert pickle.loads(pickle.dumps(metrics)) == metrics
