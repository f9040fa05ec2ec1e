"""The command line: what it prints, what it writes, and its exit codes."""

from __future__ import annotations

import json
import os
import re
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from pathlib import Path

import numpy as np
import pytest

from models.presets import load_preset, preset_ids
from models.run import Run
from models.simulate import Control
from studio import commands
from studio.__main__ import main
from studio.exit_codes import DONE, MISUSED, REFUSED, STOPPED, UNUSABLE


@pytest.fixture
def design_file(tmp_path: Path) -> Path:
    path = tmp_path / "glider.json"
    path.write_text(load_preset("canete-dual-bellows").to_json())
    return path


def change(path: Path, **mission: object) -> Path:
    document = json.loads(path.read_text())
    document["mission"] |= mission
    path.write_text(json.dumps(document))
    return path


def test_presets_are_listed_and_printed(capsys):
    assert main(["presets"]) == DONE
    listed = capsys.readouterr().out
    assert [line.split()[0] for line in listed.splitlines()] == list(preset_ids())
    assert main(["presets", "canete-dual-bellows"]) == DONE
    assert capsys.readouterr().out == load_preset("canete-dual-bellows").to_json()


def test_an_unknown_preset_names_those_that_exist(capsys):
    assert main(["presets", "nessie"]) == REFUSED
    assert "canete-dual-bellows" in capsys.readouterr().err


def test_simulate_writes_netcdf_and_csv_of_the_same_run(design_file, tmp_path, capsys):
    for suffix in ("nc", "csv"):
        assert main(["simulate", str(design_file), "-o", str(tmp_path / f"run.{suffix}")]) == DONE
    printed = capsys.readouterr().out
    run = Run.from_netcdf(tmp_path / "run.nc")
    assert f"depth {run.final['z']:.4f} m" in printed
    rows = np.genfromtxt(tmp_path / "run.csv", delimiter=",", skip_header=1)
    assert rows[-1, 2] == run.final["z"]
    assert run.design == load_preset("canete-dual-bellows")


def test_simulate_tells_events_and_what_left_the_data(design_file, capsys):
    change(design_file, initial={"position": [0.0, 0.0, 0.0]})
    assert main(["simulate", str(design_file)]) == DONE
    printed = capsys.readouterr().out
    assert "status      surface" in printed
    assert re.search(r"event\s+the glider reached the surface at 1\d\.\d+ s", printed)
    assert "slower than the data's 0.1 m/s" in printed


def test_a_refused_design_is_one_line_with_its_pointer(design_file, capsys):
    change(design_file, duration=-1)
    for command in (["validate"], ["simulate"]):
        assert main([*command, str(design_file)]) == REFUSED
        told = capsys.readouterr().err
        assert told.count("\n") == 1
        assert told.startswith(f"{design_file}: /mission/duration: ")


def test_files_that_cannot_be_used(tmp_path, design_file, capsys):
    assert main(["validate", str(tmp_path / "none.json")]) == UNUSABLE
    assert main(["simulate", str(design_file), "-o", str(tmp_path / "no" / "run.nc")]) == UNUSABLE
    assert main(["simulate", str(design_file), "-o", str(tmp_path / "run.xlsx")]) == MISUSED
    assert ".nc or .csv" in capsys.readouterr().err
    broken = tmp_path / "broken.json"
    broken.write_text('{"format": "glider-design", "version": NaN}')
    assert main(["validate", str(broken)]) == REFUSED
    assert "NaN is not JSON" in capsys.readouterr().err


def test_a_run_that_stops_early_says_so(design_file, capsys):
    document = json.loads(design_file.read_text())
    document["mission"]["solver"] |= {"method": "rk4", "step": 2.0}
    document["vehicle"]["damping"]["pitch"] = 1e3  # far beyond what a step of 2 s can follow
    design_file.write_text(json.dumps(document))
    assert main(["simulate", str(design_file)]) == STOPPED
    assert "status      diverged" in capsys.readouterr().out


def test_an_interrupt_stops_the_run_and_keeps_it(design_file, monkeypatch):
    change(design_file, duration=600_000.0, solver={"method": "rk4", "step": 0.2, "output_interval": 100.0})
    change(design_file, initial={"position": [0.0, 0.0, 9000.0]})
    made: list[Control] = []
    original = Control.__init__

    def remember(self: Control) -> None:
        original(self)
        made.append(self)

    monkeypatch.setattr(Control, "__init__", remember)
    monkeypatch.setattr(commands, "PROGRESS_EVERY", 0.01)
    stopper = threading.Thread(target=lambda: (wait_for(lambda: made and made[0].time_reached > 0.0), made[0].cancel()))
    stopper.start()
    assert main(["simulate", str(design_file)]) == STOPPED
    stopper.join()


def wait_for(condition, *, seconds: float = 30.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.001)


def run_program(*arguments: str, **environment: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "studio", *arguments],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=os.environ | environment,
    )  # fmt: skip


def test_simulating_loads_neither_viser_nor_fastapi(design_file):
    code = (
        "import sys; from studio.__main__ import main; main(['simulate', sys.argv[1]]); "
        "print({'viser', 'fastapi', 'uvicorn'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code, str(design_file)], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "set()"


def test_serve_prints_an_address_that_answers_at_once(tmp_path):
    program = run_program("serve", "--port", "0", "--data", str(tmp_path), PYTHONUNBUFFERED="1")
    try:
        assert program.stdout is not None
        address = re.search(r"http://127\.0\.0\.1:\d+/", program.stdout.readline())
        assert address
        with urllib.request.urlopen(address.group(), timeout=30) as answer:
            assert b"Glider studio" in answer.read()
    finally:
        program.terminate()
        program.communicate(timeout=20)


def test_a_taken_port_is_told_with_the_way_out(tmp_path):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        program = run_program("serve", "--port", str(taken.getsockname()[1]), "--data", str(tmp_path))
        _, told = program.communicate(timeout=60)
    assert program.returncode == UNUSABLE
    assert "GLIDER_STUDIO_PORT" in told


def test_another_address_demands_a_token(tmp_path):
    program = run_program("serve", "--host", "0.0.0.0", "--port", "0", "--data", str(tmp_path))
    _, told = program.communicate(timeout=60)
    assert program.returncode == UNUSABLE
    assert "GLIDER_STUDIO_TOKEN" in told


def test_attach_puts_a_profile_into_a_design(tmp_path, capsys):
    design, profile, out = tmp_path / "quad.json", tmp_path / "ctd.csv", tmp_path / "out.json"
    design.write_text(load_preset("quad-bellows-glide").to_json())
    profile.write_text("depth,temperature,salinity\n0,20,35\n50,12,35.2\n200,8,35.1\n")
    words = ["attach", str(design), "water", str(profile), "-o", str(out), "--latitude", "45", "--source", "Our CTD"]
    assert main(words) == DONE
    water = json.loads(out.read_text())["mission"]["environment"]["water"]
    assert (water["kind"], water["latitude"], water["source"]) == ("teos10", 45.0, "Our CTD")
    assert water["salinities"] == [35.0, 35.2, 35.1]
    assert "net buoyancy with neutral cells" in capsys.readouterr().out, "salt water lifts a glider of fresh water"
    profile.write_text("depth,temperature\n0,20\n10,warm\n")
    assert main(words) == REFUSED
    assert "warm" in capsys.readouterr().err


TWO_ANGLES = ["speed,alpha_deg,beta_deg (deg),X [N],Y,Z,K,M,N"] + [
    f"0.5,{a},{b},{-0.5},{-b * 0.01},{-a * 0.02},0,{-a * 0.001},{b * 0.001}" for a in (-30, 0, 30) for b in (0, 10, 20)
]
ONE_ANGLE = ["speed,alpha_deg,lift (N),drag,moment (N m)", *(f"0.5,{a},{a},1,0" for a in (0, 30, 60, 90))]


def attach(tmp_path, rows, *words, kind="forces", source=None):
    """Attach rows to the quad glider, or to its change of source; return the exit code and the file written."""
    design, data, out = tmp_path / "quad.json", tmp_path / "cfd.csv", tmp_path / "out.json"
    document = json.loads(load_preset("quad-bellows-glide").to_json())
    if source is not None:
        document["vehicle"]["hydrodynamics"] = source
    design.write_text(json.dumps(document))
    data.write_text("\n".join(rows))
    return main(["attach", str(design), kind, str(data), "-o", str(out), *words]), out


def source_of(path):
    return json.loads(path.read_text())["vehicle"]["hydrodynamics"]


def test_attach_of_a_table_over_both_angles_keeps_the_rate_terms(tmp_path, capsys):
    former = load_preset("quad-bellows-glide").vehicle.hydrodynamics
    code, out = attach(tmp_path, TWO_ANGLES)
    printed, source = capsys.readouterr().out, source_of(out)
    assert code == DONE and main(["validate", str(out)]) == DONE
    assert source["kind"] == "angle_table" and source["surge"][0][0] == -2.0 and source["includes_munk_moment"]
    assert source["rates"]["yaw_yaw"] == former.lateral.rates.yaw_yaw != 0.0
    assert f"kept        rate terms of '{former.provenance.title}'\n" in printed
    assert "replaced    lateral coefficients: side force, roll and yaw now come from the table" in printed
    assert "assumed     the moments hold the Munk moment (--munk excluded if not)" in printed


def test_attach_keeps_the_same_forces_at_another_reference_density(tmp_path, capsys):
    former = load_preset("quad-bellows-glide").vehicle.hydrodynamics
    words = ("--munk", "excluded", "--reference-density", "1025", "--reference-point", "0.1", "0", "-0.2")
    for rows in (TWO_ANGLES, ONE_ANGLE):
        code, out = attach(tmp_path, rows, *words)
        printed, source = capsys.readouterr().out, source_of(out)
        assert code == DONE and not source["includes_munk_moment"]
        assert (source["reference_density"], source["reference_point"]) == (1025.0, [0.1, 0.0, -0.2])
        rates = source["rates"] if source["kind"] == "angle_table" else source["lateral"]["rates"]
        share = 1025.0 / former.reference_density
        assert rates["roll_roll"] == pytest.approx(share * former.lateral.rates.roll_roll)
        assert f"scaled from {former.reference_density:g} to 1025 kg/m3" in printed
    assert source["lateral"]["yaw_sideslip"] == pytest.approx(share * former.lateral.yaw_sideslip)


def test_attach_over_one_angle_tells_what_is_lost_of_a_table_over_both(tmp_path, capsys):
    _, out = attach(tmp_path, TWO_ANGLES)
    code, again = attach(tmp_path, ONE_ANGLE, source=source_of(out))
    printed, source = capsys.readouterr().out, source_of(again)
    assert code == DONE and "lost        side force, roll and yaw by sideslip" in printed
    assert source["lateral"]["rates"]["yaw_yaw"] != 0.0 == source["lateral"]["yaw_sideslip"]


@pytest.mark.parametrize("rows", [TWO_ANGLES, ONE_ANGLE])
def test_attach_tells_that_rates_of_the_coefficient_form_are_left_out(tmp_path, capsys, rows):
    former = json.loads(load_preset("seawing-spiral").to_json())["vehicle"]["hydrodynamics"]
    assert attach(tmp_path, rows, source=former)[0] == DONE
    assert "left out    rate terms of 'Seawing, Zhang et al. 2013'" in capsys.readouterr().out


@pytest.mark.parametrize("speed", ["abc", "0", "-1", "nan", "inf"])
def test_attach_refuses_what_is_no_speed(tmp_path, capsys, speed):
    with pytest.raises(SystemExit) as left:
        attach(tmp_path, TWO_ANGLES, f"--speed={speed}")
    assert left.value.code == MISUSED and f"{speed!r} is neither a speed above 0" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("rows", "kind", "words", "says"),
    [
        (TWO_ANGLES, "forces", ("--source", "x" * 4001), "/source: String should have at most 4000 characters"),
        (ONE_ANGLE, "forces", ("--source", "x" * 4001), "/source: String should have at most 4000 characters"),
        (ONE_ANGLE, "forces", ("--reference-density", "0"), "/reference_density: Input should be greater"),
        (["depth,temperature", "0,9", "9,8"], "water", (), "no latitude (give --latitude: pressure"),
        (
            ["alpha_deg,beta_deg,lift", "0,0,0"],
            "forces", (), "wanted are speed, alpha_deg, beta_deg, X, Y, Z, K, M, N; its header has alpha_deg, beta_deg",
        ),
        (["alpha_deg", "0"], "forces", (), "wanted are speed, alpha_deg, lift, drag, moment; its header has alpha_deg"),
        (["depth (ft),density", "0,1000"], "density", (), "column depth is in 'ft', wanted is m (convert it"),
        ([*TWO_ANGLES, "0.6,0,0,0,0,0,0,0,0"], "forces", (), "(pick one by --speed, or --speed mean)"),
    ],
)  # fmt: skip
def test_what_cannot_be_attached_is_one_line(tmp_path, capsys, rows, kind, words, says):
    assert attach(tmp_path, rows, *words, kind=kind)[0] == REFUSED
    told = capsys.readouterr().err
    assert told.count("\n") == 1 and says in told and "/: " not in told


def test_simulate_tells_of_a_spatial_run(tmp_path, capsys):
    path = tmp_path / "spiral.json"
    path.write_text(load_preset("quad-bellows-spiral").to_json())
    assert main(["simulate", str(path)]) == DONE
    printed = capsys.readouterr().out
    assert re.search(r"roll -?1\d\.\d+ deg, heading .* turning .*radius 1\d\.\d+ m", printed)
    assert re.search(r"energy      [\d.]+ J, \d+ J/km: hotel 2880.0 J, Front port cell [\d.]+ J", printed)
