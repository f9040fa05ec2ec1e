"""The commands that analyse a design: summaries, the API's own answers, pictures, and errors in one line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from models.presets import load_preset
from server.schemas_analyses import AllocationAnswer, PolarAnswer, TrimAnswer
from server.schemas_linear import LinearizeAnswer, StabilityAnswer
from studio.__main__ import main
from studio.exit_codes import DONE, MISUSED, REFUSED, UNUSABLE

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
        (["trim", "--target", "speed=3", "--free", "Front port cell"], ["no trim", "stop"]),
        (["polar", "--points", "8", "--cycle-depth", "60"], ["curve", "best range", "J/km", "cycle to 60 m"]),
        (
            ["linearize", *STEEP, "--bode", "command of Front port cell", "theta"],
            ["mode        pitch oscillation", "the cells can move every mode", "gain at rest"],
        ),
        (
            ["linearize", *STEEP, "--locus", LOCUS, "0", "5"],
            ["about       glide: 0.3000 m/s"],
        ),
        (["linearize", "--time", "500"], ["mode        spiral"]),
        (["stability", "--samples", "10"], ["worst       hydrostatic_margin", "worst       growth"]),
        (
            ["allocate", "--want", "heave=2", "--want", "pitch=0.5"],
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
        (["polar", "--cell", "Tail"], "/options/cells/0"),
        (["linearize", "--time", "1e6"], "/options/time"),
        (["stability", "--samples", "1"], "/samples"),
        (["allocate", "--want", "lift=2"], "/wanted/lift"),
    ],
)
def test_errors_are_a_line_with_their_place(quad, capsys, command, says):
    assert main([command[0], quad, *command[1:]]) == REFUSED
    told = capsys.readouterr().err
    assert told.count("\n") == 1 and says in told


def test_a_picture_of_no_known_kind_is_told(quad, tmp_path, capsys):
    assert main(["polar", quad, "--points", "4", "--plot", str(tmp_path / "polar.xyz")]) == UNUSABLE
    assert ".png, .svg or .pdf" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["speed", "speed=fast", "=3", "speed=inf"])
def test_a_target_is_a_name_and_a_number(quad, capsys, text):
    with pytest.raises(SystemExit) as stopped:
        main(["trim", quad, "--target", text])
    assert stopped.value.code == MISUSED
    assert "is not NAME=VALUE" in capsys.readouterr().err
