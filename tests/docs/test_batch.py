"""docs/batch.md keeps its word: its commands run as they stand, with fewer cases, and its documents are accepted."""

from __future__ import annotations

import json
import os
import re
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from docs.make_batch import PICTURE, ROOT
from server.jobs.plan import make_plan
from server.jobs.spec import BatchDocument, parse_spec
from server.settings import Settings
from studio.batch_arguments import example
from studio.batch_document import read_document

PAGE = (ROOT / "docs" / "batch.md").read_text(encoding="utf-8")
DOCUMENTS = re.findall(r"^```json\n(.*?)^```", PAGE, re.S | re.M)
COMMANDS = "\n".join(re.findall(r"^```sh\n(.*?)^```", PAGE, re.S | re.M))
LONGEST = 480.0
"""Seconds that the page's commands may take on a machine that does other work too."""


def free_port() -> int:
    with socket.socket() as held:
        held.bind(("127.0.0.1", 0))
        return int(held.getsockname()[1])


def commands() -> str:
    """Return the page's commands, with few cases and on ports that are free."""
    text = f"set -eu\n{COMMANDS}"
    for written, used in {"COUNT=100 ": "COUNT=20 ", ":8000": f":{free_port()}", ":8786": f":{free_port()}"}.items():
        assert text.count(written) == 1, written
        text = text.replace(written, used)
    return text


@pytest.mark.slow
def test_the_commands_run(tmp_path):
    (tmp_path / "run").mkdir()
    script = commands()
    port = re.search(r"STUDIO=http://127.0.0.1:(\d+)", script)
    environment = {name: value for name, value in os.environ.items() if not name.startswith("GLIDER_STUDIO_")}
    environment |= {
        "PATH": f"{Path(sys.executable).parent}:{environment['PATH']}", "GLIDER_STUDIO_PORT": port[1],
        "TMPDIR": str(tmp_path / "run"), "GLIDER_STUDIO_WORKERS": "2",
    }  # fmt: skip
    out, err = tmp_path / "out.txt", tmp_path / "err.txt"
    with out.open("w") as printed, err.open("w") as complained:  # no pipes: what runs on behind would hold them open
        program = subprocess.Popen(
            ["bash", "-c", script], cwd=ROOT, env=environment, stdout=printed, stderr=complained, start_new_session=True
        )
        try:
            program.wait(LONGEST)
        finally:
            kill_all_of(program.pid)
            program.wait()
    told, errors = out.read_text(), err.read_text()
    assert program.returncode == 0, (told, errors)
    assert told.count("the same bits") == 3
    assert told.count("cases       1000 of 1000 cases\n") == 3, "twice without a server, once on Dask"
    assert told.count("\nqueued\n") == 2, "retried once, resumed once"
    for line in (
        "{'cases': 1000, 'done': ",
        "\nqueued\nkilled\n",
        "\nthe disk is full: ",
        "free some space and resume the job\n",
        "\nsucceeded\n",
        "exit code 4",
        "exit code 5",
        "written map.png",
    ):
        assert line in told, line
    assert {path.name for path in (tmp_path / "run").glob("*/cases.*")} == {
        "cases.csv", "cases.json", "cases.parquet", "cases.nc", "cases.mat",
    }  # fmt: skip


def kill_all_of(session: int) -> None:
    """End what the page's commands have started, if they have not ended it themselves."""
    try:
        os.killpg(session, signal.SIGKILL)
    except ProcessLookupError:
        return


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda text: re.search(r'"kind": "(\w+)"', text)[1])
def test_the_documents_are_accepted(tmp_path, document):
    path = tmp_path / "spec.json"
    path.write_text(document)
    spec = parse_spec(read_document(path))
    assert make_plan(spec, spec.design, max_cases=5000).count > 0


def test_every_kind_has_a_document():
    kinds = {json.loads(document)["kind"] for document in DOCUMENTS}
    assert kinds == {"simulate", "sweep", "monte_carlo", "sensitivity"}
    assert json.loads(example("monte-carlo")) in [json.loads(document) for document in DOCUMENTS]


def test_the_table_names_every_common_field():
    table = re.search(r"^\| Field \|.*?\n\n", PAGE, re.S | re.M)
    assert set(re.findall(r"`(\w+)`", table[0])) >= set(BatchDocument.model_fields) - {"kind"}


def test_it_names_only_settings_that_exist():
    names = {f"GLIDER_STUDIO_{name.upper()}" for name in Settings.model_fields}
    told = set(re.findall(r"GLIDER_STUDIO_[A-Z_]+", PAGE)) | {
        f"GLIDER_STUDIO{n}" for n in re.findall(r"`(_MAX[A-Z_]+)`", PAGE)
    }
    assert told and told <= names


def test_the_picture_is_one_that_the_page_shows():
    assert f"](img/{PICTURE.name})" in PAGE
    assert PICTURE.read_bytes().startswith(b"\x89PNG") and PICTURE.stat().st_size > 20_000
