"""The kernel's compilation, and from the command to first page and glide: `python -m benchmarks.startup`.

Both warm and with an empty kernel cache.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import httpx

from benchmarks.program import running_program
from models.warm import warm_kernel


def measure(kernel_cache: Path | None) -> tuple[float, float]:
    """Return the times to the first page and to the first glide, s since the process was started."""
    with running_program(kernel_cache=kernel_cache) as program:
        while True:
            try:
                if httpx.get(f"{program.url}/", trust_env=False, timeout=60.0).status_code == 200:
                    break
            except httpx.TransportError:
                time.sleep(0.02)
        page_at = time.perf_counter() - program.started
        page, cookie = program.open_session()
        state = httpx.get(f"{page}state", headers={"Cookie": cookie}, trust_env=False, timeout=60.0).json()
        print(f"  kernel when the session's page is up: {state['kernel']}")
        program.wait_for_run(page, cookie)
        return page_at, time.perf_counter() - program.started


def first_flights(kernel_cache: Path) -> dict[str, float]:
    """Return the seconds of a fresh process: in all, for its imports, and for the first flight of each model."""
    began = time.perf_counter()
    environment = os.environ | {"GLIDER_STUDIO_KERNEL_CACHE": str(kernel_cache)}
    command = [sys.executable, "-m", "benchmarks.first_flights"]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        seconds: dict[str, float] = json.loads(process.stdout.readline())
        return seconds | {"in all": time.perf_counter() - began}


def report_kernel() -> None:
    """Print how long the kernel of both models takes to compile, and to load from its cache."""
    with tempfile.TemporaryDirectory() as empty:
        cold = first_flights(Path(empty))
        cached = [first_flights(Path(empty)) for _ in range(5)]
    warm = {name: statistics.median(times[name] for times in cached) for name in cold}
    for label, seconds, goal in (("compiled", cold, 45), ("from its cache", warm, 2)):
        parts = ", ".join(f"{name} {value:.2f} s" for name, value in seconds.items() if name != "in all")
        print(f"kernel {label}: {seconds['in all']:.2f} s (to reach: {goal}); {parts}")


def main() -> None:
    """Measure and print."""
    report_kernel()
    warm_kernel()
    page, glide = measure(None)
    print(f"warm: first page after {page:.1f} s (to reach: 4), first glide after {glide:.1f} s (to reach: 6)")
    with tempfile.TemporaryDirectory() as empty:
        page, glide = measure(Path(empty))
    print(f"cold: first page after {page:.1f} s, first glide after {glide:.1f} s (to reach: 40)")


if __name__ == "__main__":
    main()
