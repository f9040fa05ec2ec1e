"""Starts the whole program as a user does, in a process of its own, and opens sessions in it as a browser does."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx

PRESET = "canete-dual-bellows"


@dataclass
class Program:
    """A running studio: its address, when its process was started (perf_counter), and the process."""

    url: str
    started: float
    pid: int

    def open_session(self, preset: str = PRESET) -> tuple[str, str]:
        """Return the address of a new session's page and its cookie header."""
        with httpx.Client(base_url=self.url, trust_env=False, timeout=60.0) as client:
            answer = client.post("/sessions", data={"preset": preset}, headers={"Origin": self.url})
            assert answer.status_code == 303, answer.text
            path = answer.headers["location"]
            name = f"gs_{path.split('/')[2]}"
            return f"{self.url}{path}", f"{name}={client.cookies[name]}"

    def wait_for_run(self, page: str, cookie: str, *, seconds: float = 120.0) -> dict[str, Any]:
        """Return the state of a session once its first run is there."""
        deadline = time.perf_counter() + seconds
        with httpx.Client(trust_env=False, timeout=60.0, headers={"Cookie": cookie}) as client:
            while time.perf_counter() < deadline:
                state: dict[str, Any] = client.get(f"{page}state").json()
                if state["run"] is not None:
                    return state
                time.sleep(0.05)
        raise SystemExit("no glide came in time")


@contextmanager
def running_program(*, kernel_cache: Path | None = None, data: Path | None = None) -> Iterator[Program]:
    """Start the studio on a free port of this machine, with a data folder or one of its own; stop it at the end.

    With a folder its log is thrown away: under load it is long.
    """
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {"GLIDER_STUDIO_DATA": str(data or folder), "PYTHONUNBUFFERED": "1"}
        if kernel_cache is not None:
            environment["GLIDER_STUDIO_KERNEL_CACHE"] = str(kernel_cache)
        started = time.perf_counter()
        command = [sys.executable, "-m", "studio", "serve", "--port", "0"]
        log = subprocess.DEVNULL if data is not None else None
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=log, text=True, env=environment)
        try:
            assert process.stdout is not None
            address = re.search(r"http://[^/\s]+", process.stdout.readline())
            assert address, "the studio did not print its address"
            yield Program(address.group(), started, process.pid)
        finally:
            process.terminate()
            process.wait(20)
