"""Owns the command that prints a design's own equations of motion, as text or LaTeX."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from studio.exit_codes import DONE, UNUSABLE


def add_equations(parser: ArgumentParser) -> None:
    """Give the subcommand its arguments."""
    parser.add_argument("design", type=Path, help="design file, or - for standard input")
    parser.add_argument("--format", choices=("text", "latex"), default="text", help="plain text (default), or LaTeX")
    parser.add_argument(
        "--numbers", action="store_true", help="put values at the initial extensions into the equations"
    )
    parser.add_argument("-o", "--output", type=Path, help="file to write instead of standard output")


def equations(options: Namespace) -> int:
    """Derive the equations of a design file from its energies, and print or write them."""
    from models.equation_text import render
    from models.equations import derive_equations
    from studio.commands import complain, load

    design = load(options.design)
    if isinstance(design, int):
        return design
    derived = derive_equations(design)
    page = render(derived.with_numbers() if options.numbers else derived, options.format)
    if options.output is None:
        print(page, end="")
        return DONE
    try:
        options.output.write_text(page, encoding="utf-8")
    except OSError as error:
        complain(options.output, error.strerror or str(error))
        return UNUSABLE
    print(f"written     {options.output}")
    return DONE
