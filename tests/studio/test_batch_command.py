"""The batch command: the same jobs as the server's, their files, how they go on, and errors in one line."""

from __future__ import annotations

import io
import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import fields
from pathlib import Path

import h5netcdf
import pyarrow.csv
import pyarrow.parquet as pq
import pytest
from scipy.io import loadmat

from models.design import parse_design
from models.presets import load_preset
from server.jobs import engines
from server.jobs.engines import SerialEngine
from server.store.job_records import Job
from studio import batch_progress
from studio.__main__ import main
from studio.batch_arguments import EXAMPLES, FORMATS, example
from studio.batch_progress import progress, words
from studio.exit_codes import DONE, MISUSED, PARTIAL, REFUSED, STOPPED, UNUSABLE
from tests.server.job_support import assert_whole, finished, glider, listed, open_at, running, sweep, table_of, wait_for

ROOT = Path(__file__).parents[2]
COMMAND = "/mission/control/schedules/0/points/0/extension"
"""Stroke of a cell: from 0 to 0.032 m."""
PROGRAM = [str(Path(sys.executable).with_name("glider-studio"))]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Nothing of the environment counts, and the program runs in a folder of its own."""
    for name in [name for name in os.environ if name.startswith("GLIDER_STUDIO_")]:
        monkeypatch.delenv(name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(document, name="spec.json"):
    Path(name).write_text(json.dumps(document))
    return name


def run(document, *arguments):
    return main(["batch", write(document), "--workers", "0", *arguments])


def only_job(folder):
    jobs = open_at(Path(folder))
    [job] = jobs.store.page()
    return jobs, jobs.store.get(job.id)


def test_it_gives_the_numbers_of_a_server_in_every_format(folder, capsys):
    document = sweep(5, trajectories=[2])
    formats = [word for name in FORMATS for word in ("--format", name)]
    assert run(document, "-o", "out", *formats) == DONE
    told = capsys.readouterr()
    (folder / "served").mkdir()
    with running(open_at(folder / "served")) as server:
        expected = table_of(server, finished(server, server.submit(document)[0]))
    assert pq.read_table("out/cases.parquet").equals(expected)
    ranges = expected.column("range").to_pylist()
    assert pyarrow.csv.read_csv("out/cases.csv").column("range [m]").to_pylist() == ranges
    assert json.loads(Path("out/cases.json").read_text())["columns"]["range"] == ranges
    assert loadmat("out/cases.mat", squeeze_me=True)["range"].tolist() == ranges
    with h5netcdf.File("out/cases.nc") as file:
        assert file.variables["range"][...].tolist() == ranges and file.dimensions["obs"].size > 10
        assert json.loads(file.attrs["batch_document"])["kind"] == "sweep"
    summary = json.loads(Path("out/summary.json").read_text())
    assert summary["metrics"]["range"]["count"] == 5
    assert "cases       5 of 5 cases" in told.out and "metric      range: mean" in told.out
    assert all(f"written     out/cases.{ending}\n" in told.out for ending in ("csv", "parquet", "nc", "mat", "json"))
    about = {name.decode(): text.decode() for name, text in pq.read_schema("out/cases.parquet").metadata.items()}
    assert json.loads(about["batch_document"])["kind"] == "sweep"
    assert json.loads(about["design"])["identity"] == parse_design(glider()).identity
    assert set(json.loads(about["engine"])) == {"version", "kernel", "processors"}


def test_a_format_is_known_by_its_name_and_by_its_ending(folder):
    assert run(sweep(2), "-o", "out", "--format", "netcdf", "--format", "nc") == DONE
    assert sorted(path.name for path in Path("out").glob("cases.*")) == ["cases.nc"]


def test_settings_that_are_none_are_told(folder, monkeypatch, capsys):
    monkeypatch.setenv("GLIDER_STUDIO_MAX_CASE", "3")
    assert run(sweep(2), "--dry-run") == DONE
    assert "GLIDER_STUDIO_MAX_CASE is no setting" in capsys.readouterr().err
    assert not list(folder.rglob("*.part")) and not list(folder.rglob("download-*"))


def test_the_database_of_a_server_is_not_used_and_that_is_said_in_a_line(folder, monkeypatch, capsys):
    monkeypatch.setenv("GLIDER_STUDIO_DATABASE_URL", f"sqlite:///{folder}/other.sqlite")
    assert run(sweep(2), "-o", "out") == DONE
    told = [line for line in capsys.readouterr().err.splitlines() if "GLIDER_STUDIO_DATABASE_URL" in line]
    kept = Path("out/studio.sqlite")
    assert told == [
        f"environment: warning: GLIDER_STUDIO_DATABASE_URL is not used here: the jobs of a batch are kept in {kept}"
    ]
    assert kept.exists() and not Path("other.sqlite").exists()


def test_results_lie_in_a_folder_of_the_documents_name_that_a_server_can_open(folder):
    assert run(sweep(3)) == DONE
    assert {path.name for path in (folder / "spec").iterdir()} >= {"studio.sqlite", "jobs", "cases.csv", "summary.json"}
    jobs, job = only_job("spec")
    assert_whole(jobs, job)


def test_the_same_again_writes_the_files_and_computes_nothing(folder, capsys):
    assert run(sweep(3), "-o", "out") == DONE
    first = Path("out/cases.csv").read_bytes()
    Path("out/cases.csv").unlink()
    [chunk] = (folder / "out" / "jobs").rglob("chunk-*0.parquet")
    before = chunk.stat().st_mtime_ns
    assert run(sweep(3, name="Another name"), "-o", "out") == DONE
    assert Path("out/cases.csv").read_bytes() == first and chunk.stat().st_mtime_ns == before
    assert "computed before" in capsys.readouterr().err
    assert run(sweep(3), "-o", "out", "--fresh") == DONE
    assert len(open_at(folder / "out").store.page()) == 2


def test_the_design_is_a_file_beside_the_document_or_a_preset(folder, capsys):
    (folder / "sub").mkdir()
    Path("sub/glider.json").write_text(json.dumps(glider()))
    specs = [write(sweep(2, design="glider.json"), "sub/spec.json"), write(sweep(2), "inside.json")]
    for spec in specs:
        assert main(["batch", spec, "-o", "out", "--workers", "0"]) == DONE
    assert len(open_at(folder / "out").store.page()) == 1, "both are one job"
    assert main(["batch", write(sweep(2, design="preset:quad-bellows-glide")), "--dry-run"]) == DONE
    assert load_preset("quad-bellows-glide").name in capsys.readouterr().out


def test_a_dry_run_shows_the_cases_and_leaves_nothing(folder, capsys):
    assert run(sweep(7), "--dry-run") == DONE
    told = capsys.readouterr().out
    assert "cases       7\n" in told and "parameter   place [m]: /vehicle/components/1/position/0\n" in told
    assert "metric      range [m]: horizontal distance" in told and "case 0      0.05\n" in told
    assert "case 4 " in told and "case 5 " not in told
    assert [path.name for path in folder.iterdir()] == ["spec.json"]


def test_a_document_from_standard_input(folder, monkeypatch, capsys):
    stream = io.TextIOWrapper(io.BytesIO(json.dumps(sweep(2, design="preset:canete-dual-bellows")).encode()))
    monkeypatch.setattr(sys, "stdin", stream)
    assert main(["batch", "-", "--dry-run", "-o", "none"]) == DONE
    assert "cases       2\n" in capsys.readouterr().out and not Path("none").exists()


def test_failed_cases_are_told_by_reason_with_a_code_of_their_own(capsys):
    document = listed(COMMAND, [0.01, 0.5, 0.02, 0.6])
    for more in ((), (), ("--retry",)):
        assert run(document, "-o", "out", *more) == PARTIAL
        told = capsys.readouterr()
        [line] = [line for line in told.err.splitlines() if "failed" in line and line.startswith("spec.json: ")]
        assert line.startswith("spec.json: 2 failed, the first of them case 1: ") and "outside its stops" in line
        assert "cases       4 of 4 cases, 2 failed" in told.out
    assert run(listed(COMMAND, [0.5, 0.6]), "-o", "all") == STOPPED


def test_a_paused_job_says_why_and_is_resumed(monkeypatch, capsys):
    monkeypatch.setenv("GLIDER_STUDIO_MIN_FREE_MIB", str(10**9))
    assert run(sweep(3), "-o", "out") == STOPPED
    told = capsys.readouterr()
    assert "paused      the disk is full" in told.out
    assert "spec.json: paused: what is done is kept, and the same command goes on\n" in told.err
    assert not Path("out/cases.csv").exists()
    monkeypatch.delenv("GLIDER_STUDIO_MIN_FREE_MIB")
    assert run(sweep(3), "-o", "out") == DONE
    assert_whole(*only_job("out"))


def test_a_cancelled_job_is_gone_on_with(folder):
    jobs = open_at(folder / "out")
    jobs.store.cancel(jobs.submit(sweep(3))[0].id)
    assert run(sweep(3), "-o", "out") == DONE
    assert_whole(*only_job("out"))


def begun(folder, *arguments):
    """Start the program on a job of many chunks; return it once some are done."""
    spec = write(sweep(60_000, design=glider(duration=20.0)))
    program = subprocess.Popen(
        [*PROGRAM, "batch", spec, "-o", "out", *arguments],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip

    def some_are_done():
        assert program.poll() is None, program.communicate()
        return Path("out/studio.sqlite").exists() and list((folder / "out").glob("jobs/*/chunk-*.parquet"))

    wait_for(some_are_done, what="the first chunk")
    return program


@pytest.mark.parametrize(
    ("workers", "send", "number"), [("2", os.killpg, signal.SIGINT), ("0", os.kill, signal.SIGTERM)]
)
def test_an_interrupt_keeps_what_is_done_and_says_how_to_go_on(folder, workers, send, number):
    program = begun(folder, "--workers", workers)
    send(program.pid, number)
    told = program.communicate(timeout=60)
    assert program.returncode == STOPPED, told
    assert told[1].endswith("spec.json: stopped: what is done is kept, and the same command goes on\n")
    assert "Traceback" not in told[1]
    jobs, job = only_job("out")
    assert job.state == "running" and job.owner is None and 0 < job.done < job.cases
    assert len(jobs.store.written(job.id)) == len(list(jobs.files(job).written()))


def test_after_a_kill_the_same_command_goes_on(folder):
    program = begun(folder, "--workers", "0")
    program.kill()
    program.communicate(timeout=60)
    jobs, job = only_job("out")
    kept = {path: path.stat().st_mtime_ns for path in jobs.files(job).written()}
    again = subprocess.Popen([*PROGRAM, "batch", "spec.json", "-o", "out", "--workers", "0"], start_new_session=True)
    try:
        wait_for(lambda: len(list(jobs.files(job).written())) > len(kept) + 1, what="further chunks")
    finally:
        again.terminate()
        again.wait(60)
    counted = jobs.store.written(job.id)
    assert len(counted) > len(kept)
    assert all(path.stat().st_mtime_ns == at for path, at in list(kept.items())[:-1]), "what counted is not done again"
    assert len(jobs.store.page()) == 1


def with_design(**change):
    return sweep() | {"design": glider() | change}


@pytest.mark.parametrize(
    ("document", "arguments", "code", "says"),
    [
        (sweep(0), (), REFUSED, "spec.json: /method/parameters/0/count"),
        (listed("/vehicle/nothing", [1]), (), REFUSED, "spec.json: /method/parameters/0/pointer"),
        (with_design(nam="x"), (), REFUSED, "spec.json: /design/nam"),
        (sweep(design="preset:nessie"), (), REFUSED, "spec.json: /design: there is no preset 'nessie' (there are "),
        (sweep(design="none.json"), (), UNUSABLE, "none.json: No such file"),
        (sweep(design="spec.txt"), (), REFUSED, "spec.json: /design: spec.txt is not JSON"),
        (sweep() | {"seed": float("nan")}, (), REFUSED, "spec.json: /seed: nan is not a finite number"),
        ([], (), REFUSED, "a batch document is a JSON object"),
        (sweep(), ("-o", "spec.txt"), UNUSABLE, "spec.txt: File exists"),
        (sweep(), ("--scheduler", "tcp://127.0.0.1:1"), UNUSABLE, "--scheduler: the Dask scheduler at tcp://127.0.0.1:1"),
    ],
)  # fmt: skip
def test_errors_are_a_line(monkeypatch, capsys, document, arguments, code, says):
    monkeypatch.setitem(engines.DaskEngine.__init__.__kwdefaults__, "within", 0.3)
    Path("spec.txt").write_text("not JSON")
    assert main(["batch", write(document), *arguments]) == code
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 1 and says in told[0], told


def test_a_design_of_a_store_that_is_not_there(capsys):
    document = {name: value for name, value in sweep().items() if name != "design"} | {"design_id": "0" * 26}
    for more in ((), ("--dry-run",)):
        assert run(document, *more) == REFUSED
        assert "spec.json: /design_id: there is no" in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [(), ("-",), ("plain",)])
def test_what_is_missing_is_told(capsys, arguments):
    Path("plain").write_text("{}")
    assert main(["batch", *arguments]) == MISUSED
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize(
    "arguments",
    [("--workers", "-1"), ("--workers", "2", "--scheduler", "tcp://a:1"), ("--scheduler", "a"), ("--format", "xls")],
)
def test_the_command_line_is_checked(capsys, arguments):
    with pytest.raises(SystemExit) as left:
        main(["batch", write(sweep()), *arguments])
    assert left.value.code == MISUSED and "usage" in capsys.readouterr().err


def test_a_wrong_setting_is_told_by_its_name(monkeypatch, capsys):
    monkeypatch.setenv("GLIDER_STUDIO_MAX_CASES", "many")
    assert run(sweep()) == UNUSABLE
    assert capsys.readouterr().err.startswith("GLIDER_STUDIO_MAX_CASES: ")


def test_the_settings_limits_count(monkeypatch, capsys):
    monkeypatch.setenv("GLIDER_STUDIO_MAX_CASES", "4")
    assert run(sweep(5)) == REFUSED
    assert "spec.json: /method" in capsys.readouterr().err


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_examples_run(folder, capsys, name):
    assert main(["batch", "--example", name]) == DONE
    printed = capsys.readouterr().out
    assert printed == (ROOT / "examples" / f"batch_{name.replace('-', '_')}.json").read_text() == example(name)
    assert main(["batch", write(json.loads(printed)), "--dry-run"]) == DONE
    capsys.readouterr()
    assert run(smaller(json.loads(printed)), "-o", "out") == DONE
    told = capsys.readouterr().out
    assert ("indices     range: total" in told) == (name == "sensitivity")
    assert ("stopped after" in told) == (name == "monte-carlo")


def smaller(document):
    """Return an example with fewer cases, which stops early by a wider interval where it does."""
    match document["kind"]:
        case "sweep":
            for parameter in document["method"]["parameters"]:
                parameter["count"] = 3
        case "monte_carlo":
            document["stop"] |= {"width": 20.0, "least": 8, "every": 8}
        case "sensitivity":
            document["method"]["base"] = 8
    return document


def a_job(**values):
    return Job(**dict.fromkeys(field.name for field in fields(Job)) | {"cases": 100, "done": 20, "failed": 0} | values)


def test_progress_in_words():
    assert words(a_job()) == "20 of 100 cases"
    assert words(a_job(failed=3, rate=16.0)) == "20 of 100 cases, 3 failed, 16 cases/s, 0:00:05 left"
    assert words(a_job(stopped_at=20)) == "20 of 20 cases"


def test_progress_without_a_terminal_is_a_line_now_and_then(monkeypatch, capsys):
    with progress() as show:
        show(a_job(done=0))
        show(a_job(done=1))
        monkeypatch.setattr(batch_progress, "LINE_EVERY", 0.0)
        show(a_job(done=2))
        show(a_job(done=2))
    assert capsys.readouterr().err == "0 of 100 cases\n2 of 100 cases\n"


def test_progress_on_a_terminal_is_a_bar(monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "120")
    with progress() as show:
        show(a_job(rate=16.0))
        time.sleep(0.3)
    told = capsys.readouterr().err
    assert "20 of 100 cases, 16 cases/s, 0:00:05 left" in told and "━" in told


def test_the_command_line_stays_light():
    code = "import sys, studio.__main__; print({'numpy', 'pydantic', 'sqlalchemy', 'rich'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"


def test_a_batch_loads_no_web(folder):
    code = (
        "import sys; from studio.__main__ import main; main(['batch', sys.argv[1], '--workers', '0']); "
        "print({'viser', 'fastapi', 'uvicorn', 'matplotlib'} & set(sys.modules))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, write(sweep(2))], env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout.splitlines()[-1] == "set()"


def test_without_workers_it_computes_in_this_process(monkeypatch):
    made = []
    monkeypatch.setattr(SerialEngine, "_make", lambda self, make=SerialEngine._make: made.append(self) or make(self))
    assert run(sweep(2)) == DONE and len(made) == 1
