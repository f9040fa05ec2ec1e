"""The command that designs a controller: its summary, the files it writes, and errors in one line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from models.design import load_design
from models.presets import load_preset
from models.simulate import simulate
from server.schemas_control import DesignedController
from studio.__main__ import main
from studio.exit_codes import DONE, MISUSED, REFUSED

DIVE = ["--target", "glide_angle=-0.5", "--target", "speed=0.2", "--depth", "30"]
FEW = [*DIVE, "--state", "theta", "--state", "q", "--state", "w", "--state", "u"]


@pytest.fixture
def quad(tmp_path: Path) -> str:
    path = tmp_path / "quad.json"
    path.write_text(load_preset("quad-bellows-glide").to_json())
    return str(path)


def test_a_step_is_flown_and_files_go_on_with_it(quad, tmp_path, capsys):
    names = ["controlled.json", "design.mat", "design.py"]
    files = [word for name in names for word in ("-o", str(tmp_path / name))]
    step = ["--step", "theta=0.01", "--duration", "60", "--plot", str(tmp_path / "step.png")]
    assert main(["design-controller", quad, *FEW, *step, *files]) == DONE
    printed = capsys.readouterr().out
    for words in ("fed back    theta, q, w, u; stable", "gains       Front port cell", "margins", "flown: rises in"):
        assert words in printed
    run = simulate(load_design(tmp_path / "controlled.json"))
    assert run.status.name == "completed" and run.times[-1] == 60.0
    assert abs(run.final["theta"] - run.values["theta"][0]) < 1e-3  # it starts in its trim, and stays
    assert (tmp_path / "design.mat").read_bytes().startswith(b"MATLAB 5.0")
    compile((tmp_path / "design.py").read_text(), "design.py", "exec")
    assert (tmp_path / "step.png").stat().st_size > 10_000


def test_first_gains_of_loops(quad, tmp_path, capsys):
    path = tmp_path / "loops.json"
    assert main(["design-controller", quad, *DIVE, "--kind", "cascade", "-o", str(path)]) == DONE
    printed = capsys.readouterr().out
    assert "pitch loop" in printed and "roll loop" in printed and "settles" in printed
    assert load_design(path).mission.control.controller.kind == "cascade"


def test_json_is_the_answer_of_the_api(quad, capsys):
    assert main(["design-controller", quad, *FEW, "--json"]) == DONE
    DesignedController.model_validate(json.loads(capsys.readouterr().out), strict=False)


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        ([*DIVE, "--state", "thetta"], REFUSED, "/options/states/0"),
        (["--target", "speed=9"], REFUSED, "/options/trim/targets"),
        ([*DIVE, "--sample-time", "0"], REFUSED, "/sample_time"),
        ([*FEW, "-o", "gains.xls"], MISUSED, ".json, .mat, .py"),
        ([*FEW, "--plot", "step.png"], MISUSED, "--step"),
        ([*DIVE, "--kind", "cascade", "-o", "a.mat"], MISUSED, "write .json"),
        ([*DIVE, "--table", "pitch", "-0.5", "-0.4", "-o", "a.py"], MISUSED, "write .json"),
        ([*DIVE, "--kind", "cascade", "--duration", "10"], MISUSED, "--duration"),
        ([*DIVE, "--kind", "cascade", "--state", "theta"], REFUSED, "/options/states"),
        ([*DIVE, "--kind", "cascade", "--integrals", "1"], REFUSED, "/options/integrals"),
        ([*FEW, "--cell-share", "Tail=0.1"], REFUSED, "/options/shares/Tail"),
        ([*FEW, "--integral-time", "0"], REFUSED, "/options/integral_time"),
        ([*FEW, "--heading", "200deg"], REFUSED, "/options/trim/heading"),
        ([*FEW, "--departure", "speed=0.1"], REFUSED, "/options/departures/speed"),
        ([*FEW, "--table", "speed", "0.2", "0.21", "--step", "theta=0.1"], REFUSED, "/options/step"),
    ],
)
def test_errors_are_a_line(quad, capsys, arguments, code, says):
    assert main(["design-controller", quad, *arguments]) == code
    told = capsys.readouterr().err
    assert told.count("\n") == 1 and says in told


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--deviation", "theta=1", "--deviation", "theta=2"], "'theta' is given twice"),
        (["--cell-share", "a=1", "--cell-share", "a=2"], "'a' is given twice"),
        (["--table", "pitch", "steep"], "'steep' is not a finite number"),
        (["--pole", "nan"], "'nan' is not a complex number"),
        (["--plot", "step.xyz"], ".png, .svg or .pdf"),
    ],
)
def test_a_wrong_command_line_is_told_before_anything_is_computed(capsys, arguments, says):
    with pytest.raises(SystemExit) as stopped:
        main(["design-controller", "no such file", *arguments])
    assert stopped.value.code == MISUSED
    assert says in capsys.readouterr().err


def test_the_way_back_and_a_heading(quad, tmp_path, capsys):
    picture = tmp_path / "back.svg"
    asked = ["--departure", "theta=0.5deg", "--duration", "40", "--heading", "30deg", "--plot", str(picture)]
    assert main(["design-controller", quad, *FEW, *asked, "--json"]) == DONE
    feedback = json.loads(capsys.readouterr().out)["feedback"]
    assert feedback["trim"]["yaw"] == pytest.approx(0.5236, abs=1e-4)
    recovery = feedback["recovery"]
    assert recovery["start"] - recovery["goal"] == pytest.approx(0.0087266, abs=1e-6)
    assert recovery["times"][-1] == 40.0 and recovery["status"] == "completed"
    assert picture.stat().st_size > 10_000


def test_a_table_over_a_target_in_degrees(quad, tmp_path, capsys):
    path = tmp_path / "table.json"
    few = [*FEW[2:], "--table", "glide_angle", "-28deg", "-26deg", "--cell-share", "Front port cell=0.1"]
    assert main(["design-controller", quad, *few, "-o", str(path)]) == DONE
    points = load_design(path).mission.control.controller.points
    assert [point.value for point in points] == pytest.approx([-0.48869, -0.45379], abs=1e-5)
