"""Owns the command line and the start of everything: the API, the studio on it, one port. Subcommands import lazily."""

from __future__ import annotations

import argparse
import math
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from studio.analysis_arguments import ANALYSES, add_analyses, add_controller
from studio.batch_arguments import add_batch
from studio.commands_equations import add_equations, equations
from studio.exit_codes import DONE, MEANING, STOPPED

ATTACHED = {
    "water": "temperature (degC) and salinity against depth (m)",
    "density": "density (kg/m3) against depth (m)",
    "current": "velocity north and east (m/s) against depth (m), and time (s)",
    "forces": "forces (N, N m) over alpha_deg, or over alpha_deg and beta_deg, with speed (m/s)",
}
COLUMNS = """\
columns of a CSV, by its header, in any order; further columns are left alone. A unit may follow in brackets or
parentheses, as in "depth (m)"; another unit is refused:
  water     depth (m, down), temperature (degC, in situ), salinity (practical, or g/kg with --salinity absolute; without
            that column the water is fresh)
  density   depth (m), density (kg/m3, in situ)
  current   depth (m), north (m/s), east (m/s), time (s; without that column the current is steady)
  forces    over the angle of attack: speed (m/s), alpha_deg (deg, from 0 to 90), lift (N), drag (N), moment (N m, nose
            up)
  forces    over both angles, where the header has beta_deg: speed (m/s), alpha_deg, beta_deg (deg), X, Y, Z (N),
            K, M, N (N m): body axes, x to the nose, y to starboard, z down; every combination of both angles
a NetCDF has variables of these names or CF standard names: sea_water_temperature, sea_water_practical_salinity,
sea_water_absolute_salinity, sea_water_density, northward_sea_water_velocity, eastward_sea_water_velocity, depth, time.
Examples of each file, and the same from Python: docs/data_files.md

"""


def _speed(text: str) -> float | Literal["mean"]:
    """Return a speed above 0, or "mean"; argparse refuses everything else."""
    if text == "mean":
        return "mean"
    try:
        speed = float(text)
    except ValueError:
        speed = math.nan
    if not 0.0 < speed < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is neither a speed above 0 (m/s) nor 'mean'")
    return speed


def _add_attach(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("design", type=Path, help="design file")
    parser.add_argument("kind", choices=ATTACHED, help="; ".join(f"{name}: {what}" for name, what in ATTACHED.items()))
    parser.add_argument("data", type=Path, help="CSV with a header, or NetCDF for water, density and current")
    parser.add_argument("-o", "--output", type=Path, required=True, help="design file to write")
    parser.add_argument("--source", default="", help="where the data come from, kept in the design")
    parser.add_argument("--latitude", type=float, help="of water: degrees north; sets pressure and gravity")
    parser.add_argument("--longitude", type=float, help="of water: degrees east; gives the sea's composition")
    parser.add_argument("--salinity", choices=("practical", "absolute"), default="practical", help="of water")
    parser.add_argument("--speed", type=_speed, help="of forces: use this speed (m/s), or the mean of all ('mean')")
    parser.add_argument(
        "--munk", choices=("included", "excluded"), default="included",
        help="of forces: whether the moments hold the Munk moment, as those measured in a stream do (included)",
    )  # fmt: skip
    parser.add_argument(
        "--reference-density", type=float, default=1000.0, metavar="RHO",
        help="of forces: density at which they were taken, kg/m3 (1000)",
    )  # fmt: skip
    parser.add_argument(
        "--reference-point", type=float, nargs=3, default=(0.0, 0.0, 0.0), metavar=("X", "Y", "Z"),
        help="of forces: point about which the moments were taken, m in body axes (the body origin)",
    )  # fmt: skip


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="glider-studio",
        description="A design studio for underwater gliders with buoyancy cells.",
        epilog=MEANING,
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    serve = commands.add_parser("serve", help="start the studio and the REST API on one port", epilog=MEANING)
    serve.add_argument("--host", help="address to listen on (GLIDER_STUDIO_HOST, 127.0.0.1)")
    serve.add_argument("--port", type=int, help="port to listen on (GLIDER_STUDIO_PORT, 8000); 0 takes a free one")
    serve.add_argument("--data", type=Path, help="folder for the studio's data (GLIDER_STUDIO_DATA)")
    simulate = commands.add_parser("simulate", help="simulate a design and write its run", epilog=MEANING)
    simulate.add_argument("design", type=Path, help="design file, or - for standard input")
    simulate.add_argument("-o", "--output", type=Path, help="result file: .nc (NetCDF) or .csv")
    validate = commands.add_parser("validate", help="check a design", epilog=MEANING)
    validate.add_argument("design", type=Path, help="design file, or - for standard input")
    attaching = commands.add_parser(
        "attach", help="put a profile or a force table into a design", epilog=COLUMNS + MEANING,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    _add_attach(attaching)
    add_equations(
        commands.add_parser(
            "equations", help="derive a design's own equations of motion and print them", epilog=MEANING
        )
    )
    add_analyses(commands, epilog=MEANING)
    add_controller(
        commands.add_parser("design-controller", help="design state feedback, or first gains of loops", epilog=MEANING)
    )
    add_batch(commands.add_parser("batch", help="run a sweep, a Monte Carlo or a sensitivity study", epilog=MEANING))
    presets = commands.add_parser("presets", help="list the presets, or print one as JSON", epilog=MEANING)
    presets.add_argument("preset", nargs="?", help="print this preset's design document")
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit code."""
    options = _parser().parse_args(arguments)
    # matrices here are small: threads of the linear algebra library would only spin
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        if options.command == "serve":
            from studio.serve import serve

            return serve(host=options.host, port=options.port, data=options.data)
        if options.command == "attach":
            from studio.attach import attach

            return attach(options)
        if options.command == "equations":
            return equations(options)
        if options.command in ANALYSES:
            from studio.commands_analyses import run_analysis

            return run_analysis(options)
        if options.command == "design-controller":
            from studio.commands_control import design_controller

            return design_controller(options)
        if options.command == "batch":
            from studio.commands_batch import batch

            return batch(options)
        from studio import commands

        if options.command == "simulate":
            return commands.simulate(options.design, options.output)
        if options.command == "validate":
            return commands.validate(options.design)
        return commands.presets(options.preset)
    except KeyboardInterrupt:
        return STOPPED
    except BrokenPipeError:  # the reader, say `head`, has seen enough
        sys.stderr.close()
        return DONE


if __name__ == "__main__":
    raise SystemExit(main())
