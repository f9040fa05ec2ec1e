"""Owns the commands that analyse a design: trim, polar, linearize, stability, allocate.

Each prints a summary, or with --json the answer of the REST API, and draws a picture where asked.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from models.assemble import Assembly, assemble
from models.design import Design
from models.limits import DEFAULT_LIMITS
from models.problems import DesignError, problems_from_validation
from models.simulate import Control
from server import analyses
from server import schemas_analyses as wire
from server import schemas_linear as small
from server.preview import PreviewRun
from studio import pictures
from studio.commands import WHOLE, complain, load, simulate_with_progress
from studio.exit_codes import DONE, REFUSED, STOPPED, UNUSABLE

DEGREES = 180.0 / math.pi
Printer = Callable[[Any], None]


def run_analysis(options: argparse.Namespace) -> int:
    """Do the analysis that a command line asks for; return its exit code."""
    design = load(options.design)
    if isinstance(design, int):
        return design
    work, printer, picture = ANALYSES[options.command]
    try:
        answer = work(assemble(design), options)
        if options.json:
            print(answer.model_dump_json())
        else:
            print(f"design      {design.name}")
            printer(answer)
        if options.plot is not None and picture is not None:
            picture(answer, design, options.plot)
            print(f"written     {options.plot}", file=sys.stderr if options.json else sys.stdout)
    except DesignError as error:
        complain(options.design, error.problems)
        return REFUSED
    except OSError as error:
        complain(options.plot, error.strerror or str(error))
        return UNUSABLE
    return _code_of(answer)


def _code_of(answer: BaseModel) -> int:
    """Return the exit code of an answer: it may be that there is no motion as wanted, or that the run was cut off."""
    if isinstance(answer, wire.TrimAnswer) and answer.failure is not None:
        return REFUSED
    if isinstance(answer, small.StabilityAnswer) and answer.status not in {status.name for status in WHOLE}:
        return STOPPED
    return DONE


def read_options(model: type[Any], values: Mapping[str, Any]) -> Any:
    """Return the options as a wire type; raises `DesignError` where one is not what it may be, below /options."""
    given = {name: value for name, value in values.items() if value is not None}
    try:
        return model.model_validate(given)
    except ValidationError as error:
        told = problems_from_validation(error, given)
        raise DesignError(replace(p, pointer=f"/options{p.pointer}") for p in told) from None


def _trim_values(options: argparse.Namespace) -> dict[str, Any]:
    return {
        "extensions": options.extension, "targets": options.target, "free": options.free, "depth": options.depth,
        "search": {"angle_step": options.angle_step, "banks": options.bank},
    }  # fmt: skip


def _fly(assembly: Assembly) -> Callable[[], PreviewRun]:
    """Return what flies the whole mission, without the limits of a preview."""

    def fly() -> PreviewRun:
        run = simulate_with_progress(assembly.design)
        return PreviewRun(run, run.message, ())

    return fly


def _trim(assembly: Assembly, options: argparse.Namespace) -> wire.TrimAnswer:
    return analyses.trim_answer(assembly, read_options(wire.TrimOptions, _trim_values(options)))


def _polar(assembly: Assembly, options: argparse.Namespace) -> wire.PolarAnswer:
    values = {
        "points": options.points, "cells": options.cell, "cycle_depth": options.cycle_depth,
        "extensions": options.extension, "depth": options.depth,
    }  # fmt: skip
    return analyses.polar_answer(assembly, read_options(wire.PolarOptions, values))


def _linearize(assembly: Assembly, options: argparse.Namespace) -> small.LinearizeAnswer:
    values = _trim_values(options) | {
        "time": options.time,
        "frequencies": options.frequency,
        "responses": [{"input": source, "output": target} for source, target in options.bode or ()],
    }
    if options.locus is not None:
        pointer, over = options.locus
        values["locus"] = {"pointer": pointer, "values": over}
    chosen = read_options(small.LinearizeOptions, values)
    return analyses.linearize_answer(assembly, chosen, _fly(assembly), limits=DEFAULT_LIMITS, control=Control())


def _stability(assembly: Assembly, options: argparse.Namespace) -> small.StabilityAnswer:
    chosen = read_options(small.StabilityOptions, {"samples": options.samples, "max_points": 100_000})
    return analyses.stability_answer(assembly, chosen, _fly(assembly))


def _allocate(assembly: Assembly, options: argparse.Namespace) -> wire.AllocationAnswer:
    values = {
        "cells": options.cell, "depth": options.depth, "wanted": options.want, "weights": options.weight,
        "effort": options.effort,
    }  # fmt: skip
    return analyses.allocation_answer(assembly, read_options(wire.AllocationOptions, values))


def _deg(angle: float) -> str:
    return f"{angle * DEGREES:+.2f} deg"


def trim_line(trim: wire.TrimItem) -> str:
    """Return a steady motion in a line."""
    turn = "" if trim.turn_radius is None else f", radius {trim.turn_radius:+.4g} m ({_deg(trim.turn_rate)}/s)"
    return (
        f"{trim.kind}: {trim.speed:.4f} m/s, path {_deg(trim.glide_angle)}, pitch {_deg(trim.pitch)}, roll "
        f"{_deg(trim.roll)}, attack {_deg(trim.angle_of_attack)}, sinks {trim.sink_rate:.4f} m/s{turn}, "
        f"{'stable' if trim.stable else 'unstable'} (growth {trim.growth:+.3g} 1/s)"
    )


def _print_extensions(extensions: Mapping[str, float]) -> None:
    print(f"            extensions {', '.join(f'{name} {value:.5g}' for name, value in extensions.items())}")


def _print_trim(answer: wire.TrimAnswer) -> None:
    for trim in answer.trims:
        print(f"trim        {trim_line(trim)}")
        _print_extensions(trim.extensions)
    if answer.searched is not None:
        print(f"searched    {answer.searched}")
    if answer.failure is not None:
        print(f"no trim     {answer.failure.message}")


def _print_polar(answer: wire.PolarAnswer) -> None:
    for curve in answer.curves:
        speeds = [trim.speed for trim in curve.trims]
        reach = f"{min(speeds):.3f} to {max(speeds):.3f} m/s" if speeds else "no glide"
        print(f"curve       heave {curve.heave:+.4g} N: {len(curve.trims)} glides, {reach}")
    named = {"best range": answer.best_range, "slow sink": answer.slowest_sink, "turn": answer.tightest_turn}
    for name, trim in named.items():
        print(f"{name:<11} {'none' if trim is None else trim_line(trim)}")
        if trim is not None:
            _print_extensions(trim.extensions)
    best = answer.best_energy
    if best is not None:
        print(
            f"energy      {best.per_km:.0f} J/km ({best.hotel:.0f} hotel, {best.pump:.0f} pump): {trim_line(best.trim)}"
        )
        _print_extensions(best.trim.extensions)
    print(f"            {answer.energy}")


def _print_linear(answer: small.LinearizeAnswer) -> None:
    if answer.trim is not None:
        print(f"about       {trim_line(answer.trim)}")
    for mode in answer.modes.modes:
        takes = sorted(zip(mode.shares, answer.modes.states, strict=True), reverse=True)[:3]
        period = "" if mode.period is None else f", period {mode.period:.4g} s, damping {mode.damping_ratio:.3f}"
        constant = "" if mode.time_constant is None else f", time constant {mode.time_constant:.4g} s"
        shares = ", ".join(f"{name} {share:.0%}" for share, name in takes if share >= 0.05)
        print(f"mode        {mode.name}: {mode.real:+.5g} 1/s{period}{constant} ({shares})")
    print(f"cells       {answer.controllability.words}")
    for response in answer.responses:
        gain = "runs away" if response.dc_gain is None else f"{response.dc_gain:.4g} {response.unit}"
        print(f"response    {response.input} to {response.output}: gain at rest {gain}")
    for crossing in answer.locus.crossings if answer.locus else ():
        side = "stable" if crossing.becomes_stable else "unstable"
        print(f"crossing    {crossing.name} becomes {side} at {crossing.value:.6g}")


def _print_stability(answer: small.StabilityAnswer) -> None:
    print(f"status      {answer.status}: {answer.message}")
    for extreme in answer.extremes:
        print(f"worst       {extreme.name} {extreme.value:+.5g} {extreme.unit} at {extreme.time:.2f} s")
    for warning in answer.warnings:
        print(f"warning     {warning.message}")


def _print_allocation(answer: wire.AllocationAnswer) -> None:
    print(f"cells       {answer.words}; singular values {', '.join(f'{v:.4g}' for v in answer.singular_values)}")
    units = {"heave": "N", "pitch": "N m", "roll": "N m"}
    for axis, (low, high) in answer.alone.items():
        print(f"alone       {axis} {low:+.4g} to {high:+.4g} {units[axis]}, the others at zero")
    for name, unit, column in zip(answer.cells, answer.units, zip(*answer.matrix, strict=True), strict=True):
        effects = ", ".join(f"{axis} {v:+.4g} {units[axis]}/{unit}" for axis, v in zip(units, column, strict=True))
        print(f"effect      {name}: {effects}")
    if answer.allocation is not None:
        _print_extensions(answer.allocation.extensions)
        print(f"wanted      {answer.allocation.message}")


Work = Callable[[Assembly, argparse.Namespace], BaseModel]
ANALYSES: dict[str, tuple[Work, Printer, Callable[[Any, Design, Path], None] | None]] = {
    "trim": (_trim, _print_trim, None),
    "polar": (_polar, _print_polar, pictures.polar),
    "linearize": (_linearize, _print_linear, pictures.linear),
    "stability": (_stability, _print_stability, pictures.stability),
    "allocate": (_allocate, _print_allocation, None),
}
