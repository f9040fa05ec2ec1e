"""Figures for Prometheus: each application's own, few series whatever is asked for, and guarded by the token."""

from __future__ import annotations

import asyncio

import httpx
import pytest
from fastapi.responses import StreamingResponse
from prometheus_client.core import GaugeMetricFamily
from prometheus_client.parser import text_string_to_metric_families

from server.app import create_app
from server.jobs.engines import DaskEngine
from server.settings import Settings
from server.store.errors import UnavailableError
from server.store.job_records import STATES
from server.telemetry import Telemetry
from tests.server.job_api_support import COMMAND, idle_api
from tests.server.job_support import listed, running, sweep
from tests.server.support import PREVIEW, VALIDATE, ask, local_app, preset

TOKEN = "a-token-of-some-length"
COUNT = "glider_studio_request_seconds_count"


def figures(app, **options):
    answer = ask("GET", "/metrics", app=app, **options)
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"].startswith("text/plain")
    return {
        (sample.name, *sorted(sample.labels.items())): sample.value
        for family in text_string_to_metric_families(answer.text)
        for sample in family.samples
    }


def counted(app):
    return {
        tuple(dict(labels)[name] for name in ("method", "route", "status")): value
        for (name, *labels), value in figures(app).items()
        if name == COUNT
    }


def test_requests_are_counted_by_template_method_and_status():
    app = local_app()
    for name in ("three-cell-glider", "canete-dual-bellows", "none"):
        ask("GET", f"/api/v1/presets/{name}", app=app)
    ask("POST", VALIDATE, preset(), app=app)
    ask("DELETE", VALIDATE, app=app)
    ask("GET", "/nowhere", app=app)
    ask("HEAD", "/api/v1/openapi.json", app=app)
    assert counted(app) == {
        ("GET", "/api/v1/presets/{preset_id}", "200"): 2,
        ("GET", "/api/v1/presets/{preset_id}", "404"): 1,
        ("POST", VALIDATE, "200"): 1,
        ("DELETE", VALIDATE, "405"): 1,
        ("GET", "(none)", "404"): 1,
        ("HEAD", "/api/v1/openapi.json", "200"): 1,
    }


def test_series_are_few_whatever_is_asked_for():
    app = local_app()
    for k in range(200):
        ask("GET", f"/api/v1/presets/{k}", app=app)
        ask("GET", f"/{k}", app=app)
        ask(f"METHOD{k}", "/api/v1/presets", app=app)
    assert len(counted(app)) == 3


def test_times_fall_into_the_histogram():
    app = local_app()
    ask("POST", PREVIEW, preset(), app=app)
    found = figures(app)
    labels = [("method", "POST"), ("route", PREVIEW), ("status", "200")]
    seconds = found[("glider_studio_request_seconds_sum", *labels)]
    assert 0.0 < seconds < 10.0
    for (name, *given), value in found.items():
        edge = dict(given).get("le")
        if name == "glider_studio_request_seconds_bucket" and dict(given)["route"] == PREVIEW:
            assert value == (1.0 if seconds <= float(edge) else 0.0)


def test_process_and_own_figures_are_there():
    app = local_app()

    class Jobs:
        def collect(self):
            yield GaugeMetricFamily("glider_studio_jobs", "Jobs.", value=3)

    app.state.telemetry.registry.register(Jobs())
    found = figures(app)
    assert found[("glider_studio_jobs",)] == 3
    assert found[("process_resident_memory_bytes",)] > 1e6
    assert found[("glider_studio_simulations_running",)] == 0
    assert found[("glider_studio_requests_in_progress",)] == 1, "this one"


def test_jobs_are_told_by_state_and_their_cases_are_counted(tmp_path):
    with idle_api(tmp_path) as api, running(api.jobs):
        for document in (sweep(12), sweep(3), listed(COMMAND, [0.0, 0.5, 1e-4])):
            api.submit(document)
        found = figures(api.app)
    states = {dict(labels)["state"]: value for (name, *labels), value in found.items() if name == "glider_studio_jobs"}
    assert set(states) == set(STATES)
    assert (states["succeeded"], states["partial"], sum(states.values())) == (2, 1, 3)
    assert found[("glider_studio_job_cases_total",)] == 12 + 3 + 3
    assert found[("glider_studio_job_cases_failed_total",)] == 1
    assert found[("glider_studio_job_chunks_in_flight",)] == 0
    assert found[("glider_studio_job_workers",)] == 1
    assert found[("glider_studio_job_listeners",)] == 0


def test_what_is_not_known_of_jobs_is_left_out(tmp_path, monkeypatch):
    with idle_api(tmp_path) as api:
        api.jobs.manager.engine = DaskEngine("tcp://127.0.0.1:9")
        found = figures(api.app)
        assert ("glider_studio_job_workers",) not in found, "nobody has asked the cluster yet"
        assert found[("glider_studio_jobs", ("state", "queued"))] == 0

        def fails():
            raise UnavailableError("the database does not answer")

        monkeypatch.setattr(api.jobs.store, "counts", fails)
        found = figures(api.app)
        assert found[("glider_studio_job_cases_total",)] == 0
        assert not any(name == "glider_studio_jobs" for name, *_ in found)


def test_applications_count_apart():
    first, second = Telemetry(), Telemetry()
    first.observe("GET", "/x", status=200, seconds=0.1)
    assert b'route="/x"' in first.exposition("")[0]
    assert b'route="/x"' not in second.exposition("")[0]


def test_a_stream_counts_with_the_time_to_its_first_byte(monkeypatch):
    app, now = local_app(), [0.0]
    monkeypatch.setattr("server.middleware.time.perf_counter", lambda: now[0])

    @app.get("/api/v1/stream")
    async def stream() -> StreamingResponse:
        async def events():
            yield "data: 1\n\n"
            now[0] = 60.0
            yield "data: 2\n\n"

        now[0] = 2.0
        return StreamingResponse(events(), media_type="text/event-stream")

    assert ask("GET", "/api/v1/stream", app=app).text == "data: 1\n\ndata: 2\n\n"
    labels = [("method", "GET"), ("route", "/api/v1/stream"), ("status", "200")]
    assert figures(app)[("glider_studio_request_seconds_sum", *labels)] == 2.0


@pytest.mark.parametrize(("is_open", "status"), [(False, 401), (True, 200)])
def test_figures_need_the_token_unless_they_are_open(is_open, status):
    app = create_app(Settings(host="0.0.0.0", token=TOKEN, metrics_open=is_open))
    assert ask("GET", "/metrics", app=app).status_code == status
    assert ask("GET", "/metrics", app=app, headers={"authorization": f"Bearer {TOKEN}"}).status_code == 200


def test_openmetrics_by_accept():
    answer = ask("GET", "/metrics", headers={"accept": "application/openmetrics-text; version=1.0.0"})
    assert answer.headers["content-type"].startswith("application/openmetrics-text")
    assert answer.text.rstrip().endswith("# EOF")


def test_a_preview_that_runs_is_seen():
    app = local_app()

    async def during() -> float:
        transport = httpx.ASGITransport(app)
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
            preview = asyncio.create_task(client.post(PREVIEW, json=preset()))
            most = 0
            while not preview.done():
                most = max(most, app.state.runner.under_way)
                await asyncio.sleep(0)
            assert (await preview).status_code == 200
            return most

    assert asyncio.run(during()) == 1
    assert figures(app)[("glider_studio_simulations_running",)] == 0
