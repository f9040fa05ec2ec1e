"""Owns how the progress of a batch is shown: a bar on a terminal, else a line now and then; both on standard error."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import timedelta

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn

from server.store.job_records import Job

LINE_EVERY = 5.0
"""Seconds from line to line where there is no terminal."""
Show = Callable[[Job], None]


def words(job: Job) -> str:
    """Return how far a job is: done, failed, rate, time left."""
    parts = [f"{job.done} of {job.counted} cases"]
    if job.failed:
        parts.append(f"{job.failed} failed")
    if job.rate:
        left = timedelta(seconds=round((job.counted - job.done) / job.rate))
        parts += [f"{job.rate:.3g} cases/s", f"{left} left"]
    return ", ".join(parts)


@contextmanager
def progress() -> Iterator[Show]:
    """Yield what shows a job as it is now."""
    if sys.stderr.isatty():
        with _bar() as show:
            yield show
    else:
        yield _lines()


@contextmanager
def _bar() -> Iterator[Show]:
    columns = SpinnerColumn(), BarColumn(), TextColumn("{task.description}", markup=False)
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=None)
        yield lambda job: bar.update(task, description=words(job), total=job.counted, completed=job.done)


def _lines() -> Show:
    told, at = "", 0.0

    def show(job: Job) -> None:
        nonlocal told, at
        if time.monotonic() - at >= LINE_EVERY and (said := words(job)) != told:
            told, at = said, time.monotonic()
            print(said, file=sys.stderr, flush=True)

    return show
