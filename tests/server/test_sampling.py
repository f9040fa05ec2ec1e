"""Values of cases: pure functions of seed and number, with the distributions, strata and correlations that were asked.

Statistical bounds are six standard errors of the statistic at a fixed seed: a right sampler fails one in 5e8.
"""

import json
import math
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import kstest, norm, spearmanr, truncnorm

from server.jobs.parameters import CaseSeed, Levels, Normal, Range, TruncatedNormal, Uniform
from server.jobs.sampling import Combinations, Draws, Listed, OneCase, Spread, triangular_factor

N = 100_000
SIGMAS = 6.0
NORMAL = Normal(kind="normal", mean=2.0, sd=0.5)
UNIFORM = Uniform(kind="uniform", low=-1.0, high=3.0)
SEEDS = CaseSeed(kind="case_seed")


def between(low, high):
    return Range(pointer="/p", low=low, high=high)


def draws(*distributions, correlation=None, seed=1, count=N):
    return Draws(distributions, None if correlation is None else triangular_factor(correlation), count, seed)


def columns(sampler):
    return np.array(sampler.rows(0, sampler.count)).T


def assert_within(value, truth, standard_error):
    assert abs(value - truth) < SIGMAS * standard_error


def test_the_last_parameter_changes_fastest():
    plan = Combinations((Levels(pointer="/a", values=("x", "y")), Levels(pointer="/b", low=0.0, high=1.0, count=3)))
    assert plan.rows(0, plan.count) == [("x", 0.0), ("x", 0.5), ("x", 1.0), ("y", 0.0), ("y", 0.5), ("y", 1.0)]


def test_a_billion_combinations_take_no_memory():
    axis = Levels(pointer="/a", low=-1.0, high=0.7, count=1000)
    plan = Combinations((axis, axis, axis))
    assert plan.count == 10**9
    assert plan.rows(0, 2) == [(-1.0, -1.0, -1.0), (-1.0, -1.0, axis.level(1))]
    assert plan.rows(10**9 - 1, 10**9) == [(0.7, 0.7, 0.7)]
    assert plan.rows(123_456_789, 123_456_790) == [(axis.level(123), axis.level(456), axis.level(789))]


@given(st.lists(st.integers(1, 4), min_size=1, max_size=4))
def test_every_combination_comes_once(sizes):
    plan = Combinations([Levels(pointer="/p", values=tuple(range(size))) for size in sizes])
    rows = plan.rows(0, plan.count)
    assert len(set(rows)) == len(rows) == math.prod(sizes)
    assert rows == sorted(rows)


@given(st.floats(-1e3, 1e3), st.floats(1e-3, 1e3), st.integers(2, 50))
def test_levels_are_even_and_their_ends_exact(low, width, count):
    levels = Levels(pointer="/p", low=low, high=low + width, count=count)
    values = [levels.level(k) for k in range(count)]
    assert (values[0], values[-1]) == (low, low + width)
    assert np.allclose(values, np.linspace(low, low + width, count), rtol=0.0, atol=1e-12 * (abs(low) + width))


@pytest.mark.parametrize("count", [1, 7, 100])
def test_a_latin_hypercube_has_one_case_in_every_slice(count):
    plan = Spread("latin_hypercube", (between(-2.0, 2.0), between(0.0, 1e-3), between(5.0, 6.0)), count, 3)
    for values, (low, high) in zip(columns(plan), [(-2.0, 2.0), (0.0, 1e-3), (5.0, 6.0)], strict=True):
        slices = np.floor((values - low) / (high - low) * count).astype(int)
        assert sorted(slices.tolist()) == list(range(count))


def test_sobol_points_are_balanced_in_every_dyadic_slice_and_box():
    """2^m points of a (t, m, 2) net with t = 0: one in each box of volume 2^-m, whatever its shape."""
    m = 8
    x, y = columns(Spread("sobol", (between(0.0, 1.0), between(0.0, 1.0)), 2**m, 5))
    for k in range(m + 1):
        boxes = np.floor(x * 2**k) * 2 ** (m - k) + np.floor(y * 2 ** (m - k))
        assert len(set(boxes.tolist())) == 2**m


def test_sobol_points_integrate_better_than_random_ones():
    """The mean of x y over the unit square is 1/4; random points miss it by 0.22 / sqrt(n)."""
    x, y = columns(Spread("sobol", (between(0.0, 1.0), between(0.0, 1.0)), 1024, 5))
    assert abs(float(np.mean(x * y)) - 0.25) < 0.22 / math.sqrt(1024) / 20.0


@pytest.mark.parametrize("kind", ["latin_hypercube", "sobol"])
def test_the_seed_decides_the_points(kind):
    box = (between(0.0, 1.0), between(0.0, 1.0))
    points = Spread(kind, box, 64, 1).rows(0, 64)
    assert points == Spread(kind, box, 64, 1).rows(0, 64)
    assert points != Spread(kind, box, 64, 2).rows(0, 64)
    assert points[10:20] == Spread(kind, box, 64, 1).rows(10, 20)


@given(st.integers(0, 1000), st.integers(0, 50), st.integers(0, 2**53 - 1))
def test_a_case_has_its_numbers_whatever_is_drawn_with_it(first, size, seed):
    correlation = np.array([[1.0, 0.6, 0.2], [0.6, 1.0, -0.1], [0.2, -0.1, 1.0]])
    truncated = TruncatedNormal(kind="truncated_normal", mean=0.0, sd=1.0, low=-1.0, high=0.5)
    plan = draws(NORMAL, UNIFORM, truncated, correlation=correlation, seed=seed)
    together = plan.rows(first, first + size)
    assert together == [plan.rows(case, case + 1)[0] for case in range(first, first + size)]


def test_numbers_stay_the_same_from_version_to_version():
    """Random numbers of a released program never change; these are Philox's with the key (7, 0)."""
    plan = draws(Uniform(kind="uniform", low=0.0, high=1.0), NORMAL, SEEDS, seed=7, count=10**6)
    found = plan.rows(0, 2) + plan.rows(999_999, 1_000_000)
    kept = [
        (0.8720734548204873, 2.571426778545745, 5876587836888332.0),
        (0.29536538151378366, 2.506787411192432, 1798282081318088.0),
        (0.7963667822051262, 1.8816605132090631, 1494513772275073.0),
    ]
    for row, pinned in zip(found, kept, strict=True):
        assert (row[0], row[2]) == (pinned[0], pinned[2])
        assert math.isclose(row[1], pinned[1], rel_tol=1e-14)  # through a logarithm, whose last bit may differ


def test_another_process_draws_the_same():
    code = (
        "from server.jobs.sampling import Draws; from server.jobs.parameters import Normal; import json;"
        "print(json.dumps(Draws((Normal(kind='normal', mean=2.0, sd=0.5),), None, 9, 11).rows(2, 9)))"
    )
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert [tuple(row) for row in json.loads(told)] == draws(NORMAL, seed=11).rows(2, 9)


def test_a_further_parameter_leaves_the_others_alone():
    alone, more = draws(NORMAL, UNIFORM).rows(0, 20), draws(NORMAL, UNIFORM, NORMAL, SEEDS).rows(0, 20)
    assert [row[:2] for row in more] == alone


def test_seeds_and_parameters_are_independent():
    first, second = columns(draws(NORMAL, NORMAL, seed=1))
    (other,) = columns(draws(NORMAL, seed=2))
    for a, b in ((first, second), (first, other), (first[1:], first[:-1])):
        assert_within(np.corrcoef(a, b)[0, 1], 0.0, 1.0 / math.sqrt(N))


def test_normal_draws():
    (values,) = columns(draws(NORMAL))
    assert_within(values.mean(), 2.0, 0.5 / math.sqrt(N))
    assert_within(values.std(), 0.5, 0.5 / math.sqrt(2 * N))
    assert kstest(values, norm(2.0, 0.5).cdf).pvalue > 1e-6


def test_uniform_draws():
    (values,) = columns(draws(UNIFORM))
    assert values.min() >= -1.0 and values.max() <= 3.0
    assert_within(values.mean(), 1.0, 4.0 / math.sqrt(12 * N))
    assert kstest((values + 1.0) / 4.0, "uniform").pvalue > 1e-6


@pytest.mark.parametrize(("low", "high"), [(1.0, 2.2), (-9.0, 1.5), (3.0, 99.0), (4.5, 5.0), (-1.0, -0.5), (-9.0, 9.0)])
def test_truncated_draws(low, high):
    """Through the middle, and far out on either side, where naive formulas lose all digits."""
    (values,) = columns(draws(TruncatedNormal(kind="truncated_normal", mean=2.0, sd=0.5, low=low, high=high)))
    truth = truncnorm((low - 2.0) / 0.5, (high - 2.0) / 0.5, loc=2.0, scale=0.5)
    assert values.min() >= low and values.max() <= high
    assert_within(values.mean(), truth.mean(), truth.std() / math.sqrt(N))
    fourth = truth.expect(lambda x: (x - truth.mean()) ** 4)
    assert_within(values.var(), truth.var(), math.sqrt((fourth - truth.var() ** 2) / N))
    assert kstest(values, truth.cdf).pvalue > 1e-6


def test_seeds_of_cases_are_whole_distinct_and_spread():
    (values,) = columns(draws(SEEDS))
    assert values.min() >= 0.0 and values.max() < 2.0**53
    assert np.array_equal(values, np.floor(values)) and len(np.unique(values)) == N
    assert kstest(values / 2.0**53, "uniform").pvalue > 1e-6


@pytest.mark.parametrize("rho", [-0.9, -0.3, 0.6, 0.95])
def test_correlated_normals_have_the_correlation(rho):
    """Pearson rho, and Spearman (6 / pi) asin(rho / 2) (Pearson, 1907), of a Gaussian copula."""
    x, y = columns(draws(NORMAL, Normal(kind="normal", mean=-1.0, sd=3.0), correlation=np.array([[1, rho], [rho, 1]])))
    assert_within(np.corrcoef(x, y)[0, 1], rho, (1.0 - rho**2) / math.sqrt(N))
    assert_within(spearmanr(x, y).statistic, 6.0 / math.pi * math.asin(rho / 2.0), 1.0 / math.sqrt(N))
    assert_within(y.std(), 3.0, 3.0 / math.sqrt(2 * N))


@pytest.mark.parametrize("rho", [-0.7, 0.5])
def test_correlated_uniforms_keep_their_distribution(rho):
    """The copula's Spearman correlation is that of any two continuous distributions, and Pearson's of two uniforms."""
    correlation = np.array([[1.0, rho], [rho, 1.0]])
    x, y = columns(draws(UNIFORM, UNIFORM, correlation=correlation))
    truth = 6.0 / math.pi * math.asin(rho / 2.0)
    assert_within(spearmanr(x, y).statistic, truth, 1.0 / math.sqrt(N))
    assert_within(np.corrcoef(x, y)[0, 1], truth, 1.0 / math.sqrt(N))
    assert kstest((y + 1.0) / 4.0, "uniform").pvalue > 1e-6


def test_wholly_correlated_parameters_move_as_one():
    x, y = columns(draws(NORMAL, NORMAL, correlation=np.ones((2, 2))))
    assert np.array_equal(x, y)
    x, y = columns(draws(NORMAL, NORMAL, correlation=np.array([[1.0, -1.0], [-1.0, 1.0]])))
    assert np.allclose(x + y, 4.0, rtol=0.0, atol=1e-12)


def test_no_draw_is_infinite_however_it_is_correlated():
    correlation = np.full((3, 3), 0.999) + 0.001 * np.eye(3)
    values = columns(draws(NORMAL, NORMAL, NORMAL, correlation=correlation))
    assert np.isfinite(values).all()


@given(st.integers(1, 6), st.integers(1, 6), st.integers(0, 2**32 - 1))
def test_the_factor_of_a_correlation_matrix_gives_it_back(size, rank, seed):
    """Of full rank or less."""
    vectors = np.random.default_rng(seed).normal(size=(size, rank))
    vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
    R = vectors @ vectors.T
    L = triangular_factor(R)
    assert np.array_equal(L, np.tril(L))
    assert np.allclose(L @ L.T, R, rtol=0.0, atol=1e-5)  # a pivot of rounding, 1e-12, counts as none


def test_listed_rows_and_the_single_case():
    assert Listed(((1, "x"), (2, None), (3, "y"))).rows(1, 3) == [(2, None), (3, "y")]
    assert OneCase().rows(0, 1) == [()]
