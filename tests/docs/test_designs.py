"""docs/designs.md keeps its word: its commands run as they stand, against a studio with a store of its own."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

from server.app import create_app
from server.jobs.engines import SerialEngine
from server.jobs.opening import finder
from server.jobs.service import Jobs
from server.settings import Settings
from server.store.database import Database, sqlite_url
from server.store.designs import DesignStore
from tests.server.serving import served

PAGE = (Path(__file__).parents[2] / "docs" / "designs.md").read_text(encoding="utf-8")
COMMANDS = "\n".join(re.findall(r"^```sh\n(.*?)^```", PAGE, re.S | re.M))


def test_the_commands_run(tmp_path):
    store = DesignStore(Database(sqlite_url(tmp_path / "studio.sqlite")))
    jobs = Jobs(store.database, SerialEngine(), tmp_path / "jobs", find_design=finder(store))
    app = create_app(Settings(host="127.0.0.1", token=None, data=tmp_path), store=store, jobs=jobs)
    with served(app) as server:
        environment = os.environ | {"STUDIO": server.url, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
        done = subprocess.run(
            ["bash", "-euo", "pipefail", "-c", COMMANDS],
            cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=120, check=False,
        )  # fmt: skip
    assert done.returncode == 0, (done.stdout, done.stderr)
    told = done.stdout
    assert 'etag: "1"' in told.lower() and '"name": "Dual-bellows lake glider"' in told
    lines = told.splitlines()
    changed = lines.index("2")
    assert "revision" in lines[changed + 1], "the second change comes too late"
    assert "'Tail piston'" in told
    assert lines[lines.index("204") - 1 : lines.index("204") + 3] == ["4", "204", "410", "4"]
    assert lines[-1] == lines[-2] and len(lines[-1]) == 26, "one job for one key"
