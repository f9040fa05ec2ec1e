"""Owns what the analysing commands take on the command line; it imports nothing heavy."""

from __future__ import annotations

import argparse
from pathlib import Path

from studio.argument_types import NEGATIVE, NameAndNumbers, Named, angle, number, picture, pole, quantity

ANALYSES = ("trim", "polar", "linearize", "stability", "allocate")
TARGETS = "glide_angle, speed, sink_rate, turn_rate, turn_radius, pitch, roll (SI units and rad; 20deg is an angle)"


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
        parser._negative_number_matcher = NEGATIVE
        _ADD[name](parser)
        if name not in ("trim", "allocate"):
            parser.add_argument("--plot", type=picture, help="picture to draw: .png, .svg or .pdf")
        else:
            parser.set_defaults(plot=None)


def add_steady(parser: argparse.ArgumentParser) -> None:
    """Add the options that choose a steady motion."""
    _add_water(parser)
    parser.add_argument("--target", type=quantity, action=Named, metavar="NAME=VALUE", help=f"wanted: {TARGETS}")
    parser.add_argument("--free", action="append", metavar="CELL", help="cell that may move to meet targets; else all")


def _add_water(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--extension", type=quantity, action=Named, metavar="CELL=M",
        help="extension of a component, m (rad of one that rolls); else the mission's initial one",
    )  # fmt: skip
    parser.add_argument("--depth", type=number, help="depth at which the water is taken, m")


def _trim(parser: argparse.ArgumentParser) -> None:
    add_steady(parser)
    parser.add_argument("--angle-step", type=angle, help="step in angle of attack of the search, rad or 1deg (2deg)")
    parser.add_argument(
        "--bank", type=angle, action="append", metavar="BANK",
        help="bank from which turns are searched for, to either side, rad or 10deg; else a few",
    )  # fmt: skip


def _polar(parser: argparse.ArgumentParser) -> None:
    _add_water(parser)
    parser.add_argument("--points", type=int, default=50, help="points of each curve (50)")
    parser.add_argument("--cell", action="append", help="cell that moves; else all")
    parser.add_argument("--cycle-depth", type=number, help="depth of the dive cycle over which pumping is reckoned, m")


def _linearize(parser: argparse.ArgumentParser) -> None:
    _trim(parser)
    parser.add_argument("--time", type=number, help="linearise at this instant of the mission, s, instead of a trim")
    parser.add_argument(
        "--bode", nargs=2, action="append", metavar=("INPUT", "OUTPUT"),
        help="frequency response, such as --bode 'command of Tail cell' theta",
    )  # fmt: skip
    parser.add_argument(
        "--frequency", type=number, nargs="+", action="extend", metavar="W",
        help="frequencies of the responses, rad/s; else chosen from the modes",
    )  # fmt: skip
    parser.add_argument(
        "--locus", nargs="+", action=NameAndNumbers, metavar=("POINTER", "VALUE"),
        help="eigenvalues over a number of the design (a JSON Pointer) at these values",
    )  # fmt: skip


def _stability(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--samples", type=int, default=200, help="instants at which small motions are looked at (200)")


def _allocate(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--cell", action="append", help="cell that takes part; else all that move")
    parser.add_argument("--depth", type=number, default=0.0, help="depth whose density counts, m (0)")
    parser.add_argument(
        "--want", type=quantity, action=Named, metavar="AXIS=VALUE", help="heave (N), pitch, roll (N m), from neutral"
    )
    parser.add_argument(
        "--weight", type=quantity, action=Named, metavar="AXIS=W", help="how much heave, pitch or roll counts (1)"
    )
    parser.add_argument(
        "--effort", type=quantity, action=Named, metavar="CELL=W", help="how unwillingly a cell leaves neutral (1)"
    )


def add_controller(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command that designs a controller."""
    parser._negative_number_matcher = NEGATIVE
    parser.add_argument("design", type=Path, help="design file, or - for standard input")
    add_steady(parser)
    parser.add_argument("--heading", type=angle, default=0.0, help="heading to hold, rad or 30deg (0)")
    parser.add_argument(
        "--kind", choices=("state_feedback", "cascade"), default="state_feedback",
        help="state feedback by LQR or poles (default), or first gains of guidance and loops",
    )  # fmt: skip
    parser.add_argument("--sample-time", type=number, default=1.0, help="time between samples, s (1)")
    parser.add_argument("--delay", type=number, default=0.0, help="time until commands reach the actuators, s (0)")
    parser.add_argument("--state", action="append", help="state fed back; else all that the cells can move")
    parser.add_argument("--cell", action="append", help="cell under control; else all that move")
    parser.add_argument(
        "--deviation", type=quantity, action=Named, metavar="STATE=VALUE",
        help="largest acceptable deviation, SI units and rad (5deg is an angle); 0.1 where not named",
    )  # fmt: skip
    parser.add_argument("--share", type=number, default=0.2, help="largest acceptable command, share of stroke (0.2)")
    parser.add_argument("--cell-share", type=quantity, action=Named, metavar="CELL=SHARE", help="the same for one cell")
    parser.add_argument("--integrals", type=int, default=0, help="how many of the first states are integrated (0)")
    parser.add_argument(
        "--integral-time", type=number, default=60.0,
        help="the largest acceptable integral is this time the state's deviation, s (60)",
    )  # fmt: skip
    parser.add_argument(
        "--pole", type=pole, action="append", help="place poles instead, 1/s, such as --pole -0.2+0.1j; one a state"
    )
    parser.add_argument(
        "--table", nargs="+", action=NameAndNumbers, metavar=("TARGET", "VALUE"),
        help="a table of gains over glide_angle, pitch, speed or sink_rate at these values, in place of one trim",
    )  # fmt: skip
    parser.add_argument("--step", type=quantity, metavar="STATE=VALUE", help="fly a step of theta, phi, psi or u")
    parser.add_argument(
        "--departure", type=quantity, action=Named, metavar="STATE=VALUE",
        help="fly back from a departure from the trim: theta, phi, psi, u, v, w, p, q or r, the first is watched",
    )  # fmt: skip
    parser.add_argument(
        "--duration", type=number, help="how long a step or the way back is watched (120), or the mission written, s"
    )
    parser.add_argument(
        "-o", "--output", type=Path, action="append",
        help="file to write: .json, the design under the controller, from its trim; .mat (MATLAB); .py (a script)",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help="print the answer of the REST API instead of a summary")
    parser.add_argument("--plot", type=picture, help="picture of the step, or of the way back: .png, .svg or .pdf")


_ADD = {
    "trim": _trim, "polar": _polar, "linearize": _linearize, "stability": _stability, "allocate": _allocate,
}  # fmt: skip
