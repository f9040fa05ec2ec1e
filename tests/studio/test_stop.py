"""The stop of a real process: by a signal, in a few seconds, whatever runs, and with an answer to whoever waits."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
import pytest

from models.presets import load_preset
from server.settings import Settings
from studio import serve
from studio.exit_codes import DONE
from tests.server.job_support import slow_sweep

SOON = 10.0
"""Seconds within which a stop is over, of a machine that does other work too; alone it takes one."""


def long_mission() -> dict:
    document = load_preset("canete-dual-bellows").model_dump(mode="json")
    document["mission"] |= {"duration": 600_000.0, "initial": {"position": [0.0, 0.0, 9000.0]}}
    document["mission"]["solver"] |= {"method": "rk4", "step": 0.002, "output_interval": 1000.0}
    return document


@contextmanager
def program(data: Path, **settings: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    names = {f"GLIDER_STUDIO_{name.upper()}": value for name, value in settings.items()}
    process = subprocess.Popen(
        [sys.executable, "-m", "studio", "serve", "--port", "0", "--data", str(data)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=os.environ | names | {"PYTHONUNBUFFERED": "1"},
    )  # fmt: skip
    try:
        assert process.stdout is not None
        address = re.search(r"http://[\w.]+:\d+", process.stdout.readline())
        assert address, process.communicate(timeout=5)[1]
        yield process, address.group()
    finally:
        process.kill()
        process.communicate(timeout=20)


def stopped(process: subprocess.Popen[str], sig: signal.Signals) -> tuple[int, str, float]:
    began = time.monotonic()
    process.send_signal(sig)
    _, log = process.communicate(timeout=60)
    return process.returncode, log, time.monotonic() - began


@pytest.mark.parametrize("sig", [signal.SIGTERM, signal.SIGINT])
def test_a_stop_ends_a_preview_and_an_event_stream(kernel, tmp_path, sig):
    limits = {"preview_seconds": "60", "preview_steps": "1000000000", "max_steps": "1000000000", "log_format": "json"}
    answers: list[httpx.Response] = []
    with program(tmp_path, **limits) as (process, url), httpx.Client(base_url=url, trust_env=False) as client:
        location = client.post("/sessions", data={"preset": "three-cell-glider"}).headers["location"]

        def preview() -> None:
            with httpx.Client(base_url=url, trust_env=False, timeout=60.0) as own:
                answers.append(own.post("/api/v1/simulations:preview", json=long_mission()))

        asked = threading.Thread(target=preview)
        asked.start()
        with client.stream("GET", f"{location}events") as stream:
            chunks = stream.iter_text()
            assert "event: state" in next(chunks)
            deadline = time.monotonic() + 30.0
            while "glider_studio_simulations_running 1.0" not in httpx.get(f"{url}/metrics", trust_env=False).text:
                assert time.monotonic() < deadline
                time.sleep(0.05)
            code, log, seconds = stopped(process, sig)
            list(chunks)  # ends without an error: the stream was closed as HTTP demands
        asked.join()
    assert code == DONE, log
    assert seconds < SOON
    assert answers[0].status_code == 200
    assert answers[0].json()["status"] == "cancelled"
    lines = [json.loads(line) for line in log.splitlines()]
    assert {item["level"] for item in lines} == {"INFO"}, log
    (line,) = [item for item in lines if item.get("route") == "/api/v1/simulations:preview"]
    assert line["request_id"] == answers[0].headers["x-request-id"]


def test_a_start_tells_settings_that_are_none_and_a_stop_what_is_kept(kernel, tmp_path):
    with (
        program(tmp_path, prot="8001", workers="1") as (process, url),
        httpx.Client(base_url=url, trust_env=False) as client,
    ):
        answer = client.post("/api/v1/jobs", json=slow_sweep(5000), timeout=60.0)
        assert answer.status_code == 202, answer.text
        code, log, _ = stopped(process, signal.SIGTERM)
    assert code == DONE
    assert "GLIDER_STUDIO_PROT is no setting, and nothing reads it: did you mean GLIDER_STUDIO_PORT?" in log
    assert "stopping, asked by SIGTERM" in log
    assert "stopped; unfinished jobs that are kept for the next start: 1" in log


def test_only_a_start_that_compiles_says_so(monkeypatch, tmp_path, capsys):
    done = tmp_path / "done"
    monkeypatch.setattr(serve, "SIMULATION_DONE", done)
    monkeypatch.setattr(serve, "warm_kernel", done.touch)
    monkeypatch.setattr(serve, "warm_analyses", lambda: print("analyses"))
    monkeypatch.setattr(serve, "_settle", lambda: None)
    app = serve.make_app(Settings(data=tmp_path))
    serve._prepare(app)
    first = capsys.readouterr().out
    assert "the first start on a machine compiles it" in first and "The physics is ready." in first
    serve._prepare(app)
    assert capsys.readouterr().out == "The physics is ready.\nanalyses\nTrims and modes are ready.\n"


def test_the_document_of_all_operations_is_there_once_the_physics_is(monkeypatch, tmp_path):
    monkeypatch.setattr(serve, "warm_kernel", lambda: None)
    monkeypatch.setattr(serve, "warm_analyses", lambda: None)
    monkeypatch.setattr(serve, "_settle", lambda: None)
    app = serve.make_app(Settings(data=tmp_path))
    serve._prepare(app)
    assert "securitySchemes" in app.openapi_schema["components"]


def test_a_token_in_an_address_is_not_in_the_log(kernel, tmp_path):
    secret = "the-secret-of-anna-1"
    with (
        program(tmp_path, token=f"anna:{secret}", log_level="debug") as (process, url),
        httpx.Client(base_url=url, trust_env=False) as client,
    ):
        assert client.get("/api/v1/presets").status_code == 401
        assert client.get(f"/?token={secret}").status_code == 303
        assert client.get("/api/v1/presets").status_code == 200, "the cookie proves the token"
        assert client.post("/sessions", data={"preset": "three-cell-glider"}).status_code == 303
        code, log, _ = stopped(process, signal.SIGTERM)
    assert code == DONE
    assert "GET /api/v1/presets 200" in log and " anna]" in log
    assert secret not in log
