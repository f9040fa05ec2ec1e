"""Sensitivity studies against functions whose indices are known in closed form."""

import math

import numpy as np
import pytest

from models.presets import load_preset
from server.jobs.plan import make_plan
from server.jobs.sensitivity import cases_needed, indices
from server.jobs.spec import parse_spec

DESIGN = load_preset("canete-dual-bellows")
POINTERS = ("/vehicle/components/1/position/0", "/vehicle/components/2/position/0", "/vehicle/components/0/position/0")
NAMES = ["a", "b", "c"]


def plan_of(method, ranges, seed=3):
    parameters = [
        {"pointer": pointer, "name": name, "low": low, "high": high}
        for pointer, name, (low, high) in zip(POINTERS, NAMES, ranges, strict=False)
    ]
    spec = parse_spec({
        "format": "glider-batch", "version": 1, "kind": "sensitivity", "design_id": "x", "seed": seed,
        "method": method, "parameters": parameters,
    })  # fmt: skip
    return make_plan(spec, DESIGN, max_cases=10**6)


def samples_of(plan):
    return np.array(plan.rows(0, plan.count)).T


def ishigami(x, y, z):
    return np.sin(x) + 7.0 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)


def ishigami_truth():
    """Shares of the variance (Ishigami and Homma, 1990; Saltelli et al., 2008, Global Sensitivity Analysis)."""
    a, b, p = 7.0, 0.1, math.pi
    total = a**2 / 8.0 + b * p**4 / 5.0 + b**2 * p**8 / 18.0 + 0.5
    x, y = 0.5 * (1.0 + b * p**4 / 5.0) ** 2, a**2 / 8.0
    xz = b**2 * p**8 * (1.0 / 18.0 - 1.0 / 50.0)
    return (
        {"a": x / total, "b": y / total, "c": 0.0},
        {"a": (x + xz) / total, "b": y / total, "c": xz / total},
        xz / total,
    )


def test_sobol_indices_of_ishigamis_function():
    plan = plan_of({"kind": "sobol", "base": 4096, "second_order": True}, [(-math.pi, math.pi)] * 3)
    assert plan.count == 4096 * 8 == cases_needed(plan.spec)
    found = indices(plan.spec, NAMES, {"f": ishigami(*samples_of(plan))})["f"]
    first, total, interaction = ishigami_truth()
    assert (found["method"], found["reason"]) == ("sobol", None)
    for name in NAMES:  # quasi-random points of 4096 know them to about 0.005
        assert math.isclose(found["first"][name]["value"], first[name], abs_tol=0.02)
        assert math.isclose(found["total"][name]["value"], total[name], abs_tol=0.02)
        assert 0.0 <= found["total"][name]["half_width"] < 0.1
    pairs = {tuple(pair["between"]): pair["value"] for pair in found["interaction"]}
    assert list(pairs) == [("a", "b"), ("a", "c"), ("b", "c")]
    assert math.isclose(pairs["a", "c"], interaction, abs_tol=0.03)
    assert abs(pairs["a", "b"]) < 0.03 and abs(pairs["b", "c"]) < 0.03


def test_without_second_order_the_same_indices_take_fewer_cases():
    plan = plan_of({"kind": "sobol", "base": 4096}, [(-math.pi, math.pi)] * 3)
    assert plan.count == 4096 * 5
    found = indices(plan.spec, NAMES, {"f": ishigami(*samples_of(plan))})["f"]
    assert "interaction" not in found
    first, total, _ = ishigami_truth()
    for name in NAMES:
        assert math.isclose(found["first"][name]["value"], first[name], abs_tol=0.02)
        assert math.isclose(found["total"][name]["value"], total[name], abs_tol=0.02)


@pytest.mark.parametrize("levels", [2, 4, 10])
def test_morris_effects_of_a_linear_function(levels):
    """Its elementary effects are its slopes times the ranges, everywhere: no spread, no error."""
    plan = plan_of({"kind": "morris", "trajectories": 12, "levels": levels}, [(0.0, 2.0), (-1.0, 0.5), (3.0, 3.1)])
    assert plan.count == 48
    a, b, c = samples_of(plan)
    found = indices(plan.spec, NAMES, {"f": 5.0 * a - 3.0 * b + 40.0 * c + 1.0})["f"]
    for name, effect in (("a", 10.0), ("b", -4.5), ("c", 4.0)):
        assert math.isclose(found["mu"][name], effect, rel_tol=1e-9)
        assert math.isclose(found["mu_star"][name]["value"], abs(effect), rel_tol=1e-9)
        assert found["mu_star"][name]["half_width"] < 1e-9 and found["sigma"][name] < 1e-9


def test_morris_effects_see_an_interaction():
    """Of a b over the unit square: the effect of a is b, spread, and its mean is 1/2."""
    plan = plan_of({"kind": "morris", "trajectories": 2000}, [(0.0, 1.0), (0.0, 1.0)])
    a, b = samples_of(plan)
    found = indices(plan.spec, NAMES[:2], {"f": a * b})["f"]
    assert math.isclose(found["mu"]["a"], 0.5, abs_tol=6.0 * 0.5 / math.sqrt(2000))
    # b stands on 0, 1/3, 2/3 or 1 alike: its standard deviation is sqrt(5) / 6
    assert math.isclose(found["sigma"]["a"], math.sqrt(5.0) / 6.0, rel_tol=0.05)


@pytest.mark.parametrize("method", [{"kind": "sobol", "base": 64}, {"kind": "morris", "trajectories": 20}])
def test_a_metric_with_failed_cases_has_a_reason_instead_of_numbers(method):
    plan = plan_of(method, [(0.0, 1.0)] * 3)
    good = samples_of(plan)[0]
    bad = good.copy()
    bad[[3, 17]] = math.nan
    many = good.copy()
    many[10:20] = math.nan
    found = indices(plan.spec, NAMES, {"good": good, "bad": bad, "many": many, "short": good[:-1]})
    assert found["good"]["reason"] is None
    assert found["bad"] == {
        "method": method["kind"],
        "reason": f"cases 3, 17 have no value, and indices need one of each of the {plan.count} cases: narrow the "
        "ranges, or retry",
    }
    assert found["many"]["reason"].startswith("cases 10, 11, 12, 13, 14 and 5 more have no value")
    assert found["short"]["reason"] == f"{plan.count - 1} of {plan.count} cases are done; indices need all of them"


@pytest.mark.parametrize("method", [{"kind": "sobol", "base": 64}, {"kind": "morris", "trajectories": 20}])
def test_a_metric_that_does_not_vary_says_so(method):
    plan = plan_of(method, [(0.0, 1.0)] * 3)
    constant = np.full(plan.count, 4.2)
    found = indices(plan.spec, NAMES, {"f": constant, "zero": 0.0 * constant})
    assert found["f"]["reason"] == "it is 4.2 in every case: no parameter changes it"
    assert found["zero"]["reason"] == "it is 0 in every case: no parameter changes it"


@pytest.mark.parametrize("method", [{"kind": "sobol", "base": 64}, {"kind": "morris", "trajectories": 20}])
@pytest.mark.parametrize("seed", [0, 5])
def test_seed_and_document_decide_samples_and_indices(method, seed):
    """Whatever numpy's global generator does meanwhile."""
    found = []
    for disturbance in (1, 2):
        np.random.seed(disturbance)
        plan = plan_of(method, [(0.0, 1.0)] * 3, seed)
        a, b, c = samples_of(plan)
        found.append((plan.rows(0, plan.count), indices(plan.spec, NAMES, {"f": a + b * c})))
    assert found[0] == found[1]
    assert found[0][0] != plan_of(method, [(0.0, 1.0)] * 3, seed + 1).rows(0, plan.count)
    assert plan.rows(7, 13) == found[0][0][7:13]


def test_samples_stay_within_their_ranges():
    ranges = [(0.1, 0.3), (-0.4, -0.1), (0.0, 1e-3)]
    for method in ({"kind": "sobol", "base": 64}, {"kind": "morris", "trajectories": 20}):
        for values, (low, high) in zip(samples_of(plan_of(method, ranges)), ranges, strict=True):
            assert values.min() >= low and values.max() <= high and np.ptp(values) > 0.5 * (high - low)
