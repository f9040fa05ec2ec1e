"""Owns what the analysing commands take on the command line; it imports nothing heavy."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

ANALYSES = ("trim", "polar", "linearize", "stability", "allocate")
TARGETS = "glide_angle, speed, sink_rate, turn_rate, turn_radius, pitch, roll (SI units and rad; 20deg is an angle)"


def quantity(text: str) -> tuple[str, float]:
    """Return name and value of NAME=VALUE, an angle in degrees where it ends in "deg"; argparse shows the error."""
    name, equals, value = text.rpartition("=")
    factor = 1.0
    if value.endswith("deg"):
        value, factor = value[: -len("deg")], math.radians(1.0)
    try:
        number = float(value) * factor
    except ValueError:
        number = math.nan
    if not equals or not name or not math.isfinite(number):
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=VALUE, such as speed=0.3 or pitch=-20deg")
    return name, number


def add_analyses(commands: argparse._SubParsersAction[argparse.ArgumentParser], *, epilog: str) -> None:
    """Add the commands that analyse a design."""
    helps = {
        "trim": "find steady glides, turns and spirals, at given extensions or for a wanted motion",
        "polar": "draw speed against glide angle over the cells' strokes",
        "linearize": "linearise about a trim or an instant: modes, frequency responses, root locus",
        "stability": "follow margins and growth of small motions along the mission",
        "allocate": "see what the cells do to heave, pitch and roll, together",
    }
    for name in ANALYSES:
        parser = commands.add_parser(name, help=helps[name], epilog=epilog)
        parser.add_argument("design", type=Path, help="design file, or - for standard input")
        parser.add_argument("--json", action="store_true", help="print the answer of the REST API instead of a summary")
        _ADD[name](parser)
        if name not in ("trim", "allocate"):
            parser.add_argument("--plot", type=Path, help="picture to draw: .png, .svg or .pdf")
        else:
            parser.set_defaults(plot=None)


def add_steady(parser: argparse.ArgumentParser) -> None:
    """Add the options that choose a steady motion."""
    parser.add_argument(
        "--extension", type=quantity, action="append", metavar="CELL=M",
        help="extension of a component, m (rad of one that rolls); else the mission's initial one",
    )  # fmt: skip
    parser.add_argument("--target", type=quantity, action="append", metavar="NAME=VALUE", help=f"wanted: {TARGETS}")
    parser.add_argument("--free", action="append", metavar="CELL", help="cell that may move to meet targets; else all")
    parser.add_argument("--depth", type=float, help="depth at which the water is taken, m")


def _polar(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--points", type=int, default=50, help="points of each curve (50)")
    parser.add_argument("--cell", action="append", help="cell that moves; else all")
    parser.add_argument("--cycle-depth", type=float, help="depth of the dive cycle over which pumping is reckoned, m")


def _linearize(parser: argparse.ArgumentParser) -> None:
    add_steady(parser)
    parser.add_argument("--time", type=float, help="linearise at this instant of the mission, s, instead of a trim")
    parser.add_argument(
        "--bode", nargs=2, action="append", metavar=("INPUT", "OUTPUT"),
        help="frequency response, such as --bode 'command of Tail cell' theta",
    )  # fmt: skip
    parser.add_argument(
        "--locus", nargs="+", metavar="POINTER VALUE",
        help="eigenvalues over a number of the design (a JSON Pointer) at these values",
    )  # fmt: skip


def _stability(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--samples", type=int, default=200, help="instants at which small motions are looked at (200)")


def _allocate(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--cell", action="append", help="cell that takes part; else all that move")
    parser.add_argument("--depth", type=float, default=0.0, help="depth whose density counts, m (0)")
    parser.add_argument(
        "--want",
        type=quantity,
        action="append",
        metavar="AXIS=VALUE",
        help="heave (N), pitch, roll (N m), from neutral",
    )


def add_controller(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command that designs a controller."""
    parser.add_argument("design", type=Path, help="design file, or - for standard input")
    add_steady(parser)
    parser.add_argument(
        "--kind", choices=("state_feedback", "cascade"), default="state_feedback",
        help="state feedback by LQR or poles (default), or first gains of guidance and loops",
    )  # fmt: skip
    parser.add_argument("--sample-time", type=float, default=1.0, help="time between samples, s (1)")
    parser.add_argument("--delay", type=float, default=0.0, help="time until commands reach the actuators, s (0)")
    parser.add_argument("--state", action="append", help="state fed back; else all that the cells can move")
    parser.add_argument("--cell", action="append", help="cell under control; else all that move")
    parser.add_argument(
        "--deviation", type=quantity, action="append", metavar="STATE=VALUE",
        help="largest acceptable deviation, SI units and rad (5deg is an angle); 0.1 where not named",
    )  # fmt: skip
    parser.add_argument("--share", type=float, default=0.2, help="largest acceptable command, share of stroke (0.2)")
    parser.add_argument("--integrals", type=int, default=0, help="how many of the first states are integrated (0)")
    parser.add_argument(
        "--pole", type=complex, action="append", help="place poles instead, 1/s, such as --pole=-0.2+0.1j; one a state"
    )
    parser.add_argument("--step", type=quantity, metavar="STATE=VALUE", help="fly a step of theta, phi, psi or u")
    parser.add_argument("--duration", type=float, default=120.0, help="how long the step is watched, s (120)")
    parser.add_argument(
        "-o", "--output", type=Path, action="append",
        help="file to write: .json, the design under the controller, from its trim; .mat (MATLAB); .py (a script)",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help="print the answer of the REST API instead of a summary")
    parser.add_argument("--plot", type=Path, help="picture of the step to draw: .png, .svg or .pdf")


_ADD = {
    "trim": add_steady, "polar": _polar, "linearize": _linearize, "stability": _stability, "allocate": _allocate,
}  # fmt: skip
