"""Owns the commands that need no server: simulate, validate, presets. An error is one line with its JSON Pointer."""

from __future__ import annotations

import math
import sys
import threading
from pathlib import Path

from models.assemble import assemble
from models.design import Design, loads_design
from models.energy import energy_bill
from models.presets import load_preset, preset_ids
from models.problems import DesignError, Problem
from models.run import Run, Status
from models.run_warnings import run_warnings
from studio.exit_codes import DONE, MISUSED, REFUSED, STOPPED, UNUSABLE

WRITERS = {".nc": Run.to_netcdf, ".csv": Run.to_csv}
PROGRESS_EVERY = 0.5
WHOLE = frozenset({Status.completed, Status.surface, Status.bed})
"""How runs end that are not cut off."""


def complain(source: object, problems: tuple[Problem, ...] | str) -> None:
    """Print what is wrong on standard error, a line each."""
    for problem in (problems,) if isinstance(problems, str) else problems:
        print(f"{source}: {problem}".replace("\n", " "), file=sys.stderr)


def _read(path: Path) -> Design:
    content = sys.stdin.buffer.read() if str(path) == "-" else path.read_bytes()
    return loads_design(content)


def load(path: Path) -> Design | int:
    """Return the design, or the exit code after saying what is wrong."""
    try:
        design = _read(path)
        assemble(design)
    except DesignError as error:
        complain(path, error.problems)
        return REFUSED
    except OSError as error:
        complain(path, error.strerror or str(error))
        return UNUSABLE
    return design


def simulate_with_progress(design: Design) -> Run:
    """Simulate in a thread, so that an interrupt stops the run and keeps what it has."""
    from models.simulate import Control, simulate

    control = Control()
    finished: list[Run] = []
    worker = threading.Thread(target=lambda: finished.append(simulate(design, control=control)))
    worker.start()
    shown = False
    while worker.is_alive():
        try:
            worker.join(PROGRESS_EVERY)
        except KeyboardInterrupt:
            control.cancel()
        if worker.is_alive() and sys.stderr.isatty():
            reached = control.time_reached
            print(f"\r{reached:.0f} of {design.mission.duration:g} s", end="", file=sys.stderr)
            shown = True
    if shown:
        print("\r\033[K", end="", file=sys.stderr)
    return finished[0]


def simulate(path: Path, output: Path | None) -> int:
    """Simulate a design file, print how it ended, and write the run."""
    if output is not None and output.suffix not in WRITERS:
        complain(output, f"a result is written as {' or '.join(WRITERS)}, not '{output.suffix}'")
        return MISUSED
    design = load(path)
    if isinstance(design, int):
        return design
    run = simulate_with_progress(design)
    _print_summary(run)
    if output is not None:
        try:
            WRITERS[output.suffix](run, output)
        except OSError as error:
            complain(output, error.strerror or str(error))
            return UNUSABLE
        print(f"written     {output}")
    return DONE if run.status in WHOLE else STOPPED


def _print_summary(run: Run) -> None:
    final = {name: round(value, 6) + 0.0 for name, value in run.final.items()}  # no "-0.0000" at the surface
    print(f"design      {run.design.name}")
    print(f"status      {run.status.name}: {run.message}")
    for event in run.events:
        print(f"event       {event}")
    print(
        f"end         t {final['t']:.3f} s, x {final['x']:.4f} m, depth {final['z']:.4f} m, "
        f"pitch {math.degrees(final['theta']):.2f} deg"
    )
    if run.model == "spatial":
        _print_spatial(run, final)
    for warning in run_warnings(run):
        print(f"warning     {warning.message}")
    print(f"residual    {run.relative_residual:.1e} of {run.energy_exchanged:.4g} J exchanged")
    print(f"steps       {run.statistics['steps']}")


def _print_spatial(run: Run, final: dict[str, float]) -> None:
    turn = math.degrees(final["turn_rate"])
    radius = "" if math.isnan(final["turn_radius"]) or abs(turn) < 1e-3 else f", radius {final['turn_radius']:.4g} m"
    print(
        f"            y {final['y']:.4f} m, roll {math.degrees(final['phi']):.2f} deg, heading "
        f"{math.degrees(final['psi']):.2f} deg, turning {turn:.3f} deg/s{radius}"
    )
    bill = energy_bill(run)
    if bill is None:
        return
    parts = {"hotel": bill.whole.hotel, **bill.whole.parts}
    split = ", ".join(f"{name} {round(energy, 1) + 0.0:.1f} J" for name, energy in parts.items())
    per_km = "" if bill.whole.per_km is None else f", {bill.whole.per_km:.0f} J/km"
    print(f"energy      {bill.whole.total:.1f} J{per_km}: {split}")
    if len(bill.dives) > 1:
        print(f"dives       {', '.join(f'{dive.depth:.1f} m: {dive.total:.0f} J' for dive in bill.dives)}")


def validate(path: Path) -> int:
    """Check a design file and print its identity, or what is wrong."""
    design = load(path)
    if isinstance(design, int):
        return design
    print(f"valid: {design.name}, {len(design.vehicle.components)} components, identity {design.identity[:16]}")
    for warning in assemble(design).warnings:
        print(f"warning: {warning}")
    return DONE


def presets(preset_id: str | None) -> int:
    """List the presets, or print one."""
    if preset_id is None:
        for name in preset_ids():
            print(f"{name:<24} {load_preset(name).name}")
        return DONE
    try:
        print(load_preset(preset_id).to_json(), end="")
    except KeyError:
        complain(preset_id, f"no such preset; there are {', '.join(preset_ids())}")
        return REFUSED
    return DONE
