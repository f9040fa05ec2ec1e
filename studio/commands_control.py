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
from models.simulate import Control
from server.controlling import Result, answer_of, design_for, file_of
from server.schemas_control import ControllerDesignOptions
from studio import pictures
from studio.commands import complain, load
from studio.commands_analyses import read_options
from studio.exit_codes import DONE, MISUSED, REFUSED, UNUSABLE

ENDINGS = (".json", ".mat", ".py")
WATCHED, LONGEST_FLIGHT = 120.0, 600.0
"""How long a step is watched, and the mission that is written without one, where nothing else is said, s."""


def design_controller(options: argparse.Namespace) -> int:
    """Design the controller that a command line asks for; return its exit code."""
    wrong = _misused(options)
    if wrong is not None:
        complain(*wrong)
        return MISUSED
    design = load(options.design)
    if isinstance(design, int):
        return design
    try:
        chosen = read_options(ControllerDesignOptions, _values(options))
        result = design_for(design, chosen, DEFAULT_LIMITS, flown_within=DEFAULT_LIMITS, control=Control())
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


def _misused(options: argparse.Namespace) -> tuple[object, str] | None:
    """Return what of a command line cannot be done, and why, before anything is computed; None where all can."""
    about_one = options.kind == "state_feedback" and options.table is None
    for path in options.output or ():
        if path.suffix not in ENDINGS:
            return path, f"a controller is written as {', '.join(ENDINGS)}, not '{path.suffix}'"
        if path.suffix != ".json" and not about_one:
            return path, f"only a state feedback about one trim has a {path.suffix} file: write .json"
    if options.plot is not None and options.step is None and options.departure is None:
        return options.plot, "there is nothing to draw: ask for a --step or a --departure"
    if options.duration is not None and options.kind == "cascade":
        return "--duration", "loops go into the mission as it is: leave it out"
    return None


def _values(options: argparse.Namespace) -> dict[str, Any]:
    values: dict[str, Any] = {
        "kind": options.kind, "sample_time": options.sample_time, "delay": options.delay, "states": options.state,
        "cells": options.cell, "share": options.share, "shares": options.cell_share, "integrals": options.integrals,
        "integral_time": options.integral_time, "deviations": options.deviation, "departures": options.departure,
        "trim": {
            "targets": options.target or {}, "extensions": options.extension or {}, "free": options.free,
            "depth": options.depth, "heading": options.heading,
        },
    }  # fmt: skip
    if options.departure and options.duration is not None:
        values["recovery_duration"] = options.duration
    if options.table is not None:
        target, over = options.table
        values["table"] = {"target": target, "values": over}
    if options.pole:
        values |= {"method": "poles", "poles": [[pole.real, pole.imag] for pole in options.pole]}
    if options.step is not None:
        state, amount = options.step
        values["step"] = {"state": state, "amount": amount, "duration": _or(options.duration, WATCHED)}
    return values


def _or(given: float | None, usual: float) -> float:
    return usual if given is None else given


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
    if result.recovery is not None:
        print(f"way back    {result.recovery.state}, linear: {result.recovery.predicted}")
        print(f"            flown: {result.recovery.flown}")


def _under_control(result: Result, design: Design, options: argparse.Namespace) -> bytes:
    """Return the design document with the controller: from its trim, or, of loops, in the mission as it is."""
    if isinstance(result, LoopSuggestion):
        control = design.mission.control.model_copy(update={"controller": result.cascade, "schedules": ()})
        mission = design.mission.model_copy(update={"control": control})
        return design.model_copy(update={"mission": mission}).to_json().encode()
    usual = LONGEST_FLIGHT if options.step is None else WATCHED
    return result.mission(duration=_or(options.duration, usual)).to_json().encode()


def _draw(result: Result, design: Design, path: Path) -> None:
    drawn = result.response or result.recovery if isinstance(result, ControllerDesign) else None
    if drawn is None:
        return
    pictures.step(drawn, design, path)
    print(f"written     {path}", file=sys.stderr)
