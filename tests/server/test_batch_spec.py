"""The batch document and the plan made of it: what is refused, with pointers into the document, and what is planned."""

import copy
import itertools
import json
import math
import tracemalloc

import jsonschema_rs
import pytest

from models.design import parse_design
from models.presets import load_preset
from models.problems import DesignError
from models.variation import Target, Varied
from server.jobs.plan import make_plan
from server.jobs.spec import batch_schema, checksum, parse_spec

DESIGN = load_preset("canete-dual-bellows")
FRONT = "/vehicle/components/1/position/0"
REAR = "/vehicle/components/2/position/0"
DENSITY = "/mission/environment/water/density"
PLEATS = "/vehicle/components/1/pleats"


def document(kind="simulate", **fields):
    head = {"format": "glider-batch", "version": 1, "kind": kind, "design": DESIGN.model_dump(mode="json")}
    return head | fields


def factorial(*parameters):
    return document("sweep", method={"kind": "full_factorial", "parameters": list(parameters)})


def ranged(pointer=FRONT, low=0.05, high=0.15, **fields):
    return {"pointer": pointer, "low": low, "high": high, **fields}


def drawn(pointer=FRONT, **distribution):
    return {"pointer": pointer, "distribution": distribution or {"kind": "normal", "mean": 0.1, "sd": 0.01}}


def monte_carlo(*parameters, count=10, **fields):
    return document("monte_carlo", parameters=list(parameters), count=count, **fields)


def listed(pointers, rows):
    return document("sweep", method={"kind": "cases", "parameters": [{"pointer": p} for p in pointers], "rows": rows})


EXAMPLES = {
    "simulate": document(),
    "full_factorial": factorial(ranged(count=3), {"pointer": DENSITY, "values": [1000.0, 1025.0]}),
    "latin_hypercube": document(
        "sweep", method={"kind": "latin_hypercube", "parameters": [ranged(), ranged(DENSITY, 990, 1030)], "count": 7}
    ),
    "sobol": document("sweep", method={"kind": "sobol", "parameters": [ranged()], "count": 8}),
    "cases": listed([FRONT, "/mission/solver/method"], [[0.1, "rk4"], [0.2, "adaptive"]]),
    "monte_carlo": monte_carlo(
        drawn(), drawn(DENSITY, kind="uniform", low=1000.0, high=1025.0),
        correlations=[{"between": ["Front bellows position x", "water density"], "value": 0.4}],
        stop={"metric": "range", "width": 0.1},
    ),
    "sensitivity_sobol": document("sensitivity", method={"kind": "sobol", "base": 16}, parameters=[ranged()]),
    "sensitivity_morris": document("sensitivity", method={"kind": "morris", "trajectories": 4}, parameters=[ranged()]),
}  # fmt: skip
COUNTS = {"simulate": 1, "full_factorial": 6, "latin_hypercube": 7, "sobol": 8, "cases": 2, "monte_carlo": 10,
          "sensitivity_sobol": 48, "sensitivity_morris": 8}  # fmt: skip


def plan_of(given, max_cases=10**6):
    spec = parse_spec(given)
    return make_plan(spec, spec.design, max_cases=max_cases)


def problems_of(given, **options):
    with pytest.raises(DesignError) as caught:
        plan_of(given, **options)
    return [(problem.pointer, str(problem)) for problem in caught.value.problems]


def refused(given, pointer, *words, **options):
    ((found, message),) = problems_of(given, **options)
    assert found == pointer
    for word in words:
        assert word in message


def changed(example, path, value):
    """An example with one field changed."""
    made = copy.deepcopy(EXAMPLES[example])
    node = made
    for token in path[:-1]:
        node = node[token]
    node[path[-1]] = value
    return made


@pytest.mark.parametrize("name", list(EXAMPLES))
def test_an_example_is_planned_and_its_cases_can_run(name):
    plan = plan_of(EXAMPLES[name])
    assert plan.count == COUNTS[name]
    rows = plan.rows(0, plan.count)
    assert len(rows) == plan.count and all(len(row) == len(plan.parameters) == len(plan.targets) for row in rows)
    varied = Varied(plan.design, plan.targets)
    for row in rows[:8]:
        made = varied.design(row).model_dump(mode="json")
        for value, info in zip(row, plan.parameters, strict=True):
            node = made
            for token in info.pointer[1:].split("/"):
                node = node[int(token)] if isinstance(node, list) else node[token]
            assert node == value
    assert [row for n in range(plan.count) for row in plan.rows(n, n + 1)] == rows


@pytest.mark.parametrize("name", list(EXAMPLES))
def test_a_document_comes_back_from_its_file(name):
    spec = parse_spec(EXAMPLES[name])
    again = parse_spec(json.loads(spec.to_json()))
    assert again == spec
    assert checksum(again, again.design, "1") == checksum(spec, spec.design, "1")


@pytest.mark.parametrize("name", list(EXAMPLES))
def test_examples_agree_with_the_schema(name):
    schema = batch_schema()
    jsonschema_rs.meta.validate(schema)
    validator = jsonschema_rs.validator_for(schema)
    assert [error.message for error in validator.iter_errors(EXAMPLES[name])] == []
    assert not validator.is_valid(EXAMPLES[name] | {"sead": 1})


def test_every_field_of_the_schema_has_a_sentence_and_every_number_a_unit():
    schema = batch_schema()
    own = {name: part for name, part in schema["$defs"].items() if name in {
        "Simulate", "Sweep", "MonteCarlo", "Sensitivity", "FullFactorial", "LatinHypercube", "SobolPoints", "Cases",
        "SobolIndices", "MorrisEffects", "Levels", "Range", "Drawn", "Parameter", "Follower", "Correlation", "Stop",
        "Normal", "Uniform", "TruncatedNormal", "CaseSeed"}}  # fmt: skip
    assert len(own) == 21
    for name, part in own.items():
        assert part["description"]
        for field, told in part["properties"].items():
            assert told.get("description", ".").endswith((".", "...")), f"{name}.{field}"
            if told.get("type") == "number":
                assert told.get("unit"), f"{name}.{field}"


def test_names_units_and_pointers_of_parameters():
    plan = plan_of(factorial(ranged(count=2), {"pointer": DENSITY, "values": [1000.0], "name": "rho"},
                             {"pointer": "/mission/solver/method", "values": ["rk4"]}))  # fmt: skip
    told = [(p.name, p.unit, p.pointer, p.numeric) for p in plan.parameters]
    assert told == [
        ("Front bellows position x", "m", FRONT, True), ("rho", "kg/m3", DENSITY, True),
        ("solver method", "", "/mission/solver/method", False),
    ]  # fmt: skip
    assert [m.name for m in plan.metrics][:2] == ["range", "maximum_depth"]


def test_a_billion_cases_are_planned_without_memory():
    axis = ranged(count=1000)
    given = factorial(axis, ranged(REAR, -0.15, -0.05, count=1000), ranged(DENSITY, 1000.0, 1030.0, count=1000))
    tracemalloc.start()
    plan = plan_of(given, max_cases=10**9)
    rows = plan.rows(10**9 - 2, 10**9)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert plan.count == 10**9 and rows[-1] == (0.15, -0.05, 1030.0)
    assert peak < 8e6


def test_a_billion_random_cases_too():
    plan = plan_of(monte_carlo(drawn(), count=10**9), max_cases=10**9)
    assert plan.rows(10**9 - 3, 10**9)[1:] == plan.rows(10**9 - 2, 10**9)


def test_followers_follow():
    parameter = drawn() | {"also": [{"pointer": REAR, "factor": -1.0}, {"pointer": DENSITY, "factor": 0.0,
                                                                        "offset": 1020.0}]}  # fmt: skip
    plan = plan_of(monte_carlo(parameter))
    assert plan.targets == ((Target(FRONT), Target(REAR, -1.0), Target(DENSITY, 0.0, 1020.0)),)
    made = Varied(plan.design, plan.targets).design(plan.rows(4, 5)[0])
    parts = made.vehicle.components
    assert parts[1].position[0] == -parts[2].position[0] == plan.rows(4, 5)[0][0]
    assert made.mission.environment.water.density == 1020.0


def test_whole_numbers_are_rounded_where_they_are_drawn_and_levels_listed_are_not():
    plan = plan_of(document("sweep", method={
        "kind": "latin_hypercube", "parameters": [ranged(PLEATS, 2.6, 9.4)], "count": 50}))  # fmt: skip
    values = [row[0] for row in plan.rows(0, 50)]
    assert all(type(value) is int for value in values) and set(values) == set(range(3, 10))
    assert [row[0] for row in plan_of(factorial(ranged(PLEATS, 2, 4, count=5))).rows(0, 5)] == [2, 2, 3, 4, 4]
    refused(factorial({"pointer": PLEATS, "values": [3, 3.5]}), "/method/parameters/0/values/1",
            "3.5 for 'Front bellows pleats': /vehicle/components/1/pleats: a whole number is wanted")  # fmt: skip


def test_a_seed_for_every_case():
    design = load_preset("quad-bellows-heading").model_dump(mode="json")
    seed = "/mission/control/controller/noise/seed"
    plan = plan_of(monte_carlo({"pointer": seed, "distribution": {"kind": "case_seed"}}) | {"design": design})
    values = [row[0] for row in plan.rows(0, 10)]
    assert all(type(value) is int and 0 <= value < 2**53 for value in values) and len(set(values)) == 10
    made = Varied(plan.design, plan.targets).design((values[3],))
    assert made.mission.control.controller.noise.seed == values[3]
    refused(monte_carlo({"pointer": DENSITY, "distribution": {"kind": "case_seed"}}), "/parameters/0/pointer",
            "is no whole number, which a seed is")  # fmt: skip
    told = problems_of(monte_carlo({"pointer": PLEATS, "distribution": {"kind": "case_seed"}}))
    assert {pointer for pointer, _ in told} == {"/parameters/0/distribution/kind"}


@pytest.mark.parametrize(
    ("given", "pointer", "words"),
    [
        ([], "", "a batch document is a JSON object, not list"),
        ({}, "/format", "this is not a batch document: format is null"),
        (document() | {"format": "glider-design"}, "/format", "'glider-design'"),
        (document() | {"version": 2}, "/version", "version 2; this program reads versions up to 1 (open it with a n"),
        (document() | {"version": True}, "/version", "a number, not true or false"),
        (document("batch"), "/kind", "there is no kind 'batch'"),
        (document() | {"sead": 3}, "/sead", "there is no field 'sead' here (did you mean seed?)"),
        (document() | {"design_id": "x"}, "", "give exactly one of design and design_id: both are given"),
        (document() | {"design": None}, "", "give exactly one of design and design_id: neither is given"),
        (document() | {"revision": 2}, "", "revision belongs to design_id, which is not given: leave it out"),
        (document() | {"seed": -1}, "/seed", "a number of at least 0 is wanted, not -1"),
        (document() | {"seed": 2**53}, "/seed", "from 2^53 on"),
        (document() | {"trajectories": "some"}, "/trajectories", "'none' or 'all' is wanted, not 'some'"),
        (document() | {"trajectories": [0, -1]}, "/trajectories/1", "a number of at least 0 is wanted, not -1"),
        (document() | {"trajectories": [0, 1]}, "/trajectories/1", "there is no case 1 of 1 (cases count from 0)"),
        (document() | {"metrics": ["rnge"]}, "/metrics/0", "rnge"),
        (document() | {"metrics": []}, "/metrics", "0 metrics are asked for"),
        (factorial(ranged()), "/method/parameters/0", "give either values, or low, high and count; given are low, h"),
        (factorial(ranged(values=[0.1], count=2)), "/method/parameters/0", "given are values, low, high, count"),
        (factorial({"pointer": FRONT}), "/method/parameters/0", "given are none"),
        (factorial(ranged(low=0.2, high=0.1, count=2)), "/method/parameters/0", "low 0.2 does not lie below high 0.1"),
        (factorial(ranged(count=1)), "/method/parameters/0/count", "a number of at least 2 is wanted, not 1"),
        (factorial(), "/method/parameters", "there must be at least 1, not 0"),
        (factorial(ranged(pointer="/vehicle/wing", count=2)), "/method/parameters/0/pointer",
         "/vehicle/wing: there is no field 'wing' (those are: components"),
        (factorial(ranged(pointer="/version", count=2)), "/method/parameters/0/pointer", "and cannot vary"),
        (factorial(ranged(pointer="/mission/solver/method", count=2)), "/method/parameters/0/pointer",
         "/mission/solver/method ('solver method') is not a number (list its values in a sweep instead)"),
        (factorial(ranged(count=2, also=[{"pointer": "/mission/x"}])), "/method/parameters/0/also/0/pointer",
         "there is no field 'x'"),
        (factorial({"pointer": "/mission/solver/method", "values": ["rk4"],
                    "also": [{"pointer": "/mission/solver/model", "factor": 2.0}]}),
         "/method/parameters/0/also/0/pointer", "is not a number (leave factor and offset out)"),
        (factorial(ranged(count=2, high=1e5)), "/method/parameters/0/high",
         "100000.0 for 'Front bellows position x': /vehicle/components/1/position/0: a number of at most 10000"),
        (factorial(ranged(count=2, also=[{"pointer": DENSITY, "factor": -1.0, "offset": 0.1}])),
         "/method/parameters/0/high", "0.15 for 'Front bellows position x': /mission/environment/water/density:"),
        (factorial({"pointer": FRONT, "values": [0.1, 0.2, "x", 0.1]}), "/method/parameters/0/values/2",
         "'x' for 'Front bellows position x'"),
        (factorial({"pointer": "/vehicle/components/1/axis", "values": [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]}),
         "/method/parameters/0/values/1", "an array of 3 for 'Front bellows axis': /vehicle/components/1: axis has"),
        (factorial(ranged(count=2), ranged(count=3, name="again")), "/method/parameters/1/pointer",
         "sets the same field as /vehicle/components/1/position/0 (let one parameter set it)"),
        (factorial(ranged(count=2, name="a"), ranged(DENSITY, 1e3, 1.1e3, count=3, name="a")),
         "/method/parameters/1/name", "'a' is the name of /method/parameters/0 too"),
        (factorial(ranged(count=2, name="case")), "/method/parameters/0/name", "'case' is a column of every table"),
        (factorial(ranged(count=2, name="range")), "/metrics", "'range' names a metric and a parameter"),
        (factorial(ranged(count=2000), ranged(DENSITY, 1000.0, 1010.0, count=501)), "/method/parameters",
         "1002000 cases exceed the limit of 1000000"),
        (listed([FRONT, DENSITY], [[0.1, 1e3], [0.1]]), "/method/rows/1/1", "row 2 has 1 values for 2 parameters"),
        (listed([FRONT], [[0.1], [0.2], [0.1, 1e3]]), "/method/rows/2/1", "row 3 has 2 values for 1 parameters"),
        (listed([FRONT, DENSITY], [[0.1, 1000.0], [0.1, -5.0]]), "/method/rows/1/1", "-5.0 for 'water density'"),
        (listed([FRONT], [[2**53]]), "/method/rows/0/0", "from 2^53 on"),
        (listed([FRONT], [[math.nan]]), "/method/rows/0/0", "nan is not a finite number"),
        (changed("sobol", ("method", "count"), 1000), "/method/count",
         "count 1000 is no power of 2, which Sobol points need: use 512 or 1024"),
        (changed("latin_hypercube", ("method", "count"), 2_000_000), "/method",
         "2000000 cases exceed the limit of 1000000"),
        (changed("sensitivity_sobol", ("method", "base"), 20), "/method/base", "use 16 or 32"),
        (changed("sensitivity_morris", ("method", "levels"), 3), "/method/levels", "multiple of 2"),
        (monte_carlo(drawn(kind="normal", mean=0.1, sd=0.0)), "/parameters/0/distribution/sd", "a number above 0 is w"),
        (monte_carlo(drawn(kind="weibull")), "/parameters/0/distribution/kind", "there is no kind 'weibull'"),
        (monte_carlo(drawn(kind="uniform", low=2.0, high=2.0)), "/parameters/0/distribution", "low 2 does not lie bel"),
        (monte_carlo(drawn(kind="truncated_normal", mean=0.0, sd=0.1, low=1.0, high=2.0)), "/parameters/0/distribution",
         "[1, 2] lies 10 standard deviations from the mean 0: bring it within 8"),
        (monte_carlo(drawn(DENSITY, kind="normal", mean=-1.0, sd=0.1)), "/parameters/0/distribution/mean", "-1.0 for"),
        (monte_carlo(drawn(DENSITY, kind="uniform", low=-1.0, high=9.0)), "/parameters/0/distribution/low", "-1.0 for"),
        (monte_carlo(drawn(), count=2_000_000), "/count", "2000000 cases exceed the limit of 1000000 (take fewer"),
        (monte_carlo(drawn(), stop={"metric": "rnge", "width": 1.0}), "/stop/metric",
         "no metric is named 'rnge' (those are: range, maximum_depth"),
        (monte_carlo(drawn(), stop={"metric": "range", "width": 0.0}), "/stop/width", "a number above 0 is w"),
        (monte_carlo(drawn(), stop={"metric": "range", "width": 1.0, "statistic": "mode"}), "/stop/statistic", "'p95'"),
        (monte_carlo(drawn(), correlations=[{"between": ["Front bellows position x", "b"], "value": 0.1}]),
         "/correlations/0/between", "no parameter is named 'b' (those are: Front bellows position x)"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told_where_it_stands(given, pointer, words):
    refused(given, pointer, words)


def test_all_that_is_wrong_is_told_at_once():
    given = document("monte_carlo", parameters=[drawn() | {"pointer": 3}], count=0, sead=2)
    given["design"]["vehicle"]["hotel_power"] = -1.0
    pointers = [pointer for pointer, _ in problems_of(given)]
    assert pointers == ["/design/vehicle/hotel_power", "/parameters/0/pointer", "/count", "/sead"]


def test_problems_of_several_parameters_are_told_at_once():
    given = factorial(ranged(pointer="/vehicle/x", count=2), {"pointer": "/mission/y", "values": [1]})
    assert [p for p, _ in problems_of(given)] == ["/method/parameters/0/pointer", "/method/parameters/1/pointer"]


def test_a_wrong_pointer_brings_no_wrong_correlation():
    given = monte_carlo(drawn("/vehicle/x") | {"name": "a"}, drawn() | {"name": "b"},
                        correlations=[{"between": ["a", "b"], "value": 0.5}])  # fmt: skip
    refused(given, "/parameters/0/pointer", "there is no field 'x'")


def test_of_many_wrong_values_some_are_told():
    given = factorial({"pointer": FRONT, "values": [f"x{k}" for k in range(500)]})
    assert [p for p, _ in problems_of(given)] == [f"/method/parameters/0/values/{k}" for k in range(20)]


def test_of_very_many_values_the_last_and_the_extremes_are_checked():
    values = [0.1 + 1e-6 * k for k in range(20_000)]
    wrong = {5: 1e6, 15_000: 1e7, 15_001: 1e8, 19_999: -1e6}
    given = factorial({"pointer": FRONT, "values": [wrong.get(k, value) for k, value in enumerate(values)]})
    told = [int(p.rsplit("/", 1)[1]) for p, _ in problems_of(given)]
    assert told == [5, 19_999, 15_001]


def test_a_rule_over_several_fields_is_left_to_the_cases():
    """Both stops of a cell vary: [0.5, 0.01] is an empty range, [0.01, 0.5] is not."""
    stops = [f"/vehicle/components/1/extension_range/{k}" for k in (0, 1)]
    low, high = DESIGN.vehicle.components[1].extension_range
    plan = plan_of(factorial({"pointer": stops[0], "values": [low, 2.0 * high]},
                             {"pointer": stops[1], "values": [high, 3.0 * high]}))  # fmt: skip
    varied = Varied(plan.design, plan.targets)
    assert varied.design(plan.rows(0, 1)[0])
    with pytest.raises(DesignError, match="is empty"):
        varied.design(plan.rows(2, 3)[0])
    refused(factorial({"pointer": stops[0], "values": [2.0 * high]}), "/method/parameters/0/values/0", "is empty")


@pytest.mark.parametrize("value", [0.9, -0.9])
def test_correlations_that_no_numbers_have(value):
    """Of three parameters, with r, r and -r: the smallest eigenvalue is 1 - 2 r; times 1 / (2 r) of it would do."""
    names = ["a", "b", "c"]
    parameters = [drawn(p, kind="uniform", low=1.0, high=2.0) | {"name": n}
                  for p, n in zip((FRONT, REAR, DENSITY), names, strict=True)]  # fmt: skip
    pairs = list(itertools.combinations(names, 2))
    signs = (1, 1, -1) if value > 0.0 else (1, 1, 1)
    given = monte_carlo(*parameters, correlations=[
        {"between": list(pair), "value": sign * value} for pair, sign in zip(pairs, signs, strict=True)])  # fmt: skip
    refused(given, "/correlations", "the smallest eigenvalue of their matrix is -0.8",
            "(bring them together: times 0.555 all of them would do)")  # fmt: skip
    for item in given["correlations"]:
        item["value"] *= 0.555
    assert plan_of(given).count == 10


@pytest.mark.parametrize(
    ("pairs", "words"),
    [([["a", "a"]], "'a' goes with itself"), ([["a", "b"], ["b", "a"]], "the two are correlated already"),
     ([["a", "s"]], "'s' is a seed, and goes with nothing")],
)  # fmt: skip
def test_odd_correlations(pairs, words):
    design = load_preset("quad-bellows-heading").model_dump(mode="json")
    parameters = [drawn() | {"name": "a"}, drawn(REAR) | {"name": "b"},
                  {"pointer": "/mission/control/controller/noise/seed", "distribution": {"kind": "case_seed"},
                   "name": "s"}]  # fmt: skip
    given = monte_carlo(*parameters, correlations=[{"between": pair, "value": 0.5} for pair in pairs])
    refused(given | {"design": design}, f"/correlations/{len(pairs) - 1}/between", words)


def test_points_that_would_fill_the_memory_are_refused():
    given = document("sweep", method={"kind": "latin_hypercube", "parameters": [ranged(), ranged(DENSITY, 1e3, 1.1e3)],
                                      "count": 10**8})  # fmt: skip
    refused(given, "/method/count", "200000000 numbers laid out together", "monte_carlo", max_cases=10**9)


def test_the_checksum_is_of_what_decides_the_numbers():
    base = EXAMPLES["monte_carlo"]

    def sum_of(given, version="1"):
        spec = parse_spec(given)
        return checksum(spec, spec.design, version)

    same = [base | {"name": "a"}, base | {"notes": "b"}, base | {"trajectories": "none"}, dict(reversed(base.items()))]
    assert {sum_of(given) for given in [*same, base]} == {sum_of(base)}
    heavier = parse_design(base["design"] | {"name": "Another"}).model_dump(mode="json")
    others = [base | {"seed": 1}, base | {"count": 11}, base | {"trajectories": "all"}, base | {"stop": None},
              base | {"metrics": ["range"]}, base | {"design": heavier}]  # fmt: skip
    sums = {sum_of(given) for given in others} | {sum_of(base), sum_of(base, "2")}
    assert len(sums) == len(others) + 2


def test_a_stored_design_is_named_instead():
    given = document() | {"design_id": "abc", "revision": 3}
    del given["design"]
    spec = parse_spec(given)
    assert (spec.design, spec.design_id, spec.revision) == (None, "abc", 3)
    assert make_plan(spec, DESIGN, max_cases=1).count == 1


def test_rows_beyond_the_cases_are_a_fault_of_the_caller():
    plan = plan_of(EXAMPLES["sobol"])
    for first, last in ((-1, 2), (3, 2), (0, 9)):
        with pytest.raises(ValueError, match="not within 0 to 8"):
            plan.rows(first, last)
