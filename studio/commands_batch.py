"""Owns the command that runs a batch document without a server: the same jobs, their store and results in a folder."""

from __future__ import annotations

import argparse
import json
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

from pydantic import ValidationError

from models.problems import DesignError
from models.warm import LANES_DONE
from server.jobs.engines import Engine, EngineLostError, SerialEngine, make_engine
from server.jobs.files import DiskFullError
from server.jobs.matlab import TooLargeError
from server.jobs.opening import finder
from server.jobs.plan import Plan, make_plan
from server.jobs.results import LostResultsError
from server.jobs.service import Jobs
from server.jobs.spec import checksum, parse_spec
from server.jobs.submission import engine_version, no_store
from server.settings import Settings, unknown_settings
from server.store.database import Database, sqlite_url
from server.store.designs import DesignStore
from server.store.errors import StoreError
from server.store.job_records import Job
from studio.batch_arguments import example
from studio.batch_document import read_document
from studio.batch_progress import progress, words
from studio.batch_results import print_summary, write_results
from studio.commands import complain
from studio.exit_codes import DONE, MISUSED, PARTIAL, REFUSED, STOPPED, UNUSABLE

LOOK_EVERY = 0.2
"""Seconds from look to look at the job."""
FIRST_ROWS = 5
DATABASE = "studio.sqlite"
"""As in a server's data folder: `serve --data FOLDER` shows the jobs."""
UNUSABLE_ERRORS = (StoreError, DiskFullError, LostResultsError, TooLargeError)


def batch(options: argparse.Namespace) -> int:
    """Run a batch document, or print an example of one; return the exit code."""
    if options.example is not None:
        print(example(options.example), end="")
        return DONE
    if options.spec is None:
        complain("batch", "SPEC is missing: name a batch document, or see --example")
        return MISUSED
    folder = options.output or Path(options.spec.stem)
    if options.output is None and (str(options.spec) == "-" or not options.spec.suffix):
        complain("batch", "name the FOLDER of the results by -o")
        return MISUSED
    try:
        document, settings = read_document(options.spec), _settings(options, folder)
        return UNUSABLE if settings is None else _batch(document, settings, options)
    except BrokenPipeError:  # whoever reads what is printed
        raise
    except DesignError as error:
        complain(options.spec, error.problems)
        return REFUSED
    except OSError as error:
        complain(error.filename or folder, error.strerror or str(error))
    except EngineLostError as error:
        complain("--scheduler", str(error))
    except UNUSABLE_ERRORS as error:
        complain(folder, str(error))
    return UNUSABLE


def _settings(options: argparse.Namespace, folder: Path) -> Settings | None:
    """Return the settings of jobs: those of the environment, and above them the options."""
    for warning in unknown_settings(os.environ):
        complain("environment", f"warning: {warning}")
    given: dict[str, Any] = {"data": folder, "host": "127.0.0.1"}
    if options.workers is not None:
        given |= {"workers": options.workers or None, "scheduler": None}
    if options.scheduler is not None:
        given["scheduler"] = options.scheduler
    try:
        settings = Settings(**given)
    except ValidationError as error:
        for item in error.errors(include_url=False):
            name = "_".join(str(part).upper() for part in item["loc"])
            complain(f"GLIDER_STUDIO_{name}", item["msg"].removeprefix("Value error, "))
        return None
    if settings.database_url is not None:
        unused = "GLIDER_STUDIO_DATABASE_URL is not used here"
        complain("environment", f"warning: {unused}: the jobs of a batch are kept in {folder / DATABASE}")
    return settings


def _batch(document: Any, settings: Settings, options: argparse.Namespace) -> int:
    if options.dry_run:
        return _dry_run(document, settings)
    settings.data.mkdir(parents=True, exist_ok=True)
    store = DesignStore(Database(sqlite_url(settings.data / DATABASE)))
    engine: Engine = SerialEngine() if options.workers == 0 else make_engine(
        settings.scheduler, workers=settings.workers
    )  # fmt: skip
    jobs = Jobs(
        store.database, engine, settings.data / "jobs", find_design=finder(store), limits=settings.limits,
        max_cases=settings.max_cases, reserve=settings.min_free_mib * 2**20,
    )  # fmt: skip
    try:
        if not LANES_DONE.exists():
            _tell("preparing the physics: the first start on a machine compiles it, which takes a while")
        job = _chosen(jobs, document, options)
        print(f"job         {job.id}: {job.name}", flush=True)
        return _finish(jobs, job if job.over else _compute(jobs, job), options, settings.data)
    finally:
        engine.stop()
        store.database.close()


def _dry_run(document: Any, settings: Settings) -> int:
    spec = parse_spec(document)
    database = Database(sqlite_url(settings.data / DATABASE)) if (settings.data / DATABASE).exists() else None
    find = no_store if database is None else finder(DesignStore(database))
    design = spec.design or find(spec.design_id or "", spec.revision)[0]
    _print_plan(make_plan(spec, design, max_cases=settings.max_cases))
    return DONE


def _print_plan(plan: Plan) -> None:
    print(f"design      {plan.design.name}")
    print(f"cases       {plan.count}")
    for parameter in plan.parameters:
        print(f"parameter   {parameter.name}{f' [{parameter.unit}]' if parameter.unit else ''}: {parameter.pointer}")
    for metric in plan.metrics:
        print(f"metric      {metric.name} [{metric.unit}]: {metric.meaning}")
    for case, row in enumerate(plan.rows(0, min(FIRST_ROWS, plan.count))):
        print(f"case {case:<6} {', '.join(json.dumps(value) for value in row)}")


def _chosen(jobs: Jobs, document: Any, options: argparse.Namespace) -> Job:
    """Return the job to work on: an equal one of this folder, gone on with where it has stopped, else a new one."""
    earlier = None if options.fresh else _earlier(jobs, document)
    if earlier is None:
        jobs.manager.engine.check()
        return jobs.submit(document, fresh=True)[0]
    if earlier.state == "paused":
        return jobs.resume(earlier.id)
    if earlier.state == "cancelled" or (options.retry and earlier.over and earlier.failed):
        return jobs.retry(earlier.id)
    if earlier.over:
        _tell("computed before: --fresh computes it anew" + (", --retry its failed cases" if earlier.failed else ""))
    return earlier


def _earlier(jobs: Jobs, document: Any) -> Job | None:
    """Return the newest job with the same checksum, whatever became of it."""
    spec = parse_spec(document)
    if spec.design is None:
        return None  # `submit` finds the design, and whether it is there
    wanted, before = checksum(spec, spec.design, engine_version()), None
    while page := jobs.store.page(before=before, limit=200):
        for job in page:
            if job.checksum == wanted:
                return jobs.store.get(job.id)
        before = page[-1].created, page[-1].id
    return None


def _compute(jobs: Jobs, job: Job) -> Job:
    """Work until the job is over or pauses; an interrupt keeps what is done."""
    jobs.manager.engine.check()
    with progress() as show, _asked_to_stop() as asked:
        try:
            with _interrupts_come_here():
                jobs.start()
            while not ((now := jobs.store.get(job.id)).over or now.state == "paused"):
                if asked():
                    _tell("stopping, what is being computed is kept; Ctrl-C again leaves at once")
                    break
                show(now)
                time.sleep(LOOK_EVERY)
        finally:
            jobs.stop()
    return jobs.store.get(job.id)


@contextmanager
def _interrupts_come_here() -> Iterator[None]:
    """Have threads that begin meanwhile, and the processes that they start, not see Ctrl-C: it is this one's."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _asked_to_stop() -> Iterator[Callable[[], bool]]:
    """Yield whether Ctrl-C came, or the word to end, as from a queue whose time is up; the next one is an interrupt.

    The first is no exception: one that is raised wherever the program happens to be may be lost there.
    """
    heard: list[int] = []

    def hear(number: int, frame: FrameType | None) -> None:
        if heard:
            signal.default_int_handler(number, frame)
        heard.append(number)

    if threading.current_thread() is not threading.main_thread():  # only that one may say what a signal does
        yield lambda: False
        return
    before = {number: signal.signal(number, hear) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield lambda: bool(heard)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _finish(jobs: Jobs, job: Job, options: argparse.Namespace, folder: Path) -> int:
    """Tell how the job ended and write its results, if it is over."""
    print(f"cases       {words(job)}")
    for warning in jobs.record(job)["warnings"]:
        complain(options.spec, f"warning: {warning}")
    for failure in jobs.store.failures([job.id])[job.id]:
        complain(options.spec, f"{failure.count} failed, the first of them case {failure.case}: {failure.reason}")
    if job.reason is not None:
        print(f"{job.state:<11} {job.reason}")
    if job.over:
        summary = write_results(jobs, job, folder, options.format or ["csv"])
        print_summary(summary)
    if not job.over or job.state == "cancelled":
        state = "stopped" if not job.over and job.state != "paused" else job.state
        complain(options.spec, f"{state}: what is done is kept, and the same command goes on")
    return {"succeeded": DONE, "partial": PARTIAL}.get(job.state, STOPPED)


def _tell(message: str) -> None:
    print(message, file=sys.stderr, flush=True)
