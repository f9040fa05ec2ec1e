"""The commands that analyse a design: summaries, the API's own answers, pictures, and errors in one line."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from models.limits import DEFAULT_LIMITS
from models.presets import load_preset
from models.simulate import simulate
from server.schemas_analyses import AllocationAnswer, PolarAnswer, TrimAnswer
from server.schemas_linear import LinearizeAnswer, StabilityAnswer
from studio import commands_analyses
from studio.__main__ import main
from studio.exit_codes import DONE, MISUSED, REFUSED, STOPPED

STEEP = ["--target", "glide_angle=-25deg", "--target", "speed=0.3"]
LOCUS = "/vehicle/damping/roll"


@pytest.fixture
def quad(tmp_path: Path) -> str:
    path = tmp_path / "quad.json"
    path.write_text(load_preset("quad-bellows-spiral").to_json())
    return str(path)


@pytest.mark.parametrize(
    ("command", "says"),
    [
        (["trim", *STEEP], ["glide: 0.3000 m/s, path -25.00 deg", "stable", "extensions Front port cell"]),
        (["trim", "--angle-step", "4deg", "--bank", "20deg", "--depth", "30"], ["trim        ", "searched    "]),
        (
            ["polar", "--points", "8", "--cycle-depth", "60", "--depth", "30"],
            ["curve", "best range", "J/km", "cycle to 60 m"],
        ),
        (
            ["linearize", *STEEP, "--bode", "command of Front port cell", "theta", "--frequency", "0.1", "1"],
            ["mode        pitch oscillation", "the cells can move every mode", "gain at rest"],
        ),
        (
            ["linearize", *STEEP, "--locus", LOCUS, "0", "5"],
            ["about       glide: 0.3000 m/s"],
        ),
        (["linearize", "--time", "500"], ["mode        spiral"]),
        (
            ["stability", "--samples", "10"],
            ["status      completed: ", "worst       hydrostatic_margin", "worst       growth"],
        ),
        (
            [
                "allocate", "--want", "heave=2", "--want", "pitch=0.5", "--weight", "pitch=2",
                "--effort", "Front port cell=3",
            ],
            ["can each be held apart", "all that is wanted is reached"],
        ),
    ],
)  # fmt: skip
def test_summaries(quad, capsys, command, says):
    assert main([command[0], quad, *command[1:]]) == DONE
    printed = capsys.readouterr().out
    for words in says:
        assert words in printed


@pytest.mark.parametrize(
    ("command", "model"),
    [
        (["trim"], TrimAnswer), (["polar", "--points", "4"], PolarAnswer), (["linearize", *STEEP], LinearizeAnswer),
        (["stability", "--samples", "5"], StabilityAnswer), (["allocate"], AllocationAnswer),
    ],
)  # fmt: skip
def test_json_is_the_answer_of_the_api(quad, capsys, command, model):
    assert main([command[0], quad, *command[1:], "--json"]) == DONE
    model.model_validate(json.loads(capsys.readouterr().out))


@pytest.mark.parametrize(
    "command",
    [
        ["polar", "--points", "8"],
        ["linearize", *STEEP, "--bode", "command of Front port cell", "theta", "--locus", LOCUS, "0", "5"],
        ["stability", "--samples", "10"],
    ],
)  # fmt: skip
def test_pictures(quad, tmp_path, command):
    for suffix, begins in (("png", b"\x89PNG"), ("svg", b"<?xml")):
        path = tmp_path / f"picture.{suffix}"
        assert main([command[0], quad, *command[1:], "--plot", str(path)]) == DONE
        assert path.read_bytes().startswith(begins) and path.stat().st_size > 10_000


@pytest.mark.parametrize(
    ("command", "says"),
    [
        (["trim", "--extension", "Tail=0.1"], "/options/extensions/Tail"),
        (["polar", "--extension", "Tail=0.1"], "/options/extensions/Tail"),
        (["polar", "--depth", "500"], "/options/depth"),
        (["polar", "--cell", "Tail"], "/options/cells/0"),
        (["linearize", "--time", "1e6"], "/options/time"),
        (["stability", "--samples", "1"], "/options/samples"),
        (["allocate", "--want", "lift=2"], "/options/wanted/lift"),
        (["allocate", "--weight", "lift=2"], "/options/weights/lift"),
        (["allocate", "--effort", "Tail/1=2"], "/options/effort/Tail~11"),
        (["linearize", *STEEP, "--locus", "/name", "1"], "/options/locus/pointer"),
    ],
)
def test_errors_are_a_line_with_their_place(quad, capsys, command, says):
    assert main([command[0], quad, *command[1:]]) == REFUSED
    told = capsys.readouterr().err
    assert told.count("\n") == 1 and says in told


@pytest.mark.parametrize(
    ("command", "says"),
    [
        (["polar", "--plot", "polar.xyz"], ".png, .svg or .pdf"),
        (["linearize", "--locus", LOCUS, "abc"], "'abc' is not a finite number"),
        (["linearize", "--locus", LOCUS], "no number after"),
        (["linearize", "--frequency", "1", "nan"], "'nan' is not a finite number"),
        (["trim", "--bank", "steep"], "'steep' is not a finite number"),
        (["trim", "--depth", "inf"], "'inf' is not a finite number"),
        (["trim", "--depth", "20deg"], "'20deg' is not a finite number"),
        (["trim", "--target", "speed=0.2", "--target", "speed=0.3"], "'speed' is given twice"),
        (["polar", "--extension", "a=0.2", "--extension", "a=0.2"], "'a' is given twice"),
        (["allocate", "--want", "heave=1", "--want", "heave=2"], "'heave' is given twice"),
    ],
)
def test_a_wrong_command_line_is_told_before_anything_is_computed(capsys, command, says):
    with pytest.raises(SystemExit) as stopped:
        main([command[0], "no such file", *command[1:]])
    assert stopped.value.code == MISUSED
    assert says in capsys.readouterr().err


def test_no_motion_as_wanted_is_an_exit_code(quad, capsys):
    wanted = ["--target", "speed=3", "--free", "Front port cell"]
    assert main(["trim", quad, *wanted]) == REFUSED
    assert "no trim     the stops do not allow it" in capsys.readouterr().out
    assert main(["trim", quad, *wanted, "--json"]) == REFUSED
    assert json.loads(capsys.readouterr().out)["failure"]["active"]
    assert main(["linearize", quad, *wanted]) == REFUSED


def test_angles_may_be_negative_degrees_and_powers_of_ten(quad, capsys):
    locus = ["--locus", "/vehicle/components/0/position/0", "-1e-3", "1e-3"]
    assert main(["linearize", quad, *STEEP, *locus, "--json"]) == DONE
    assert json.loads(capsys.readouterr().out)["locus"]["values"] == [-1e-3, 1e-3]


def test_a_glider_that_floats_is_told_how_to_name_a_motion(tmp_path, capsys):
    path = tmp_path / "floats.json"
    path.write_text(load_preset("three-cell-glider").to_json())
    assert main(["linearize", str(path)]) == REFUSED
    told = capsys.readouterr().err
    assert "--target" in told and "--time" in told
    assert main(["design-controller", str(path)]) == REFUSED
    told = capsys.readouterr().err
    assert "/options/trim/extensions" in told and "--target" in told
    assert main(["linearize", str(path), "--target", "glide_angle=-25deg"]) == DONE
    assert main(["linearize", str(path), "--time", "100"]) == DONE


def test_the_command_line_flies_the_whole_mission_and_says_when_it_could_not(quad, capsys, monkeypatch):
    """A preview's time is for answers at once: here nothing is left out, and a run that is cut off is told."""
    monkeypatch.setenv("GLIDER_STUDIO_PREVIEW_SECONDS", "1e-9")
    assert main(["stability", quad, "--samples", "5", "--json"]) == DONE
    assert json.loads(capsys.readouterr().out)["status"] == "completed"

    def cut_off(design):
        return simulate(design, limits=replace(DEFAULT_LIMITS, steps=20))

    monkeypatch.setattr(commands_analyses, "simulate_with_progress", cut_off)
    assert main(["stability", quad, "--samples", "5"]) == STOPPED
    assert "status      too_many_steps: " in capsys.readouterr().out


@pytest.mark.parametrize("text", ["speed", "speed=fast", "=3", "speed=inf"])
def test_a_target_is_a_name_and_a_number(quad, capsys, text):
    with pytest.raises(SystemExit) as stopped:
        main(["trim", quad, "--target", text])
    assert stopped.value.code == MISUSED
    assert "is not NAME=VALUE" in capsys.readouterr().err
