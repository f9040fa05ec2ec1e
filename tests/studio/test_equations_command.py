"""`glider-studio equations`: what it prints and writes, and its exit codes."""

from __future__ import annotations

import io
import json
import subprocess
import sys
from types import SimpleNamespace

import pytest

from models.presets import load_preset
from studio.__main__ import main
from studio.exit_codes import DONE, MISUSED, REFUSED, UNUSABLE


@pytest.fixture
def design_file(tmp_path):
    path = tmp_path / "glider.json"
    path.write_text(load_preset("canete-dual-bellows").to_json())
    return path


def test_text_has_every_component_and_the_whole_equation(design_file, capsys):
    assert main(["equations", str(design_file)]) == DONE
    printed = capsys.readouterr().out
    for title in ("0 Body (rigid)", "1 Front bellows (bellows)", "2 Rear bellows (bellows)"):
        assert f"\n{title}\n" in printed
    assert "M q'' + V + C q' + G = Q" in printed and "(M*g*l_gz + tau_bz)*sin(theta)" in printed


def test_numbers_take_the_place_of_symbols(design_file, capsys):
    assert main(["equations", str(design_file), "--numbers"]) == DONE
    printed = capsys.readouterr().out
    assert "0.0077126*sin(theta)" in printed and "F_b = F_b0 + F_b1 + F_b2 = 7.7126 N" in printed


def test_latex_is_a_whole_document_in_a_file(design_file, tmp_path, capsys):
    page = tmp_path / "equations.tex"
    assert main(["equations", str(design_file), "--format", "latex", "--output", str(page)]) == DONE
    assert capsys.readouterr().out == f"written     {page}\n"
    written = page.read_text()
    assert written.startswith(r"\documentclass") and written.endswith("\\end{document}\n")
    assert r"\begin{bmatrix}" in written


def test_standard_input(monkeypatch, capsys):
    content = load_preset("movable-mass-twin").to_json().encode()
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(content)))
    assert main(["equations", "-"]) == DONE
    assert "7 Lower ballast (rolling mass)" in capsys.readouterr().out


def test_what_cannot_be_used_is_one_line(design_file, tmp_path, capsys):
    assert main(["equations", str(tmp_path / "none.json")]) == UNUSABLE
    assert main(["equations", str(design_file), "-o", str(tmp_path / "no" / "page.txt")]) == UNUSABLE
    capsys.readouterr()
    document = json.loads(design_file.read_text())
    document["mission"]["duration"] = -1
    design_file.write_text(json.dumps(document))
    assert main(["equations", str(design_file)]) == REFUSED
    told = capsys.readouterr().err
    assert told.count("\n") == 1 and told.startswith(f"{design_file}: /mission/duration: ")
    with pytest.raises(SystemExit) as left:
        main(["equations", str(design_file), "--format", "word"])
    assert left.value.code == MISUSED


def test_other_commands_do_not_load_sympy(design_file):
    code = (
        "import sys; from studio.__main__ import main; main(['validate', sys.argv[1]]); print('sympy' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code, str(design_file)], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "False"
