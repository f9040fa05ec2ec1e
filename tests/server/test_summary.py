"""The summary against other means: numpy, scipy, and the truth of known distributions."""

from __future__ import annotations

import json
import math
import os

import numpy as np
import pytest
from scipy import stats

from models.presets import load_preset
from server.jobs import intervals, summary
from server.jobs.case_table import CaseRow
from server.jobs.correlations import correlations
from server.jobs.files import JobFiles
from server.jobs.intervals import interval_of_mean, normal_interval
from server.jobs.moments import Moments
from server.jobs.results import Results
from server.jobs.sensitivity import Samples
from server.jobs.spec import parse_spec
from server.jobs.summary import summarize
from server.jobs.task import ChunkResult, ColumnInfo
from tests.server.results_support import METRICS, PARAMETERS, REASON, case_row, made_up, write_chunks

ROWS = [case_row(k) for k in range(100)]
FINE = [row for row in ROWS if row.status == "completed"]


def metric_values(name):
    """Return a metric's values in the cases that went well, and where it has one."""
    return np.array([row.metrics[METRICS.index(name)] for row in FINE])


def parameter_values(name):
    return np.array([row.values[PARAMETERS.index(name)] for row in FINE], dtype=float)


@pytest.mark.parametrize("name", METRICS)
def test_statistics_are_numpys_of_the_cases_that_went_well(tmp_path, name):
    told = summarize(made_up(tmp_path), drawn=True)["metrics"][name]
    values = metric_values(name)
    values = values[~np.isnan(values)]
    assert told["count"] == len(values) and told["missing"] == 100 - len(values)
    assert told["least"] == values.min() and told["most"] == values.max()
    # sums in another order: a few roundings
    assert told["mean"] == pytest.approx(values.mean(), rel=1e-14)
    assert told["sd"] == pytest.approx(values.std(ddof=1), rel=1e-13)
    assert told["percentiles"] == {str(p): np.percentile(values, p) for p in (5, 25, 50, 75, 95)}
    interval = interval_of_mean(values)
    assert told["interval"] == {
        "of": "mean", "low": interval.low, "high": interval.high, "method": "bootstrap", "confidence": 0.95,
    }  # fmt: skip


@pytest.mark.parametrize("most", [summary.MOST_VALUES, 80])
def test_only_means_of_independent_draws_have_intervals(tmp_path, monkeypatch, most):
    monkeypatch.setattr(summary, "MOST_VALUES", most)
    results = made_up(tmp_path)
    laid_out, drawn = summarize(results)["metrics"], summarize(results, drawn=True)["metrics"]
    for name in METRICS:
        assert laid_out[name]["interval"] is None and drawn[name]["interval"] is not None
        assert laid_out[name] | {"interval": None} == drawn[name] | {"interval": None}


def test_what_a_metric_is_comes_along(tmp_path):
    told = summarize(made_up(tmp_path))
    assert list(told["metrics"]) == METRICS
    assert told["metrics"]["range"]["unit"] == "m" and told["metrics"]["range"]["meaning"] == "distance"
    assert told["cases"] == 100 and told["sampled"] is None and told["indices"] is None
    json.dumps(told, allow_nan=False)


def test_correlations_are_scipys(tmp_path):
    told = summarize(made_up(tmp_path))["correlations"]
    numeric = [name for name in PARAMETERS if name != "method"]
    assert [(c["parameter"], c["metric"]) for c in told] == [(p, m) for p in numeric for m in METRICS]
    for c in told:
        x, y = parameter_values(c["parameter"]), metric_values(c["metric"])
        both = ~np.isnan(x) & ~np.isnan(y)
        assert c["count"] == both.sum()
        assert c["pearson"] == pytest.approx(stats.pearsonr(x[both], y[both]).statistic, abs=1e-12)
        assert c["spearman"] == pytest.approx(stats.spearmanr(x[both], y[both]).statistic, abs=1e-12)


def test_correlations_where_values_are_missing_tied_constant_or_alone():
    generator = np.random.default_rng(3)
    x = generator.integers(0, 4, (60, 3)).astype(float)
    y = generator.normal(size=(60, 4)) + x[:, :1]
    x[5:20, 1] = np.nan
    x[:, 2] = 0.1
    y[10:30, 1] = np.nan
    y[1:, 2] = np.nan
    y[:, 3] = np.exp(y[:, 0])
    for c in correlations(x, y, ["a", "b", "c"], ["p", "q", "r", "s"]):
        a, b = x[:, "abc".index(c["parameter"])], y[:, "pqrs".index(c["metric"])]
        both = np.isfinite(a) & np.isfinite(b)
        assert c["count"] == both.sum()
        if c["parameter"] == "c" or c["metric"] == "r":
            assert c["pearson"] is None and c["spearman"] is None
        else:
            assert c["pearson"] == pytest.approx(stats.pearsonr(a[both], b[both]).statistic, abs=1e-12)
            assert c["spearman"] == pytest.approx(stats.spearmanr(a[both], b[both]).statistic, abs=1e-12)


def test_a_line_correlates_wholly_whatever_its_size():
    x = np.linspace(0.0, 1.0, 11)[:, None]
    y = np.concatenate([2.0 * x + 1.0, -1e300 * x, 1e-300 * x], axis=1)
    found = correlations(x, y, ["x"], ["up", "down", "small"])
    assert [c["pearson"] for c in found] == pytest.approx([1.0, -1.0, 1.0], abs=1e-12)
    assert [c["spearman"] for c in found] == pytest.approx([1.0, -1.0, 1.0], abs=1e-12)


def test_failures_are_grouped_by_reason(tmp_path):
    told = summarize(made_up(tmp_path))
    refused = [row.case for row in ROWS if row.status == "refused"]
    assert told["failures"] == [
        {"reason": ROWS[6].group, "count": len(refused), "case": 6},
        {"reason": "diverged", "count": 1, "case": 5},
    ]
    assert told["failed"] == len(refused) + 1 and REASON.split(" is ")[0] in told["failures"][0]["reason"]


def test_a_job_of_which_little_or_nothing_is_done(tmp_path):
    empty = summarize(Results(JobFiles(tmp_path, "job"), cases=10, chunk_size=4), keep=True)
    assert empty == {
        "cases": 0, "failed": 0, "sampled": None, "metrics": {}, "correlations": [], "failures": [], "indices": None,
    }  # fmt: skip
    one = summarize(made_up(tmp_path, 1), drawn=True)["metrics"]["range"]
    assert one["mean"] == one["least"] == one["percentiles"]["5"] == ROWS[0].metrics[0]
    assert one["sd"] is None and one["interval"] is None
    failed = summarize(made_up(tmp_path, 100, without=set(range(1, 13)), counted=100))["metrics"]["range"]
    assert failed["count"] == 6  # of cases 0 to 7, two failed


def test_a_job_of_which_every_case_failed(tmp_path):
    rows = [CaseRow(k, "refused", "no", ROWS[k].values, [math.nan] * 3) for k in range(10)]
    told = summarize(write_chunks(tmp_path, rows, size=4))
    assert told["failed"] == 10 and told["metrics"]["range"]["count"] == 0
    assert told["metrics"]["range"]["mean"] is None and told["metrics"]["range"]["percentiles"]["50"] is None
    assert all(c["count"] == 0 and c["pearson"] is None for c in told["correlations"])


# intervals of the mean

REPEATS = 400
LEAST_COVERED = int(stats.binom.ppf(1e-4, REPEATS, 0.94))
"""A 95 % interval of samples of this size covers at least 94 %: skewness costs up to a point; chance has its part."""
MOST_COVERED = int(stats.binom.ppf(1 - 1e-4, REPEATS, 0.955))
DRAWS = {
    "normal": (lambda g: g.normal(3.0, 2.0, 200), 3.0),
    "exponential": (lambda g: g.exponential(1.0, 400), 1.0),
    "uniform": (lambda g: g.uniform(-1.0, 1.0, 100), 0.0),
}


@pytest.mark.parametrize("name", DRAWS)
def test_the_bootstrap_covers_the_mean_as_often_as_it_says(name):
    draw, mean = DRAWS[name]
    generator = np.random.default_rng(11)
    found = [interval_of_mean(draw(generator)) for _ in range(REPEATS)]
    covered = sum(interval.low <= mean <= interval.high for interval in found)
    assert LEAST_COVERED <= covered <= MOST_COVERED
    assert all(interval.method == "bootstrap" for interval in found)


def test_the_bootstrap_is_scipys_but_for_its_own_chance():
    values = np.random.default_rng(5).exponential(size=150)
    found = interval_of_mean(values)
    theirs = stats.bootstrap((values,), np.mean, n_resamples=20_000, method="BCa", rng=np.random.default_rng(1))
    # an end is a 2.5 % point of 2,000 resamples: its standard error is about sqrt(0.025 x 0.975 / 2000) / (density
    # there, 0.058 / se), which is 0.06 standard errors of the mean; four of those
    reach = 4 * 0.06 * values.std(ddof=1) / 150**0.5
    assert found.low == pytest.approx(theirs.confidence_interval.low, abs=reach)
    assert found.high == pytest.approx(theirs.confidence_interval.high, abs=reach)
    assert values.mean() - found.low < found.high - values.mean()  # skewed as the values are


def test_the_same_values_give_the_same_interval():
    values = np.random.default_rng(5).normal(size=300)
    assert interval_of_mean(values) == interval_of_mean(values.copy())


def test_the_methods_meet_where_one_takes_over(monkeypatch):
    values = np.random.default_rng(8).lognormal(size=intervals.MOST_RESAMPLED)
    bootstrap = interval_of_mean(values)
    normal = normal_interval(values.mean(), values.std(ddof=1), len(values))
    assert bootstrap.method == "bootstrap" and normal.method == "normal"
    # skewness 6: skewness / (6 sqrt(n)) (z^2 - 1) = 0.04 standard errors, beside the chance of resampling
    assert [bootstrap.low, bootstrap.high] == pytest.approx(
        [normal.low, normal.high], abs=0.3 * values.std() / len(values) ** 0.5
    )
    assert interval_of_mean(np.append(values, 1.0)).method == "normal"


@pytest.mark.parametrize("values", [[1.0, 1.0, 1.0], [0.1] * 50])
def test_the_interval_of_a_constant_is_a_point(values):
    found = interval_of_mean(np.array(values))
    assert found.low == found.high == pytest.approx(values[0], rel=1e-15)


@pytest.mark.parametrize("values", [[], [1.0]])
def test_no_interval_of_fewer_than_two_values(values):
    assert interval_of_mean(np.array(values)) is None


@pytest.mark.parametrize("scale", [1e-300, 1e300])
def test_the_interval_scales_with_the_values(scale):
    values = np.random.default_rng(5).exponential(size=50)
    small, large = interval_of_mean(values), interval_of_mean(scale * values)
    assert [large.low / scale, large.high / scale] == pytest.approx([small.low, small.high], rel=1e-13)


def test_the_interval_of_two_values_lies_between_them():
    found = interval_of_mean(np.array([1.0, 2.0]))
    assert 1.0 <= found.low <= 1.5 <= found.high <= 2.0


# sums by parts


def test_moments_in_parts_are_those_of_the_whole():
    generator = np.random.default_rng(2)
    values = generator.normal(1e8, 1.0, (1000, 3))  # a large mean: naive sums of squares would lose all digits
    values[::3, 1] = np.nan
    values[:, 2] = np.nan
    moments = Moments(3)
    for part in np.split(values, [1, 7, 7, 400, 999]):
        moments.add(part)
    assert moments.count.tolist() == [1000, 666, 0]
    wanted = values[:, :2]
    assert moments.mean[:2] == pytest.approx(np.nanmean(wanted, axis=0), rel=1e-15)
    # means near 1e8 are rounded to 1.5e-8, hence the squares
    assert moments.sd[:2] == pytest.approx(np.nanstd(wanted, axis=0, ddof=1), rel=3e-8)
    assert moments.least[:2].tolist() == np.nanmin(wanted, axis=0).tolist()
    assert moments.most[:2].tolist() == np.nanmax(wanted, axis=0).tolist()
    assert np.isnan([moments.mean[2], moments.sd[2], moments.least[2], moments.most[2]]).all()


def test_of_very_many_cases_a_part_is_held_and_that_is_told(tmp_path, monkeypatch):
    columns = [ColumnInfo("p", "m", "", "parameter"), ColumnInfo("m", "m", "", "metric")]
    values = np.random.default_rng(4).normal(size=20_000)
    rows = [CaseRow(k, "completed", None, [v], [2.0 * v]) for k, v in enumerate(values.tolist())]
    results = write_chunks(tmp_path, rows, size=5000, columns=columns)
    monkeypatch.setattr(summary, "MOST_VALUES", 2 * 2000)
    told = summarize(results, drawn=True)
    # 2,000 are wanted, each case is taken by chance
    assert told["sampled"] == pytest.approx(2000, abs=5 * 2000**0.5)
    metric = told["metrics"]["m"]
    assert metric["count"] == told["cases"] == 20_000
    assert metric["mean"] == pytest.approx(2.0 * values.mean(), abs=1e-13)
    assert metric["sd"] == pytest.approx(2.0 * values.std(ddof=1), rel=1e-12)
    assert metric["most"] == 2.0 * values.max() and metric["interval"]["method"] == "normal"
    # the median of n normal values has the standard error 1.25 sd / sqrt(n)
    assert metric["percentiles"]["50"] == pytest.approx(0.0, abs=4 * 1.25 * 2.0 / 2000**0.5)
    assert told["correlations"][0]["pearson"] == pytest.approx(1.0, abs=1e-12)
    assert told == summarize(results, drawn=True)


# what is kept


def test_a_summary_is_kept_until_a_chunk_changes(tmp_path, monkeypatch):
    results = made_up(tmp_path)
    first = summarize(results, keep=True)
    assert (results.files.folder / "summary.json").exists()
    computed = []
    monkeypatch.setattr(summary, "_summary", lambda *_, **__: computed.append(1) or {"new": True})
    assert summarize(results, keep=True) == first and not computed
    content = results.files.path(3).read_bytes()
    results.files.write(3, ChunkResult(content, None, 8, 0.0, "kernel", "processor"))
    os.utime(results.files.path(3), ns=(1, 1))
    assert summarize(results, keep=True) == {"new": True}
    results.files.path(3).unlink()
    summarize(results, keep=True)
    summarize(Results(results.files, cases=50, chunk_size=8), keep=True)
    assert len(computed) == 3


def test_a_kept_summary_that_is_damaged_is_computed_again(tmp_path):
    results = made_up(tmp_path)
    first = summarize(results, keep=True)
    for content in (b"", b"[]", b"{}", b'{"of": "other", "summary": {}}', b"\xff"):
        (results.files.folder / "summary.json").write_bytes(content)
        assert summarize(results, keep=True) == first


def test_a_running_job_keeps_no_summary(tmp_path):
    results = made_up(tmp_path, without={12})
    summarize(results)
    assert not (results.files.folder / "summary.json").exists()


# indices


def study(**method):
    low_high = [{"name": name, "pointer": "/mission/duration", "low": -np.pi, "high": np.pi} for name in "abc"]
    return parse_spec(
        {
            "format": "glider-batch", "version": 1, "kind": "sensitivity", "parameters": low_high, "method": method,
            "design": load_preset("three-cell-glider").model_dump(mode="json"),
        }
    )  # fmt: skip


def ishigami(a, b, c):
    return math.sin(a) + 7.0 * math.sin(b) ** 2 + 0.1 * c**4 * math.sin(a)


def studied(folder, spec, *, failed=()):
    columns = [ColumnInfo(name, "rad", "", "parameter") for name in "abc"] + [ColumnInfo("f", "1", "", "metric")]
    samples = Samples(spec)
    rows = [
        CaseRow(k, "diverged" if k in failed else "completed", None, row, [ishigami(*row)])
        for k, row in enumerate(samples.rows(0, samples.count))
    ]
    return write_chunks(folder, rows, size=1000, columns=columns)


def test_indices_of_a_function_whose_indices_are_known(tmp_path):
    spec = study(kind="sobol", base=1024)
    told = summarize(studied(tmp_path, spec), study=spec)["indices"]["f"]
    # Ishigami and Homma (1990): first-order shares of the variance in closed form
    variance = 49.0 / 8.0 + 0.1 * np.pi**4 / 5.0 + 0.01 * np.pi**8 / 18.0 + 0.5
    first = {"a": 0.5 * (1.0 + 0.1 * np.pi**4 / 5.0) ** 2 / variance, "b": 49.0 / 8.0 / variance, "c": 0.0}
    for name, share in first.items():
        assert told["first"][name]["value"] == pytest.approx(share, abs=0.05)
    assert told["reason"] is None and told["total"]["c"]["value"] > 0.2


def test_no_indices_where_a_case_failed(tmp_path):
    spec = study(kind="morris", trajectories=4)
    told = summarize(studied(tmp_path, spec, failed={5}), study=spec)["indices"]["f"]
    assert "case 5 has no value" in told["reason"] and "mu" not in told
