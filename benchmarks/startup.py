"""From the command to the first page and glide, warm and with an empty kernel cache: `python -m benchmarks.startup`."""

from __future__ import annotations

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


def main() -> None:
    """Measure and print."""
    warm_kernel()
    page, glide = measure(None)
    print(f"warm: first page after {page:.1f} s (to reach: 4), first glide after {glide:.1f} s (to reach: 6)")
    with tempfile.TemporaryDirectory() as empty:
        page, glide = measure(Path(empty))
    print(f"cold: first page after {page:.1f} s, first glide after {glide:.1f} s (to reach: 40)")


if __name__ == "__main__":
    main()
