"""Owns what the batch command takes on the command line, and its examples; it imports nothing heavy."""

from __future__ import annotations

import argparse
from importlib.resources import files
from pathlib import Path

from server.format_names import ENDINGS, format_named

FORMATS = tuple(ENDINGS)
EXAMPLES = ("sweep", "monte-carlo", "sensitivity")


def example(name: str) -> str:
    """Return a batch document that runs as it is."""
    return (files("studio") / "batch_examples" / f"{name}.json").read_text(encoding="utf-8")


def _workers(text: str) -> int:
    if not text.isascii() or not text.isdecimal() or int(text) > 1024:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from 0 to 1024")
    return int(text)


def _address(text: str) -> str:
    if "://" not in text:
        raise argparse.ArgumentTypeError(f"{text!r} is no address such as tcp://127.0.0.1:8786")
    return text


def add_batch(parser: argparse.ArgumentParser) -> None:
    """Give the subcommand its arguments."""
    parser.add_argument(
        "spec", type=Path, nargs="?", metavar="SPEC",
        help="batch document, or - for standard input; its design may be a file's path or preset:NAME",
    )  # fmt: skip
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FOLDER",
        help="where results are kept; named after SPEC if not given. The same again goes on where it stopped",
    )  # fmt: skip
    parser.add_argument(
        "--format",
        type=format_named,
        choices=FORMATS,
        action="append",
        help="format of the table that is written at the end, cases.csv by default; may be repeated",
    )
    who = parser.add_mutually_exclusive_group()
    who.add_argument(
        "--workers", type=_workers, metavar="N", help="processes (GLIDER_STUDIO_WORKERS, one a core); 0: this one"
    )
    who.add_argument(
        "--scheduler", type=_address, metavar="URL",
        help="Dask scheduler that computes, as tcp://127.0.0.1:8786 (GLIDER_STUDIO_SCHEDULER)",
    )  # fmt: skip
    anew = parser.add_mutually_exclusive_group()
    anew.add_argument("--fresh", action="store_true", help="compute anew what an equal job has computed here")
    anew.add_argument("--retry", action="store_true", help="compute failed cases again")
    parser.add_argument("--dry-run", action="store_true", help="check SPEC and show its first cases; run nothing")
    parser.add_argument("--example", choices=EXAMPLES, help="print a batch document to start from")
