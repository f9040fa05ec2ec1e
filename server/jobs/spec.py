"""Owns the batch document: one JSON file that says which design runs, what varies, and what is measured and kept."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator
from functools import cache
from typing import Annotated, Any, Literal, Self

import rfc8785
from pydantic import Discriminator, Field, Tag, TypeAdapter, ValidationError, field_validator, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from models.design import Design, parse_design
from models.fields import LARGEST_WHOLE, Description, Switch, text
from models.metric_requests import MetricRequest
from models.plain_words import plainly
from models.problems import DesignError, Problem, echo, pointer_to
from server.jobs.parameters import LARGEST_SEED, Correlation, Drawn, Levels, Parameter, Range, number

FORMAT = "glider-batch"
VERSION = 1
KINDS = ("simulate", "sweep", "monte_carlo", "sensitivity")
WORDS = ("name", "notes", "design", "design_id", "revision")
"""Fields that decide no number, or whose content the checksum takes from the design itself."""

MOST_PARAMETERS = 1000
MOST_ROWS_TOLD = 20
"""Of rows that have too many or too few values, how many are told."""
Count = Annotated[int, Field(strict=True, ge=1, le=LARGEST_WHOLE)]
Case = Annotated[int, Field(strict=True, ge=0, le=LARGEST_WHOLE)]
Kept = Annotated[
    Annotated[Literal["none", "all"], Tag("word")] | Annotated[tuple[Case, ...], Tag("cases")],
    Discriminator(lambda given: "word" if isinstance(given, str) else "cases"),
]
"""Cases that are kept: none, all, or those listed."""
Statistic = Literal["mean", "median", "sd", "p5", "p25", "p75", "p95"]


def _require_power_of_two(count: int, what: str) -> int:
    if count & (count - 1):
        below = 1 << (count.bit_length() - 1)
        raise ValueError(f"{what} {count} is no power of 2, which Sobol points need: use {below} or {2 * below}")
    return count


class FullFactorial(Description):
    """Every combination of the levels; the last parameter changes fastest."""

    kind: Literal["full_factorial"] = text("Which sweep this is: every combination.")
    parameters: tuple[Levels, ...] = text("What varies.", min_length=1, max_length=MOST_PARAMETERS)


class LatinHypercube(Description):
    """Random points, exactly one in each of `count` slices of every parameter."""

    kind: Literal["latin_hypercube"] = text("Which sweep this is: a Latin hypercube.")
    parameters: tuple[Range, ...] = text("What varies.", min_length=1, max_length=MOST_PARAMETERS)
    count: Count = text("How many cases.")


class SobolPoints(Description):
    """Points of low discrepancy, scrambled by the seed."""

    kind: Literal["sobol"] = text("Which sweep this is: Sobol points.")
    parameters: tuple[Range, ...] = text("What varies.", min_length=1, max_length=MOST_PARAMETERS)
    count: Annotated[int, Field(strict=True, ge=1, le=2**30)] = text("How many cases: a power of 2.")

    @field_validator("count")
    @classmethod
    def _power_of_two(cls, count: int) -> int:
        return _require_power_of_two(count, "count")


class Cases(Description):
    """Cases listed one by one."""

    kind: Literal["cases"] = text("Which sweep this is: listed cases.")
    parameters: tuple[Parameter, ...] = text("What varies.", min_length=1, max_length=MOST_PARAMETERS)
    rows: tuple[tuple[Any, ...], ...] = text("A row for each case, a value for each parameter.", min_length=1)

    @model_validator(mode="after")
    def _rows_are_full(self) -> Self:
        wanted = len(self.parameters)
        wrong = [(k, row) for k, row in enumerate(self.rows) if len(row) != wanted]
        if wrong:
            lines = [_row_error(k, row, wanted) for k, row in wrong[:MOST_ROWS_TOLD]]
            raise ValidationError.from_exception_data(type(self).__name__, lines)
        return self


def _row_error(k: int, row: tuple[Any, ...], wanted: int) -> InitErrorDetails:
    """Return what is wrong with the length of row `k`, at the first value that is missing or one too many."""
    message = f"row {k + 1} has {len(row)} values for {wanted} parameters: give one for each"
    kind = PydanticCustomError("value_error", "{told}", {"told": message, "max_length": wanted})
    return InitErrorDetails(type=kind, loc=("rows", k, min(len(row), wanted)), input=row)


class SobolIndices(Description):
    """Shares of the variance by Saltelli's scheme."""

    kind: Literal["sobol"] = text("Which method this is: Sobol indices.")
    base: Annotated[int, Field(strict=True, ge=8, le=2**30)] = text(
        "Base points, a power of 2; n parameters take n + 2 times as many cases, 2 n + 2 with second order."
    )
    second_order: Switch = text("Whether interactions of pairs are found too.", default=False)

    @field_validator("base")
    @classmethod
    def _power_of_two(cls, base: int) -> int:
        return _require_power_of_two(base, "base")


class MorrisEffects(Description):
    """Elementary effects along random trajectories on a grid: a cheap screening."""

    kind: Literal["morris"] = text("Which method this is: Morris's elementary effects.")
    trajectories: Annotated[int, Field(strict=True, ge=2, le=10**6)] = text(
        "How many; n parameters take n + 1 cases for each."
    )
    levels: Annotated[int, Field(strict=True, ge=2, le=1000, multiple_of=2)] = text("Levels of the grid.", default=4)


class Stop(Description):
    """When to stop before all cases are done: as soon as a statistic is known well enough.

    The interval is looked at after every so many cases, in their order, whoever computed them.
    """

    metric: str = text("Name of the metric.", min_length=1)
    statistic: Statistic = text("Which statistic of it; p5 is the 5th percentile.", default="mean")
    width: float = number(
        "Wanted width of its confidence interval, from end to end, in the metric's unit.",
        unit="that of the metric",
        gt=0.0,
    )
    confidence: float = number("Confidence of that interval.", unit="1", ge=0.5, le=0.9999, default=0.95)
    least: Annotated[int, Field(strict=True, ge=2)] = text("Values that are needed at least.", default=100)
    every: Annotated[int, Field(strict=True, ge=1)] = text("Cases from look to look.", default=100)


class BatchDocument(Description):
    """What all batch documents say."""

    format: Literal["glider-batch"] = text("Says that this is a batch document.")
    version: Literal[1] = text("Version of the document's format.")
    kind: str = text("What kind of job.")
    name: str = text("Name of the job.", default="", max_length=200, pattern=r"^[^\x00-\x1f\x7f]*$")
    notes: str = text("What it is for.", default="", max_length=20_000)
    design: Design | None = text("The design that varies; or give design_id.", default=None)
    design_id: str | None = text("A stored design that varies.", default=None, min_length=1, max_length=200)
    revision: Annotated[int, Field(strict=True, ge=1)] | None = text(
        "Revision of the stored design; its newest by default.", default=None
    )
    metrics: tuple[MetricRequest, ...] | None = text(
        "What is measured in each case; by default what suits the design's model.", default=None
    )
    trajectories: Kept = text("Of which cases the whole trajectory is kept: none, all, or listed ones.", default="none")
    seed: Annotated[int, Field(strict=True, ge=0, le=LARGEST_SEED)] = text(
        "Seed of everything random: the same seed gives the same cases.", default=0
    )

    @model_validator(mode="after")
    def _one_design(self) -> Self:
        if (self.design is None) == (self.design_id is None):
            what = "neither is" if self.design is None else "both are"
            raise ValueError(f"give exactly one of design and design_id: {what} given")
        if self.revision is not None and self.design_id is None:
            raise ValueError("revision belongs to design_id, which is not given: leave it out")
        return self

    def to_json(self) -> str:
        """Return the document as indented JSON, ready for a file."""
        return json.dumps(self.model_dump(mode="json"), indent=1, ensure_ascii=False) + "\n"


class Simulate(BatchDocument):
    """One glide, as it stands in the design."""

    kind: Literal["simulate"] = text("Which job this is: one glide.")
    trajectories: Kept = text("Of which cases the whole trajectory is kept: none, all, or listed ones.", default="all")


class Sweep(BatchDocument):
    """Cases laid out by a plan."""

    kind: Literal["sweep"] = text("Which job this is: a sweep.")
    method: Annotated[FullFactorial | LatinHypercube | SobolPoints | Cases, Field(discriminator="kind")] = text(
        "How the cases are laid out."
    )


class MonteCarlo(BatchDocument):
    """Cases drawn at random."""

    kind: Literal["monte_carlo"] = text("Which job this is: cases drawn at random.")
    parameters: tuple[Drawn, ...] = text("What varies.", min_length=1, max_length=MOST_PARAMETERS)
    correlations: tuple[Correlation, ...] = text("Which go together; others are independent.", default=())
    count: Count = text("How many cases, at most.")
    stop: Stop | None = text("When to stop before.", default=None)


class Sensitivity(BatchDocument):
    """Which parameters matter."""

    kind: Literal["sensitivity"] = text("Which job this is: a sensitivity study.")
    method: Annotated[SobolIndices | MorrisEffects, Field(discriminator="kind")] = text("By which method.")
    parameters: tuple[Range, ...] = text("What varies.", min_length=1, max_length=MOST_PARAMETERS)


JobSpec = Annotated[Simulate | Sweep | MonteCarlo | Sensitivity, Field(discriminator="kind")]
_ADAPTER: TypeAdapter[Simulate | Sweep | MonteCarlo | Sensitivity] = TypeAdapter(JobSpec)


def parse_spec(document: Any) -> JobSpec:
    """Turn a decoded JSON document into a batch document.

    Raises
    ------
    DesignError
        With a pointer, the bound and a hint for everything that is wrong with the document by itself, its design
        included; `make_plan` checks it against the design.

    """
    if not isinstance(document, dict):
        raise DesignError([Problem("", f"a batch document is a JSON object, not {type(document).__name__}")])
    _check_header(document)
    problems = list(_odd_numbers(document))
    if problems:
        raise DesignError(problems)
    document = dict(document)
    if isinstance(document.get("design"), str):
        hint = "give the document itself, or design_id; names of presets and files are for glider-studio batch"
        raise DesignError([Problem("/design", f"{echo(document['design'])} is no design document", hint=hint)])
    if document.get("design") is not None:
        try:
            document["design"] = parse_design(document["design"])
        except DesignError as error:
            problems = [Problem(f"/design{p.pointer}", p.message, p.limit, p.hint) for p in error.problems]
            # the rest is checked as if there were a design
            document |= {"design": None, "design_id": document.get("design_id") or "refused"}
    try:
        spec = _ADAPTER.validate_python(document)
    except ValidationError as error:
        raise DesignError([*problems, *_told(plainly(error, document, batch_schema()))]) from None
    if problems:
        raise DesignError(problems)
    return spec


def _told(problems: list[Problem]) -> Iterator[Problem]:
    """Leave out that a list is too short, where it is so only because entries of it were refused."""
    for problem in problems:
        within = any(other.pointer.startswith(f"{problem.pointer}/") for other in problems)
        if not (within and problem.message.startswith("there must be at least")):
            yield problem


def _check_header(document: dict[str, Any]) -> None:
    given, version = document.get("format"), document.get("version")
    if given != FORMAT:
        raise DesignError([Problem("/format", f"this is not a batch document: format is {echo(given)}", FORMAT)])
    if isinstance(version, bool):
        raise DesignError([Problem("/version", "the version is a number, not true or false", VERSION)])
    if type(version) is int and version > VERSION:
        message = f"the document has version {version}; this program reads versions up to {VERSION}"
        raise DesignError([Problem("/version", message, VERSION, "open it with a newer glider studio")])


def _odd_numbers(value: Any, *path: object) -> Iterator[Problem]:
    """Yield the numbers that JSON cannot carry from machine to machine: not finite, or whole ones from 2^53 on."""
    if isinstance(value, dict):
        for key, item in value.items():
            yield from _odd_numbers(item, *path, key)
    elif isinstance(value, list | tuple):
        for k, item in enumerate(value):
            yield from _odd_numbers(item, *path, k)
    elif isinstance(value, float) and not math.isfinite(value):
        yield Problem(pointer_to(*path), f"{value} is not a finite number", hint="give a finite number")
    elif isinstance(value, int) and abs(value) > LARGEST_WHOLE:
        message = "a whole number from 2^53 on is not the same on every machine"
        yield Problem(pointer_to(*path), message, LARGEST_WHOLE, "write it as a decimal number, or smaller")


def canonical(spec: JobSpec) -> bytes:
    """Return what decides a job's numbers as canonical JSON (RFC 8785); without its design, names and notes."""
    return rfc8785.dumps(spec.model_dump(mode="json", exclude=set(WORDS)))


def checksum(spec: JobSpec, design: Design, engine_version: str) -> str:
    """Return the SHA-256 of all that decides a job's numbers: two jobs with one checksum have the same results."""
    parts = [canonical(spec), design.identity.encode(), engine_version.encode()]
    return hashlib.sha256(b"\n".join(parts)).hexdigest()


@cache
def batch_schema() -> dict[str, Any]:
    """Return the JSON Schema of the batch document."""
    return _ADAPTER.json_schema() | {
        "title": "Batch document",
        "$schema": "https://json-schema.org/draft/2020-12/schema",
    }
