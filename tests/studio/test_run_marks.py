"""What is marked along a run's time: warnings' stretches, what lies outside the data, and a controller's phases."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from models.design import parse_design
from models.presets import load_preset
from models.run import Run
from models.run_warnings import run_warnings, spans
from models.simulate import simulate
from studio.run_marks import outside_spans, phases_of, warning_times


def preset_run(name: str, duration: float) -> Run:
    document = load_preset(name).model_dump(mode="json")
    document["mission"]["duration"] = duration
    return simulate(parse_design(document))


@pytest.fixture(scope="module")
def dive() -> Run:
    return simulate(load_preset("canete-dual-bellows"))


@pytest.fixture(scope="module")
def way() -> Run:
    return preset_run("quad-bellows-waypoints", 3000.0)


def test_spans_cover_just_the_marked_samples(dive):
    flags = np.zeros(len(dive.times), dtype=bool)
    flags[0] = flags[5] = True
    flags[8:11] = flags[-2:] = True
    found = spans(dive, flags)
    assert len(found) == 4
    assert found[0][0] == dive.times[0] and found[-1][1] == dive.times[-1]
    inside = [any(a <= t <= b for a, b in found) for t in dive.times]
    assert inside == flags.tolist()


def test_no_flag_is_no_span_and_all_flags_are_the_whole_run(dive):
    count = len(dive.times)
    assert spans(dive, np.zeros(count, dtype=bool)) == ()
    assert spans(dive, np.ones(count, dtype=bool)) == ((dive.times[0], dive.times[-1]),)


def test_warnings_from_samples_have_their_times_and_say_the_same_as_before(dive):
    (warning,) = run_warnings(dive)
    slow = (dive.values["speed"] > 0.0) & (dive.values["speed"] < warning.limit)
    inside = [any(a <= t <= b for a, b in warning_times(warning)) for t in dive.times]
    assert np.mean(np.array(inside) == slow) > 0.99  # borders are written to a tenth of a millisecond
    assert set(warning.as_dict()) == {"pointer", "message", "limit", "hint"}
    assert outside_spans(dive) == [
        {"what": warning.message, "pointer": warning.pointer, "spans": warning_times(warning)}
    ]


def test_phases_and_legs_are_bands_that_follow_each_other(way):
    bands = phases_of(way)
    vertical = [band for band in bands if band["track"] == "vertical"]
    assert [band["name"] for band in vertical][:2] == ["Dive", "Climb"]
    assert vertical[0]["from"] == 0.0 and vertical[-1]["to"] == pytest.approx(way.times[-1], abs=1e-3)
    for before, after in pairwise(vertical):
        assert before["to"] == after["from"] and before["tone"] != after["tone"]
    turned = [event.time for event in way.events if event.kind == "climb"]
    interval = float(np.diff(way.times).max())
    assert vertical[1]["from"] == pytest.approx(turned[0], abs=2.0 * interval)
    legs = [band for band in bands if band["track"] == "lateral"]
    assert legs[0]["name"].startswith("Leg 1 of ")


def test_a_station_is_spiralled_on_and_headed_back_to():
    names = {
        band["name"] for band in phases_of(preset_run("quad-bellows-station", 4000.0)) if band["track"] == "lateral"
    }
    assert names <= {"Spirals", "Heads back"} and "Spirals" in names


def test_a_run_without_guidance_has_no_phases(dive):
    assert phases_of(dive) == []
