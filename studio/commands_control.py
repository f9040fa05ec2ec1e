"""Owns the command that designs a controller: what it promises, the flown step, and files to go on with."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from models.controller_design import ControllerDesign
from models.design import Design
from models.limits import DEFAULT_LIMITS
from models.loop_suggestion import LoopSuggestion
from models.problems import DesignError
from server.controlling import Result, answer_of, design_for, file_of
from server.schemas_control import ControllerDesignOptions
from studio import pictures
from studio.commands import complain, load
from studio.commands_analyses import read_options
from studio.exit_codes import DONE, MISUSED, REFUSED, UNUSABLE

ENDINGS = (".json", ".mat", ".py")
LONGEST_FLIGHT = 600.0
"""Length of the mission that is written where no step says how long, s."""


def design_controller(options: argparse.Namespace) -> int:
    """Design the controller that a command line asks for; return its exit code."""
    for path in options.output or ():
        if path.suffix not in ENDINGS:
            complain(path, f"a controller is written as {', '.join(ENDINGS)}, not '{path.suffix}'")
            return MISUSED
    design = load(options.design)
    if isinstance(design, int):
        return design
    try:
        result = design_for(design, read_options(ControllerDesignOptions, _values(options)), DEFAULT_LIMITS)
        print(answer_of(result).model_dump_json()) if options.json else _summarise(result, design)
        for path in options.output or ():
            path.write_bytes(
                _under_control(result, design, options) if path.suffix == ".json" else file_of(result, path.suffix)
            )
            print(f"written     {path}", file=sys.stderr if options.json else sys.stdout)
        if options.plot is not None:
            _draw(result, design, options.plot)
    except DesignError as error:
        complain(options.design, error.problems)
        return REFUSED
    except OSError as error:
        complain(error.filename or options.plot, error.strerror or str(error))
        return UNUSABLE
    return DONE


def _values(options: argparse.Namespace) -> dict[str, Any]:
    values: dict[str, Any] = {
        "kind": options.kind, "sample_time": options.sample_time, "delay": options.delay, "states": options.state,
        "cells": options.cell, "share": options.share, "integrals": options.integrals,
        "deviations": dict(options.deviation or ()),
        "trim": {
            "targets": dict(options.target or ()), "extensions": dict(options.extension or ()),
            "free": options.free, "depth": options.depth,
        },
    }  # fmt: skip
    if options.pole:
        values |= {"method": "poles", "poles": [[pole.real, pole.imag] for pole in options.pole]}
    if options.step is not None:
        state, amount = options.step
        values["step"] = {"state": state, "amount": amount, "duration": options.duration}
    return values


def _summarise(result: Result, design: Design) -> None:
    print(f"design      {design.name}")
    if isinstance(result, LoopSuggestion):
        for name, loop in _loops(result):
            gains = f"P {loop.proportional:.5g}, I {loop.integral:.5g}, D {loop.derivative:.5g}"
            print(f"{name:<11} {gains}, limit {loop.limit:.5g}")
        print(f"settles     in {result.settling_time:.4g} s by the linear model, damping {result.damping:.3f}")
        for note in result.notes:
            print(f"note        {note}")
        return
    for each in (result,) if isinstance(result, ControllerDesign) else result.designs:
        _summarise_feedback(each)
    for warning in result.warnings:
        print(f"warning     {warning}")


def _loops(result: LoopSuggestion) -> list[tuple[str, Any]]:
    lateral = result.cascade.lateral
    loops: list[tuple[str, Any]] = [("pitch loop", result.cascade.pitch.loop)]
    return loops if lateral is None else [*loops, ("roll loop", lateral.roll_loop), ("heading", lateral.heading_loop)]


def _summarise_feedback(result: ControllerDesign) -> None:
    print(f"about       {result.problem.point.speed:.4f} m/s, pitch {result.problem.point.pitch:+.4f} rad")
    print(f"fed back    {', '.join(result.problem.states)}; {'stable' if result.stable else 'NOT stable'}")
    for cell, row in zip(result.problem.cells.cells, result.gains, strict=True):
        print(f"gains       {cell}: {', '.join(f'{gain:+.4g}' for gain in row)}")
    for mode in result.closed_loop.modes:
        period = "" if mode.period is None else f", period {mode.period:.4g} s, damping {mode.damping_ratio:.3f}"
        print(f"closed      {mode.name}: {mode.growth:+.4g} 1/s{period}")
    if result.margins is not None:
        print(f"margins     {result.margins}")
    if result.response is not None:
        print(f"step        {result.response.state}, linear: {result.response.predicted}")
        print(f"            flown: {result.response.flown}")


def _under_control(result: Result, design: Design, options: argparse.Namespace) -> bytes:
    """Return the design document with the controller: from its trim, or, of loops, in the mission as it is."""
    if isinstance(result, LoopSuggestion):
        control = design.mission.control.model_copy(update={"controller": result.cascade, "schedules": ()})
        mission = design.mission.model_copy(update={"control": control})
        return design.model_copy(update={"mission": mission}).to_json().encode()
    length = options.duration if options.step is not None else LONGEST_FLIGHT
    return result.mission(duration=length).to_json().encode()


def _draw(result: Result, design: Design, path: Path) -> None:
    if not isinstance(result, ControllerDesign) or result.response is None:
        raise OSError(0, "there is no step to draw: ask for one with --step", str(path))
    pictures.step(result.response, design, path)
    print(f"written     {path}", file=sys.stderr)
