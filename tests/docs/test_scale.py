"""docs/scale.md keeps its word: its TLS settings let in who has the key and nobody else; tasks are as large as told."""

from __future__ import annotations

import os
import pickle
import re
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from docs.make_batch import ROOT
from models.limits import DEFAULT_LIMITS
from models.presets import load_preset
from server.jobs.plan import make_plan
from server.jobs.spec import parse_spec
from server.jobs.tasks import TaskMaker

PAGE = (ROOT / "docs" / "scale.md").read_text(encoding="utf-8")
[MAKE_KEY] = re.findall(r"^```sh\n(.*?)^```", PAGE, re.S | re.M)
[SETTINGS] = re.findall(r"^```yaml\n(.*?)^```", PAGE, re.S | re.M)
KEPT_IN = "/etc/glider-studio"
ASKS = (
    "import sys; from server.jobs.engines import DaskEngine; "
    "engine = DaskEngine(sys.argv[1], within=float(sys.argv[2])); "
    "print(engine.submit(len, 'four').result(60)); engine.stop()"
)
"""What a studio does with a scheduler, in short."""


@contextmanager
def dask(what: str, *arguments: str, environment: dict[str, str]) -> Iterator[None]:
    command = [sys.executable, "-m", f"distributed.cli.dask_{what}", *arguments, "--no-dashboard"]
    with subprocess.Popen(command, cwd=ROOT, env=environment, stderr=subprocess.DEVNULL) as process:
        try:
            yield
        finally:
            process.kill()


def ask(address: str, environment: dict[str, str], *, within: float) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", ASKS, address, str(within)]
    return subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=240)


def with_key_in(folder: Path) -> dict[str, str]:
    """Make a key as the page says, and return the environment of a program that has it."""
    folder.mkdir()
    subprocess.run(["bash", "-euc", MAKE_KEY], cwd=folder, check=True, capture_output=True)
    assert (folder / "dask.key").stat().st_mode & 0o077 == 0
    settings = folder / "settings"
    settings.mkdir()
    (settings / "distributed.yaml").write_text(SETTINGS.replace(KEPT_IN, str(folder)))
    return os.environ | {"DASK_CONFIG": str(settings), "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}


@pytest.mark.slow
def test_tls_lets_in_who_has_the_key_and_nobody_else(tmp_path):
    with_key, with_another = with_key_in(tmp_path / "ours"), with_key_in(tmp_path / "another")
    without_key = {name: value for name, value in with_key.items() if name != "DASK_CONFIG"}
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        host, port = "tls://127.0.0.1", str(probe.getsockname()[1])
    with ExitStack() as running:
        running.enter_context(dask("scheduler", "--host", host, "--port", port, environment=with_key))
        address = f"{host}:{port}"
        worker = (address, "--nthreads", "1", "--no-nanny", "--memory-limit", "0")
        running.enter_context(dask("worker", *worker, environment=with_key))
        let_in = ask(address, with_key, within=60.0)
        assert let_in.stdout == "4\n", let_in.stderr
        for told, environment in ((address, with_another), (address.replace("tls", "tcp"), without_key)):
            refused = ask(told, environment, within=3.0)
            assert refused.returncode != 0 and "EngineLostError" in refused.stderr


def test_a_task_is_as_large_as_the_page_says():
    """Rows grow with the cases; the design goes along once a chunk."""
    design = load_preset("canete-dual-bellows").model_dump(mode="json")
    spread = {"kind": "uniform", "low": 0.1, "high": 0.2}
    pointers = ("/vehicle/components/1/position/0", "/mission/initial/pitch")
    pair = [{"pointer": pointer, "distribution": spread} for pointer in pointers]
    document = {"format": "glider-batch", "version": 1, "kind": "monte_carlo", "design": design, "count": 9000}
    document |= {"parameters": pair}
    spec = parse_spec(document)
    assert spec.design is not None
    maker = TaskMaker(make_plan(spec, spec.design, max_cases=9000), DEFAULT_LIMITS)
    small, large = (len(pickle.dumps(maker.task("0" * 26, 0, 0, count))) for count in (1000, 9000))
    [told] = re.findall(r"its rows \((\d+) bytes a case for a pair", PAGE)
    assert round((large - small) / 8000) == int(told)
