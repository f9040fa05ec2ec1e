"""When a Monte Carlo may stop: intervals that cover the truth as often as they say, a stop that only cases decide."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, expon, norm

from server.jobs.spec import Stop
from server.jobs.stopping import half_width, interval, stop_at

TRIALS = 2000
SHARES = {"median": 0.5, "p5": 0.05, "p25": 0.25, "p75": 0.75, "p95": 0.95}
TRUTHS = {"mean": 3.0, "median": 3.0, "sd": 2.0, "p5": norm.ppf(0.05, 3, 2), "p25": norm.ppf(0.25, 3, 2),
          "p75": norm.ppf(0.75, 3, 2), "p95": norm.ppf(0.95, 3, 2)}  # fmt: skip


def rule(statistic="mean", width=0.5, **options):
    return Stop(metric="range", statistic=statistic, width=width, **options)


def values(count=5000, seed=0):
    return np.random.default_rng(seed).normal(3.0, 2.0, count)


def covered(samples, statistic, truth, confidence):
    """How many intervals, one for each row, hold the truth."""
    hits = 0
    for row in samples:
        low, high = interval(row, statistic, confidence)
        hits += low <= truth <= high
    return hits


@pytest.mark.parametrize("statistic", list(TRUTHS))
@pytest.mark.parametrize("confidence", [0.8, 0.95])
def test_intervals_cover_the_truth_as_often_as_they_say(statistic, confidence):
    """Of normal values. Ranks are whole numbers, so percentiles are covered a little more often, as they tell."""
    samples = np.random.default_rng(1).normal(3.0, 2.0, (TRIALS, 150))
    hits = covered(samples, statistic, TRUTHS[statistic], confidence)
    share = SHARES.get(statistic)
    expected = confidence if share is None else coverage_of_ranks(150, share, statistic, confidence)
    assert expected >= confidence
    assert abs(hits - TRIALS * expected) < 5.0 * math.sqrt(TRIALS * expected * (1.0 - expected))


def coverage_of_ranks(count, share, statistic, confidence):
    """The chance that the quantile lies between the ranks l and u that are used: l <= B < u, B binomial."""
    low, high = interval(np.arange(1.0, count + 1.0), statistic, confidence)
    return binom.cdf(high - 1, count, share) - binom.cdf(low - 1, count, share)


def test_those_of_percentiles_hold_for_any_distribution():
    samples = np.random.default_rng(2).exponential(1.0, (TRIALS, 150))
    hits = covered(samples, "p75", expon.ppf(0.75), 0.9)
    assert hits > TRIALS * 0.9 - 5.0 * math.sqrt(TRIALS * 0.09)


@given(st.integers(20, 400), st.sampled_from(["median", "p25", "p75"]), st.sampled_from([0.8, 0.95]))
def test_ranks_are_the_tightest_that_reach_the_confidence(count, statistic, confidence):
    """Of the ranks 1, 2, ... as values: their binomial probability reaches the confidence, and barely."""
    share = SHARES[statistic]
    low, high = (int(end) for end in interval(np.arange(1.0, count + 1.0), statistic, confidence) or (0, 0))
    tail = 0.5 - 0.5 * confidence
    assert 1 <= low < high <= count
    assert binom.cdf(low - 1, count, share) <= tail + 1e-12 < binom.cdf(low, count, share) + 1e-12
    assert binom.sf(high - 1, count, share) <= tail + 1e-12 < binom.sf(high - 2, count, share) + 1e-12


def test_the_interval_of_a_mean_is_students():
    """Gosset's sleep data (Student, 1908, Biometrika 6): mean 0.75, sd 1.789, t(9, 97.5 %) 2.262."""
    hours = np.array([0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0])
    low, high = interval(hours, "mean", 0.95)
    assert math.isclose(low, 0.75 - 2.2622 * 1.78901 / math.sqrt(10), abs_tol=1e-4)
    assert math.isclose(high, 0.75 + 2.2622 * 1.78901 / math.sqrt(10), abs_tol=1e-4)


@pytest.mark.parametrize(("statistic", "least"), [("p5", 59), ("p95", 59), ("median", 5)])
def test_too_few_values_have_no_interval(statistic, least):
    """The least with which the smallest value lies below p5 with 95 %: 0.95^59 < 0.05; two-sided takes 72."""
    few = {59: 71, 5: 5}[least]
    assert interval(np.arange(float(few)), statistic, 0.95) is None
    assert interval(np.arange(float(few + 1)), statistic, 0.95) is not None


@pytest.mark.parametrize("statistic", list(TRUTHS))
def test_it_stops_at_the_first_look_that_is_narrow_enough(statistic):
    wanted = rule(statistic, width=0.6, least=50, every=30)
    column = values()
    stop = stop_at(column, wanted)
    assert stop is not None and stop % 30 == 0 and stop >= 50
    assert 2.0 * half_width(column[:stop], wanted) <= 0.6
    for cases in range(30, stop, 30):
        half = half_width(column[:cases], wanted)
        assert half is None or 2.0 * half > 0.6


@given(st.integers(0, 5000), st.integers(0, 5000))
def test_what_comes_later_or_was_looked_at_before_changes_nothing(length, looked):
    """So neither chunks nor workers do: whoever asks, with whatever prefix, gets the same stop."""
    wanted, column = rule(width=0.4, every=70), values()
    stop = stop_at(column, wanted)
    assert stop is not None
    prefix = column[:length]
    assert stop_at(prefix, wanted) == (stop if length >= stop else None)
    if looked < stop:
        assert stop_at(column, wanted, after=looked) == stop


def test_cases_without_a_value_count_as_cases_only():
    column = values()
    column[::4] = math.nan
    column[1] = math.inf
    wanted = rule(width=0.5, least=100, every=10)
    stop = stop_at(column, wanted)
    assert stop is not None
    finite = column[:stop][np.isfinite(column[:stop])]
    low, high = interval(finite, "mean", 0.95)
    assert high - low <= 0.5
    assert half_width(column[:stop], wanted) == 0.5 * (high - low)


def test_it_waits_for_the_least_of_values():
    column = np.r_[np.full(150, math.nan), np.full(150, 7.0)]
    assert stop_at(column, rule(width=1e-3, least=100, every=50)) == 250
    assert stop_at(column[:240], rule(width=1e-3, least=100, every=50)) is None
    assert half_width(column[:240], rule(least=100)) is None


def test_without_values_it_never_stops():
    assert stop_at([], rule()) is None
    assert stop_at([math.nan] * 1000, rule()) is None
    assert half_width([], rule()) is None


def test_the_width_falls_as_the_root_of_the_cases():
    wanted, column = rule(), values(40_000)
    wide, narrow = half_width(column[:10_000], wanted), half_width(column, wanted)
    assert wide is not None and narrow is not None
    assert math.isclose(wide / narrow, 2.0, rel_tol=0.03)
    assert math.isclose(narrow, 1.96 * 2.0 / 200.0, rel_tol=0.03)
