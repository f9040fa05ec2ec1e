"""Owns the export of a designed controller: MATLAB's .mat, python-control's systems, and a script that stands alone."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from models.controller_design import ControllerDesign
from models.controller_script import packed, script_of
from models.loop_response import LoopResponse

Array = NDArray[np.float64]
SCRIPT_DEPARTURE, SCRIPT_DURATION = 0.02, 120.0
"""What a script shows of a design without a response: a departure of the first state (rad or m/s), and how long, s."""
Kind = Literal["plant", "sampled", "closed"]


def to_mat(result: ControllerDesign, path: Path | None = None) -> bytes:
    """Return the design as a MATLAB file (version 5), and write it to `path` where one is given.

    Holds A, B, C, D (continuous), F, G (sampled, with sums and delay), K, x0, e0 of the trim, names and units as cell
    arrays, `sample_time`, `delay` (s), `integrals`, and eigenvalues: `open_loop` (1/s), `closed_loop` (1/s, as if
    continuous) and `closed_loop_z`. Columns of K are `fed_back`, then the integrals of the first of them.
    """
    from scipy.io import savemat

    problem, model, sampled = result.problem, result.problem.model, result.problem.whole()
    shown = _outputs(result)
    z = np.linalg.eigvals(sampled.closed(problem.widened(result.gains)))
    content: dict[str, Any] = {
        "A": model.A, "B": model.B, "C": model.C[shown], "D": model.D[shown], "F": sampled.F, "G": sampled.G,
        "K": result.gains, "x0": np.array([[s.value] for s in model.states]), "e0": problem.extensions[:, None],
        "sample_time": sampled.sample_time, "delay": sampled.delay, "integrals": float(sampled.sums),
        "open_loop": np.linalg.eigvals(model.A)[:, None], "closed_loop_z": z[:, None],
        "closed_loop": (np.log(z.astype(np.complex128) + (z == 0.0) * 1e-300) / sampled.sample_time)[:, None],
        "states": _cells(model.state_names), "state_units": _cells([s.unit for s in model.states]),
        "inputs": _cells(model.input_names), "input_units": _cells([s.unit for s in model.inputs]),
        "outputs": _cells([model.output_names[i] for i in shown]),
        "output_units": _cells([model.outputs[i].unit for i in shown]),
        "fed_back": _cells(problem.states), "cells": _cells(problem.cells.cells),
        "sampled_states": _cells(sampled.states), "title": _title(result),
    }  # fmt: skip
    buffer = BytesIO()
    savemat(buffer, content, do_compression=True, oned_as="column")  # type: ignore[arg-type]
    if path is not None:
        path.write_bytes(buffer.getvalue())
    return buffer.getvalue()


def to_control(result: ControllerDesign, kind: Kind = "plant") -> Any:
    """Return a `control.StateSpace` with labels.

    `plant`: the glider about its trim, continuous; `sampled`: with the controller's sums and the delay, from commands
    to all states; `closed`: the same in closed loop, its inputs added to the commands. All are departures from trim.
    """
    import control

    problem, model, sampled = result.problem, result.problem.model, result.problem.whole()
    if kind == "plant":
        shown = _outputs(result)
        return control.ss(
            model.A, model.B, model.C[shown], model.D[shown], states=list(model.state_names),
            inputs=list(model.input_names), outputs=[f"output {model.output_names[i]}" for i in shown], name="plant",
        )  # fmt: skip
    F = sampled.F if kind == "sampled" else sampled.closed(problem.widened(result.gains))
    return control.ss(
        F, sampled.G, np.eye(len(F)), np.zeros(sampled.G.shape), sampled.sample_time, states=list(sampled.states),
        inputs=list(model.input_names), outputs=[f"output {name}" for name in sampled.states], name=kind,
    )  # fmt: skip


def to_script(result: ControllerDesign, path: Path | None = None) -> str:
    """Return a Python script that rebuilds the loop and prints its response, and write it to `path` where one is given.

    It needs NumPy and SciPy; python-control for its systems, glider-studio to fly the non-linear model. The response is
    the design's, or else the way back from a departure of the first state fed back.
    """
    response = result.response
    if response is None:
        by = {result.problem.states[0]: SCRIPT_DEPARTURE}
        response = result.departure(by, duration=SCRIPT_DURATION, fly=False)
    script = script_of(_values(result, response))
    if path is not None:
        path.write_text(script, encoding="utf-8")
    return script


def _values(result: ControllerDesign, response: LoopResponse) -> dict[str, Any]:
    """Return what goes into the script."""
    problem, model = result.problem, result.problem.model
    unit = model.states[response.states.index(response.state)].unit
    initial = response.design.mission.initial
    return {
        "TITLE": _title(result), "STEP": f"{response.state} from {response.start:.6g} to {response.goal:.6g} {unit}",
        "STATES": list(model.state_names), "FED_BACK": list(problem.states), "CELLS": list(problem.cells.cells),
        "STATE_UNITS": [signal.unit for signal in model.states], "INTEGRALS": problem.options.integrals,
        "SAMPLE_TIME": problem.options.sample_time, "DELAY": problem.options.delay, "WATCHED": response.state,
        "START": response.linear[0], "GOAL": response.goal_states, "E_GOAL": response.goal_extensions,
        "E_START": np.array([initial.extensions[cell] for cell in problem.cells.cells]), "SAMPLES": len(response.times),
        "A": model.A, "B": model.B, "K": result.gains, "DESIGN": packed(response.design.to_json().encode()),
    }  # fmt: skip


def _outputs(result: ControllerDesign) -> list[int]:
    """Return the outputs that the model still has: not depth or heading where they are held."""
    model = result.problem.model
    return [i for i, n in enumerate(model.output_names) if n not in ("z", "psi") or n in model.state_names]


def _title(result: ControllerDesign) -> str:
    problem = result.problem
    method = "least quadratic cost" if problem.options.method == "lqr" else "placed poles"
    name = "".join(letter for letter in problem.design.name if letter.isprintable() and letter not in '"\\')
    about = f"pitch {problem.point.pitch:.4g} rad and {problem.point.speed:.4g} m/s"
    return f"{name}: state feedback by {method} about {about}."


def _cells(names: Any) -> NDArray[Any]:
    array = np.empty((len(names), 1), dtype=object)
    array[:, 0] = list(names)
    return array
