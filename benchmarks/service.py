"""What the service costs beside the physics, and how it bears many at once: `python -m benchmarks.service`.

A studio in a process of its own on this machine, its store full: 10,000 designs and 1,000 jobs. First one preview
beside the bare kernel call; then each list, search and page by one client; then fifty clients without a pause, of whose
requests three in five are previews of a thousand points, one is a list, one a single design, job or preset; then two
hundred listeners of one running job. The clients share the machine's cores with the server.
"""

from __future__ import annotations

import asyncio
import json
import random
import tempfile
import time
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import psutil

from benchmarks.bare import recorded_run, with_duration, with_solver
from benchmarks.load import Asked, Connection, asked
from benchmarks.program import Program, running_program
from benchmarks.store import DESIGNS, JOBS, batch_document, fill, fill_jobs
from benchmarks.timing import interleaved_medians
from models.assemble import assemble
from models.design import Design
from models.presets import load_preset
from models.simulate import Control
from server.answers import series_answer
from server.body import loads
from server.documents import read_request
from server.preview import as_mapping, run_preview
from server.schemas import COLUMN_NAMES, PreviewRequest
from server.settings import Settings
from server.store.database import Database, sqlite_url
from server.store.designs import DesignStore
from server.store.jobs import JobStore
from server.store.listing import DesignQuery

API = "/api/v1"
POINTS = 1000
REPEATS = 100
CLIENTS, REQUESTS = 50, 40
LISTENERS, LISTEN_FOR, CASES = 200, 12.0, 100_000
OVERHEAD_GOAL, LIST_GOAL, SPREAD_GOAL = 4.0, 20.0, 5.0


def glide() -> Design:
    """Return a planar glide of which a thousand points are shown."""
    design = with_duration(load_preset("canete-dual-bellows"), 30.0)
    return with_solver(design, output_interval=30.0 / (POINTS - 1))


def report_overhead() -> None:
    """Print what a preview takes beside the kernel: parsing, checking, assembling, choosing samples, serialising."""
    design = glide()
    settings, body = Settings(host="127.0.0.1", token=None), design.to_json().encode()
    bare = recorded_run(assemble(design))

    def preview() -> object:
        read, _, _ = read_request(loads(body, max_values=settings.max_body_values), PreviewRequest, settings.limits)
        return series_answer(as_mapping(run_preview(read, settings, Control()), COLUMN_NAMES, POINTS))

    times = interleaved_medians({"bare": bare, "preview": preview}, rounds=50)
    over = 1e3 * (times["preview"] - times["bare"])
    took = ", ".join(f"{name} {1e3 * seconds:.2f} ms" for name, seconds in times.items())
    print(f"preview of {POINTS} points: {took}; over the kernel {over:.2f} ms   to reach: below {OVERHEAD_GOAL:g} ms")


def questions(database: Database) -> list[Asked]:
    """Return the lists, searches and pages of a full store."""
    store, jobs = DesignStore(database), JobStore(database)
    listed = store.find(DesignQuery(limit=1)).items[0]
    middle = store.find(DesignQuery(order="name", limit=200)).next
    some = jobs.page(limit=JOBS // 2)[-1]
    paths = {
        "list designs": "/designs",
        "page of designs": f"/designs?sort=name&cursor={middle}",
        "search designs": "/designs?search=ati",
        "designs by tag": f"/designs?tag={listed.tags[0]}",
        "get a design": f"/designs/{listed.id}",
        "list jobs": "/jobs",
        "jobs by state": "/jobs?state=partial",
        "search jobs": "/jobs?search=wings",
        "get a job": f"/jobs/{some.id}",
    }
    return [asked(name, "GET", API + path) for name, path in paths.items()]


async def one_at_a_time(program: Program, requests: Sequence[Asked]) -> dict[str, list[float]]:
    """Return the latencies of each request, ms, asked in turn by one client."""
    took = defaultdict(list)
    async with Connection(program.url) as connection:
        for _ in range(REPEATS):
            for request in requests:
                began = time.perf_counter()
                status, _ = await connection.ask(request)
                took[request.name].append(1e3 * (time.perf_counter() - began))
                assert status == 200, (request.name, status)
    return took


def report_lists(program: Program, requests: Sequence[Asked]) -> None:
    """Print how long lists, searches and pages take through HTTP."""
    print(f"{DESIGNS} designs and {JOBS} jobs, by one client   to reach: {LIST_GOAL:g} ms at p95")
    for name, values in asyncio.run(one_at_a_time(program, requests)).items():
        p50, p95 = np.percentile(values, [50, 95])
        print(f"  {name:<18} p50 {p50:6.2f} ms   p95 {p95:6.2f} ms   {'' if p95 < LIST_GOAL else 'above the target'}")


async def client(program: Program, mix: Sequence[Asked], dice: random.Random) -> list[tuple[str, float, int]]:
    """Ask one request after the other; return the kind, the latency (ms) and the status of each."""
    told = []
    async with Connection(program.url) as connection:
        for request in dice.choices(mix, k=REQUESTS):
            began = time.perf_counter()
            status, _ = await connection.ask(request)
            told.append((request.name, 1e3 * (time.perf_counter() - began), status))
    return told


async def many(program: Program, mix: Sequence[Asked]) -> list[tuple[str, float, int]]:
    """Return what all clients saw who ask at once."""
    clients = [client(program, mix, random.Random(k)) for k in range(CLIENTS)]
    return [told for one in await asyncio.gather(*clients) for told in one]


def mixed(requests: Sequence[Asked]) -> list[Asked]:
    """Return fifteen requests: nine previews, three lists, three of single things."""
    known = {request.name: request.content for request in requests}
    body = {"design": glide().model_dump(mode="json"), "options": {"max_points": POINTS}}
    preview = asked("preview", "POST", f"{API}/simulations:preview", body)
    lists = [Asked("list", known[name]) for name in ("list designs", "search designs", "list jobs")]
    single = [Asked("get", known[name]) for name in ("get a design", "get a job")]
    return [preview] * 9 + lists + single + [asked("get", "GET", f"{API}/presets/seawing-spiral")]


def report_many(program: Program, requests: Sequence[Asked]) -> None:
    """Print latencies with many clients at once."""
    mix = mixed(requests)
    asyncio.run(one_at_a_time(program, mix[:1]))  # the first one loads what it needs
    began = time.perf_counter()
    told = asyncio.run(many(program, mix))
    took = time.perf_counter() - began
    wrong = sum(status != 200 for _, _, status in told)
    print(f"{CLIENTS} clients at once: {len(told) / took:.0f} requests a second, {wrong} errors   to reach: none")
    for kind in ("all", "preview", "list", "get"):
        p50, p99 = np.percentile([ms for name, ms, _ in told if kind in ("all", name)], [50, 99])
        goal = f"   to reach: within {SPREAD_GOAL:g}x" if kind == "all" else ""
        print(f"  {kind:<8} p50 {p50:6.1f} ms   p99 {p99:6.1f} ms   {p99 / p50:5.2f}x{goal}")


async def watch(program: Program, jobs: JobStore) -> None:
    """Print how 200 listeners of one running job hear of it: how late, whether to the end, and what it costs."""
    process = psutil.Process(program.pid)
    _, body = await once(program, asked("", "POST", f"{API}/jobs?fresh=true", batch_document(CASES)))
    job_id = json.loads(body)["id"]
    while jobs.get(job_id).chunks_done < 1:
        await asyncio.sleep(0.05)
    alone = await load_of(process, LISTEN_FOR / 2)
    changed: dict[int, float] = {}
    listeners = [asyncio.create_task(listen(program, job_id)) for _ in range(LISTENERS)]
    noting = asyncio.create_task(note_changes(jobs, job_id, changed))
    listened = await load_of(process, LISTEN_FOR)
    await once(program, asked("", "POST", f"{API}/jobs/{job_id}:cancel"))
    heard = await asyncio.gather(*listeners)
    await noting
    first = min(changed)
    late = [1e3 * (at - changed[n]) for events in heard for at, n, _ in events if n in changed and n > first]
    ended = sum(events[-1][2] == "cancelled" for events in heard)
    p50, p95 = np.percentile(late, [50, 95])
    told = f"{len(late) / LISTENERS:.0f} updates each, p50 {p50:.0f} ms, p95 {p95:.0f} ms after the change"
    print(f"{LISTENERS} listeners of a running job: {told}; {ended} heard its end   to reach: all")
    print(f"  the server takes {100 * listened:.0f} % of a core with them, {100 * alone:.0f} % without")


async def once(program: Program, request: Asked) -> tuple[int, bytes]:
    """Return the answer to one request on a connection of its own."""
    async with Connection(program.url) as connection:
        status, body = await connection.ask(request)
    assert status < 400, body
    return status, body


async def listen(program: Program, job_id: str) -> list[tuple[float, int, str]]:
    """Return when each event came, its id, and the state that it told."""
    async with Connection(program.url) as connection:
        path = f"{API}/jobs/{job_id}/events"
        return [(at, number, record["state"]) async for at, number, record in connection.events(path)]


async def note_changes(jobs: JobStore, job_id: str, changed: dict[int, float]) -> None:
    """Note when each change of a job can be seen in its store, until it is over."""
    while True:
        changed.setdefault(jobs.sequences([job_id])[job_id], time.perf_counter())
        if jobs.get(job_id).over:
            return
        await asyncio.sleep(0.005)


async def load_of(process: psutil.Process, seconds: float) -> float:
    """Return how much of a core a process takes over some time, without its workers."""
    before, began = process.cpu_times(), time.perf_counter()
    await asyncio.sleep(seconds)
    after = process.cpu_times()
    return (after.user + after.system - before.user - before.system) / (time.perf_counter() - began)


def main() -> None:
    """Measure and print."""
    report_overhead()
    with tempfile.TemporaryDirectory() as folder:
        database = Database(sqlite_url(Path(folder) / "studio.sqlite"))
        fill(DesignStore(database))
        fill_jobs(database)
        requests = questions(database)
        with running_program(data=Path(folder)) as program:
            report_lists(program, requests)
            report_many(program, requests)
            asyncio.run(watch(program, JobStore(database)))
        database.close()


if __name__ == "__main__":
    main()
