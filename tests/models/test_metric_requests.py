"""The grammar of metrics: what is written comes back, what a design cannot have is refused by its place."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter

from models.built_in_metrics import BUILT_IN
from models.metric_requests import MetricRequest
from models.metric_units import product_unit, ratio_unit
from models.metrics import DEFAULT_METRICS, MOST_METRICS, metrics_for
from models.presets import load_preset
from models.problems import DesignError
from tests.models.metric_support import CELL, PLANAR, SPATIAL

REQUESTS = TypeAdapter(MetricRequest)
SCHEMA = REQUESTS.json_schema()
OUTPUTS = st.sampled_from(["z", "speed", "theta", "phi", "energy_residual"])
LIMITS = st.fixed_dictionaries({"of": OUTPUTS, "absolute": st.booleans()}).flatmap(
    lambda fields: st.tuples(st.sampled_from(["above", "below"]), st.floats(-100.0, 100.0)).map(
        lambda side: fields | dict([side])
    )
)
NUMBERS = st.sampled_from([-2, -1, 1, 2, 7])
EVENTS = st.fixed_dictionaries({"event": st.sampled_from(["surface", "bed", "end_of_stroke"]), "number": NUMBERS})


def kind(name, **fields):
    return st.fixed_dictionaries({"kind": st.just(name), **fields})


def limited(name, **fields):
    return st.tuples(LIMITS, kind(name, **fields)).map(lambda parts: parts[0] | parts[1])


PHASES = st.recursive(
    st.one_of(
        kind("whole"), kind("time", begin=st.floats(0.0, 10.0), end=st.floats(10.5, 20.0)),
        kind("last", seconds=st.floats(0.5, 100.0)), kind("dive", number=NUMBERS), kind("descent", number=NUMBERS),
        kind("climb"), limited("while"), kind("between_events", begin=EVENTS, end=st.none() | EVENTS),
    ),
    lambda inner: kind("both", of=st.lists(inner, min_size=2, max_size=3)), max_leaves=4,
)  # fmt: skip
METRICS = st.recursive(
    st.one_of(
        st.sampled_from(list(BUILT_IN)),
        kind("statistic", of=OUTPUTS, over=PHASES, statistic=st.sampled_from(["mean", "rms", "final"])),
        kind("statistic", of=OUTPUTS, statistic=st.just("percentile"), percent=st.floats(0.0, 100.0)),
        limited("time_beyond", over=PHASES), kind("event_count", event=st.just("surface"), over=PHASES),
        kind("built_in", of=st.sampled_from(["way", "glide_ratio"]), over=kind("dive", number=NUMBERS)),
        st.tuples(EVENTS, kind("event_time", over=PHASES)).map(lambda parts: parts[0] | parts[1]),
    ),
    lambda inner: kind("ratio", of=st.lists(inner, min_size=2, max_size=2))
    | kind("product", of=st.lists(inner, min_size=2, max_size=3)),
    max_leaves=4,
)  # fmt: skip


@given(METRICS)
def test_what_is_written_comes_back(document):
    request = REQUESTS.validate_python(document)
    written = json.loads(REQUESTS.dump_json(request))
    assert REQUESTS.validate_python(written) == request
    metric, again = metrics_for(SPATIAL, [document])[0], metrics_for(SPATIAL, [request])[0]
    assert metric == again and metric.request == request
    assert metric.name and metric.unit and metric.meaning and "/" not in metric.name


def test_every_model_and_field_has_a_sentence():
    for name, model in SCHEMA["$defs"].items():
        assert model["description"].endswith("."), name
        for field, schema in model["properties"].items():
            assert schema["description"].endswith("."), f"{name}.{field}"
            types = {option.get("type") for option in [schema, *schema.get("anyOf", [])]}
            assert not types & {"number", "integer"} or (schema["unit"] and schema["symbol"]), f"{name}.{field}"


@pytest.mark.parametrize("design", [SPATIAL, PLANAR])
def test_without_a_request_there_are_the_usual_ones(design):
    metrics = metrics_for(design)
    names = DEFAULT_METRICS[design.mission.solver.model]
    assert tuple(metric.name for metric in metrics) == names
    assert [(m.unit, m.meaning) for m in metrics] == [(BUILT_IN[n].unit, BUILT_IN[n].meaning) for n in names]


def test_names_and_units():
    requests = [
        ({"kind": "statistic", "of": "z", "over": {"kind": "dive", "number": 2}}, "maximum of z in dive 2", "m"),
        ({"name": "A", "kind": "statistic", "of": "theta", "statistic": "time_integral"}, "A", "rad s"),
        ({"kind": "time_beyond", "of": "phi", "below": -0.5, "absolute": True}, "time of |phi| below -0.5", "s"),
        ({"kind": "statistic", "of": "extension", "cell": CELL, "statistic": "rms"},
         f"root mean square of extension of {CELL}", "m"),
        ({"kind": "ratio", "of": ["energy", "range"]}, "energy per range", "J/m"),
        ({"kind": "product", "of": ["mean_power", {"kind": "ratio", "of": ["duration", "range"]}]},
         "mean_power times (duration per range)", "W s/m"),
        ({"kind": "built_in", "of": "way", "over": {"kind": "last", "seconds": 60}}, "way over the last 60 s", "m"),
        ({"kind": "event_time", "event": "bed", "number": -1}, "time of bed -1", "s"),
        ({"kind": "event_count", "event": "surface"}, "number of surface", "1"),
    ]  # fmt: skip
    metrics = metrics_for(SPATIAL, [request for request, _, _ in requests])
    assert [(metric.name, metric.unit) for metric in metrics] == [(name, unit) for _, name, unit in requests]
    rolling = metrics_for(
        load_preset("movable-mass-twin"),
        [{"kind": "statistic", "of": "extension", "cell": "Lower ballast"}],
    )
    assert rolling[0].unit == "rad"


@pytest.mark.parametrize(("unit", "expected"), [
    (product_unit("N m", "s"), "N m s"), (product_unit("kg/m3", "m3"), "kg"), (product_unit("m", "m"), "m2"),
    (product_unit("1", "1"), "1"), (ratio_unit("m/s", "s"), "m/s2"), (ratio_unit("1", "s"), "1/s"),
    (ratio_unit("rad", "rad"), "1"), (ratio_unit("J", "N m"), "J/N/m"), (ratio_unit("J/N/m", "J"), "1/N/m"),
])  # fmt: skip
def test_units_combine(unit, expected):
    assert unit == expected


@given(st.lists(st.sampled_from(["m", "s", "kg m2", "J/km", "m/s2", "1", "N m"]), min_size=1, max_size=4))
def test_a_product_over_its_factors_is_no_unit(units):
    product = product_unit(*units)
    assert ratio_unit(product, product_unit(*reversed(units))) == "1"
    assert ratio_unit(product_unit(product, "Pa"), product) == "Pa"


def nested(depth):
    return "range" if depth == 0 else {"kind": "sum", "of": ["range", nested(depth - 1)]}


STATISTIC = {"kind": "statistic", "of": "z"}
REFUSED = [
    ("rnage", "", "there is no metric 'rnage'", "range"),
    ("depth", "", "no metric 'depth'", "maximum_depth"),
    (3, "", "valid string, not 3", ""),
    ({"kind": "best"}, "/kind", "no kind 'best'", "use one of statistic, time_beyond, built_in"),
    ({"of": "z"}, "/kind", "the kind is missing", "statistic"),
    (STATISTIC | {"statistic": {}}, "/statistic", "not an object of 0", ""),
    (STATISTIC | {"statistic": "median"}, "/statistic", "'percentile', not 'median'", ""),
    (STATISTIC | {"of": "deep"}, "/of", "no output 'deep'", ""),
    (STATISTIC | {"of": "depth"}, "/of", "no output 'depth'", "z"),
    (STATISTIC | {"of": "phase"}, "/of", "with a controller", "add one"),
    (STATISTIC | {"cell": CELL}, "/cell", "z is not of cells", "leave the cell out"),
    (STATISTIC | {"of": "extension"}, "/cell", "none is named", CELL),
    (STATISTIC | {"of": "extension", "cell": "Tail"}, "/cell", "no cell 'Tail'", CELL),
    (STATISTIC | {"statistic": "percentile"}, "", "needs percent", ""),
    (STATISTIC | {"percent": 5}, "", "belongs to a percentile", ""),
    (STATISTIC | {"over": {"kind": "dive", "number": 0}}, "/over/number", "there is no 0", ""),
    (STATISTIC | {"over": {"kind": "time", "begin": 5, "end": 5}}, "/over", "must be later", ""),
    (STATISTIC | {"over": {"kind": "while", "of": "z"}}, "/over", "give one limit", ""),
    (STATISTIC | {"over": {"kind": "while", "of": "zz", "above": 1}}, "/over/of", "no output 'zz'", ""),
    (STATISTIC | {"over": {"kind": "between_events", "end": {"event": "dive"}}}, "/over/end/event", "controller", ""),
    ({"kind": "event_count", "event": "surface", "cell": CELL}, "/cell", "to the glider", ""),
    ({"kind": "event_time", "event": "waypoint"}, "/event", "told by a controller", "phase"),
    ({"kind": "sum", "of": ["range", "duration"]}, "/of/1", "a sum of m and s", ""),
    ({"kind": "ratio", "of": ["range"]}, "/of", "at least 2 items", ""),
    ({"kind": "ratio", "of": ["range", "way", "way"]}, "", "two metrics, not of 3", ""),
    ({"kind": "ratio", "of": ["range", {"kind": "ratio", "of": ["way", "wya"]}]}, "/of/1/of/1", "'wya'", "way"),
    ({"kind": "built_in", "of": "way", "over": {"kind": "climb"}}, "/over", "may have several", "number"),
    ({"kind": "built_in", "of": "energy_residual", "over": {"kind": "dive", "number": 1}}, "/over", "whole runs", ""),
    (nested(5), "", "nested 5 deep, 4 at most", ""),
]  # fmt: skip


@pytest.mark.parametrize(("request_", "pointer", "message", "hint"), REFUSED)
def test_what_cannot_be_is_refused_by_its_place(request_, pointer, message, hint):
    with pytest.raises(DesignError) as refused:
        metrics_for(SPATIAL, ["range", request_], pointer="/asked")
    (problem,) = refused.value.problems
    assert problem.pointer == f"/asked/1{pointer}"
    assert message in problem.message and hint in (problem.hint or "")


@pytest.mark.parametrize(("request_", "pointer"), [
    ("energy", ""), ({"kind": "statistic", "of": "phi"}, "/of"),
    ({"kind": "statistic", "of": "energy", "cell": "Movable mass"}, "/of"),
])  # fmt: skip
def test_a_planar_design_has_no_spatial_metrics(request_, pointer):
    with pytest.raises(DesignError) as refused:
        metrics_for(PLANAR, [request_])
    (problem,) = refused.value.problems
    assert problem.pointer == f"/metrics/0{pointer}"
    assert "spatial runs, this design is planar" in problem.message and "/mission/solver/model" in problem.hint


def test_all_that_is_wrong_is_told_at_once():
    with pytest.raises(DesignError) as refused:
        metrics_for(SPATIAL, ["a", "range", {"kind": "statistic", "of": "b"}])
    assert [problem.pointer for problem in refused.value.problems] == ["/metrics/0", "/metrics/2/of"]


@pytest.mark.parametrize("second", ["range", {"name": "range", "kind": "statistic", "of": "z"}])
def test_names_are_unique(second):
    with pytest.raises(DesignError, match="2 metrics are named 'range'") as refused:
        metrics_for(SPATIAL, ["range", "way", second])
    assert [problem.pointer for problem in refused.value.problems] == ["/metrics/2"]


@pytest.mark.parametrize("count", [0, MOST_METRICS + 1])
def test_some_are_asked_for_but_not_too_many(count):
    with pytest.raises(DesignError, match=f"{count} metrics are asked for, 1 to {MOST_METRICS} can be"):
        metrics_for(SPATIAL, ["range"] * count)
