"""Owns the wire types of jobs: records, cases, results, summaries and trajectories, as answered under /jobs."""

from __future__ import annotations

from datetime import datetime
from typing import Any, Literal

from pydantic import Field

from server.schemas import Preview, Wire

State = Literal["queued", "running", "paused", "cancelling", "cancelled", "succeeded", "partial", "failed"]
Kind = Literal["simulate", "sweep", "monte_carlo", "sensitivity"]
Status = Literal[
    "completed", "surface", "bed", "cancelled", "diverged", "step_too_small", "too_many_steps", "refused", "crashed"
]  # fmt: skip
Format = Literal["json", "csv", "parquet", "netcdf", "mat"]
Number = float | None
"""A number; null where it does not apply or is not finite."""
BATCH_SCHEMA = {
    "type": "object",
    "required": ["format", "version", "kind"],
    "properties": {
        "format": {"const": "glider-batch"},
        "version": {"const": 1},
        "kind": {"enum": ["simulate", "sweep", "monte_carlo", "sensitivity"]},
    },
    "description": "A batch document; /schemas/batch describes it whole.",
}


class JobProgress(Wire):
    """How far a job is."""

    cases: int = Field(description="All cases.")
    done: int = Field(description="Cases that are done, failed ones included.")
    failed: int = Field(description="Cases that failed.")
    chunks: int = Field(description="All chunks: cases are computed in chunks, and kept a whole chunk at a time.")
    chunks_done: int = Field(description="Chunks that are done.")
    rate: Number = Field(description="Cases a second, lately; null where none is computed.")
    seconds_left: Number = Field(description="Seconds until the end at this rate; null where it is not known.")


class JobDesign(Wire):
    """The design that a job varies."""

    name: str = Field(description="Its name.")
    identity: str = Field(description="SHA-256 of its canonical JSON.")
    id: str | None = Field(description="Identifier of the stored design; null where the job brought its own.")
    revision: int | None = Field(description="Its revision; null where the job brought its own.")


class JobParameter(Wire):
    """What varies from case to case."""

    name: str = Field(description="Its name, and that of its column.")
    unit: str = Field(description="Its unit.")
    pointer: str = Field(description="JSON Pointer to its field in the design.")


class JobMetric(Wire):
    """What is measured in each case."""

    name: str = Field(description="Its name, and that of its column.")
    unit: str = Field(description="Its unit.")
    meaning: str = Field(description="What it is, in words.")


class JobEngine(Wire):
    """What computed a job: where all of it is the same, so is every bit of the numbers."""

    version: str = Field(description="Version of the program.")
    kernel: str = Field(description="Hash of the kernel's sources.")
    processors: list[str] = Field(description="Kinds of processors that have computed it.")


class FailureGroup(Wire):
    """Cases that failed for the same reason."""

    reason: str = Field(description="The reason, numbers left out.")
    count: int = Field(description="How many cases.")
    case: int = Field(description="The first of them.")


class JobRecord(Wire):
    """A job as it is now."""

    id: str = Field(description="Identifier, for /jobs/{id}.")
    name: str = Field(description="Its name.")
    kind: Kind = Field(description="What kind of job.")
    state: State = Field(description="cancelled, succeeded, partial and failed are the last; partial has failed cases.")
    reason: str | None = Field(description="Why it is in this state, where that needs words.")
    created: datetime = Field(description="When it was submitted.")
    started: datetime | None = Field(description="When its first chunk was sent; null before.")
    finished: datetime | None = Field(description="When it ended; null before.")
    progress: JobProgress = Field(description="How far it is.")
    design: JobDesign = Field(description="The design that it varies.")
    parameters: list[JobParameter] = Field(description="What varies.")
    metrics: list[JobMetric] = Field(description="What is measured.")
    engine: JobEngine = Field(description="What computes it.")
    checksum: str = Field(description="SHA-256 of all that decides its numbers: equal for jobs with equal results.")
    failures: list[FailureGroup] = Field(description="Failed cases by reason, the most frequent first; at most 50.")
    stopped_early: bool = Field(description="Whether it ended before all cases were done, since enough was known.")
    trajectories: Literal["none", "all", "some"] = Field(description="Of which cases trajectories are kept.")
    warnings: list[str] = Field(description="What may surprise: a parameter that changes nothing.")

    @property
    def over(self) -> bool:
        """Whether nothing more happens to it by itself."""
        return self.state in ("cancelled", "succeeded", "partial", "failed")


class JobPage(Wire):
    """Some of the jobs."""

    items: list[JobRecord] = Field(description="The newest first.")
    next: str | None = Field(description="Cursor of the next page; null at the end.")


class CaseItem(Wire):
    """One case: what it was given, how it ended, what it measured."""

    case: int = Field(description="Its number, from 0.")
    status: Status = Field(description="How it ended: completed, surface and bed are fine, all others failures.")
    reason: str | None = Field(description="Why it failed; null where it did not.")
    parameters: dict[str, Any] = Field(description="Values of the parameters, by name.")
    metrics: dict[str, Number] = Field(description="Values of the metrics, by name; null where one does not apply.")


class CasePage(Wire):
    """Some of a job's cases: those that are done by now."""

    items: list[CaseItem] = Field(description="In the order of their numbers.")
    next: str | None = Field(description="Cursor of the next page; null at the end.")


class CaseTable(Wire):
    """The whole case table, column by column."""

    columns: dict[str, list[Any]] = Field(description="case, status, reason, and one a parameter and one a metric.")
    units: dict[str, str] = Field(description="Unit of each column that has one.")


class Trajectory(Preview):
    """One case over time. Where it was kept, its events and statistics are not known, and empty."""

    case: int = Field(description="The case's number.")
    kept: bool = Field(description="Whether it comes from the job's files; else the case was simulated again.")


class MeanInterval(Wire):
    """Where the mean lies."""

    of: Literal["mean"] = Field(description="What lies there.")
    low: float = Field(description="Low end.")
    high: float = Field(description="High end.")
    confidence: float = Field(description="Probability with which such an interval holds it.")
    method: str = Field(description="How it was found.")


class MetricSummary(Wire):
    """Statistics of one metric over the cases that are fine."""

    unit: str = Field(description="Unit of all numbers here.")
    meaning: str = Field(description="What it is, in words.")
    count: int = Field(description="Cases with a value.")
    missing: int = Field(description="Cases without: failed, or the metric does not apply.")
    mean: Number = Field(description="Mean.")
    sd: Number = Field(description="Standard deviation.")
    least: Number = Field(description="Smallest value.")
    most: Number = Field(description="Largest value.")
    percentiles: dict[str, Number] = Field(description="By percentage: 5, 25, 50, 75, 95.")
    interval: MeanInterval | None = Field(
        description="Where the mean lies; null with fewer than two values, and where cases are no independent draws."
    )


class CorrelationItem(Wire):
    """How a parameter and a metric go together."""

    parameter: str = Field(description="Name of the parameter.")
    metric: str = Field(description="Name of the metric.")
    count: int = Field(description="Cases with both.")
    pearson: Number = Field(description="Correlation of the values; null where one of them is always the same.")
    spearman: Number = Field(description="Correlation of their ranks.")


class IndexValue(Wire):
    """An index and how well it is known."""

    value: Number = Field(description="Estimate.")
    half_width: Number = Field(description="Half the width of its interval, of 95 % confidence.")


class PairIndex(IndexValue):
    """An index of two parameters together."""

    between: list[str] = Field(description="Names of the two.")


class MetricIndices(Wire):
    """How much each parameter matters to a metric: indices of Sobol's or of Morris's method."""

    method: Literal["sobol", "morris"] = Field(description="By which method.")
    reason: str | None = Field(description="Why there are none; null where there are.")
    first: dict[str, IndexValue] | None = Field(default=None, description="Sobol: share of the variance by itself.")
    total: dict[str, IndexValue] | None = Field(default=None, description="Sobol: share with all interactions.")
    interaction: list[PairIndex] | None = Field(default=None, description="Sobol, second order: share of pairs.")
    mu: dict[str, Number] | None = Field(default=None, description="Morris: mean effect over the whole range.")
    mu_star: dict[str, IndexValue] | None = Field(default=None, description="Morris: mean size of the effect.")
    sigma: dict[str, Number] | None = Field(default=None, description="Morris: spread of the effect.")


class JobSummary(Wire):
    """What came out, in few numbers; of the cases that are done by now."""

    cases: int = Field(description="Cases that are done.")
    failed: int = Field(description="Those of them that failed: their metrics are left out.")
    sampled: int | None = Field(
        description="Cases, drawn at random, that percentiles and correlations are of; null where that is all."
    )
    metrics: dict[str, MetricSummary] = Field(description="Statistics by metric.")
    correlations: list[CorrelationItem] = Field(description="Each parameter that is a number with each metric.")
    failures: list[FailureGroup] = Field(description="Failed cases by reason, the most frequent first; at most 50.")
    indices: dict[str, MetricIndices] | None = Field(description="By metric; null where this is no sensitivity study.")
