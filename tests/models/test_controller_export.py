"""Exports of designed controllers read back to the same numbers, and the script computes what the library does."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import loadmat

from models.controller_design import ControllerDesign
from models.controller_export import to_control, to_mat, to_script
from models.design import parse_design
from tests.models.design_support import designed, uniform

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def result() -> ControllerDesign:
    """With everything that an export must keep: a delay between samples, integrals, a step."""
    return designed(
        sample_time=0.8, delay=1.0, integrals=1, share=0.1, step={"state": "theta", "amount": 4e-3, "duration": 40.0}
    )


def run_script(path: Path, *options: str) -> str:
    """Run a script apart, from elsewhere; the program is on its path only to fly."""
    environment = {"PYTHONPATH": str(ROOT)} if "--fly" in options else {}
    command = [sys.executable, str(path), *options]
    return subprocess.run(
        command, check=True, capture_output=True, text=True, cwd=path.parent, env=environment, timeout=120.0
    ).stdout  # fmt: skip


def test_a_mat_file_reads_back(result: ControllerDesign, tmp_path: Path):
    to_mat(result, tmp_path / "design.mat")
    back = loadmat(tmp_path / "design.mat")
    problem, sampled = result.problem, result.problem.whole()
    for name, value in (("A", problem.model.A), ("B", problem.model.B), ("K", result.gains), ("F", sampled.F)):
        np.testing.assert_array_equal(back[name], value)
    np.testing.assert_array_equal(back["e0"][:, 0], problem.extensions)
    assert [str(cell[0]) for cell in back["states"][:, 0]] == list(problem.model.state_names)
    assert [str(cell[0]) for cell in back["state_units"][:, 0]] == [s.unit for s in problem.model.states]
    assert [str(cell[0]) for cell in back["fed_back"][:, 0]] == list(problem.states)
    assert float(back["sample_time"][0, 0]) == 0.8 and float(back["integrals"][0, 0]) == 1.0
    # the loop from the file alone has the eigenvalues in the file
    wide = np.zeros_like(back["G"].T)
    n, fed = len(back["A"]), len(back["fed_back"])
    wide[:, :fed], wide[:, n : n + 1] = back["K"][:, :fed], back["K"][:, fed:]
    own = np.linalg.eigvals(back["F"] - back["G"] @ wide)
    np.testing.assert_allclose(np.sort(np.abs(own)), np.sort(np.abs(back["closed_loop_z"][:, 0])), atol=1e-9)
    assert back["C"].shape == (len(back["outputs"]), n) and back["D"].shape == (
        len(back["outputs"]),
        len(back["cells"]),
    )


def test_python_controls_systems_have_labels_and_the_same_matrices(result: ControllerDesign):
    import control  # loading it takes a second and a half

    plant, closed = to_control(result), to_control(result, "closed")
    np.testing.assert_array_equal(plant.A, result.problem.model.A)
    assert tuple(plant.state_labels) == result.problem.model.state_names
    assert tuple(plant.input_labels) == result.problem.model.input_names
    assert closed.dt == 0.8 and isinstance(closed, control.StateSpace)
    rates = sorted(mode.growth for mode in result.closed_loop.modes for _ in range(1 + mode.oscillates))
    z = np.maximum(np.abs(closed.poles()), 1e-12)
    np.testing.assert_allclose(sorted(np.log(z) / 0.8)[-10:], rates[-10:], atol=1e-7)
    assert to_control(result, "sampled").nstates == closed.nstates


def test_the_script_computes_what_the_library_does(result: ControllerDesign, tmp_path: Path):
    path = tmp_path / "loop.py"
    to_script(result, path)
    told: dict[str, Any] = json.loads(run_script(path, "--json", "--fly"))
    response = result.response
    np.testing.assert_allclose(told["times"], response.times, atol=1e-12)
    np.testing.assert_allclose(told["linear"], response.predicted_state, rtol=0, atol=1e-12)
    np.testing.assert_allclose(told["commands"], response.commands, rtol=0, atol=1e-12)
    # the same kernel on the same design
    np.testing.assert_allclose(told["flown"], response.flown_state, rtol=0, atol=1e-12)
    z = np.array([complex(*value) for value in told["eigenvalues"]])
    growth = np.log(np.abs(z).max()) / 0.8
    assert growth == pytest.approx(max(mode.growth for mode in result.closed_loop.modes), abs=1e-9)


def test_the_script_alone_prints_a_table(result: ControllerDesign, tmp_path: Path):
    to_script(result, tmp_path / "loop.py")
    lines = run_script(tmp_path / "loop.py").splitlines()
    assert lines[0].startswith("largest eigenvalue of the sampled loop: 0.9")
    first, value = lines[2].split()
    assert float(first) == 0.0 and float(value) == pytest.approx(result.response.start, abs=1e-6)


def test_the_script_rebuilds_python_controls_systems(result: ControllerDesign):
    names: dict[str, Any] = {"__name__": "loop"}
    exec(to_script(result), names)
    np.testing.assert_array_equal(names["plant"]().A, result.problem.model.A)
    np.testing.assert_allclose(names["closed_loop"]().A, to_control(result, "closed").A, atol=1e-14)


def test_names_cannot_break_out_of_the_script():
    document = uniform().model_dump(mode="json")
    document["name"] = 'Odd """ \\ @A@ name'
    named = json.dumps(document).replace("Front port cell", r"@K@ 'cell' \"x\"")
    result = designed(parse_design(json.loads(named)))
    names: dict[str, Any] = {"__name__": "loop"}
    exec(to_script(result), names)
    assert names["CELLS"] == list(result.problem.cells.cells)
    json.dumps(result.as_dict(), allow_nan=False)
