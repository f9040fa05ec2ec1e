"""Owns what words of a command line are turned into: numbers, named numbers, lists of them; argparse shows errors."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

PICTURES = (".png", ".svg", ".pdf")
NEGATIVE = re.compile(r"^-\.?\d")
"""Words that begin so are numbers and no options: -25deg, -1e-3, -0.2+0.1j, as -0.5 is."""


def number(text: str) -> float:
    """Return a finite number."""
    try:
        found = float(text)
    except ValueError:
        found = math.nan
    if not math.isfinite(found):
        raise argparse.ArgumentTypeError(f"{text!r} is not a finite number")
    return found


def angle(text: str) -> float:
    """Return a finite number, an angle in degrees where it ends in "deg"."""
    return math.radians(number(text.removesuffix("deg"))) if text.endswith("deg") else number(text)


def quantity(text: str) -> tuple[str, float]:
    """Return name and value of NAME=VALUE, an angle in degrees where it ends in "deg"."""
    name, equals, value = text.rpartition("=")
    try:
        found = angle(value)
    except argparse.ArgumentTypeError:
        found = math.nan
    if not equals or not name or not math.isfinite(found):
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=VALUE, such as speed=0.3 or pitch=-20deg")
    return name, found


def pole(text: str) -> complex:
    """Return a finite complex number, 1/s."""
    try:
        found = complex(text)
    except ValueError:
        found = complex(math.nan)
    if not (math.isfinite(found.real) and math.isfinite(found.imag)):
        raise argparse.ArgumentTypeError(f"{text!r} is not a complex number, such as -0.2+0.1j")
    return found


def picture(text: str) -> Path:
    """Return the path of a picture to draw."""
    path = Path(text)
    if path.suffix not in PICTURES:
        raise argparse.ArgumentTypeError(f"a picture is written as .png, .svg or .pdf, not '{path.suffix}'")
    return path


class Named(argparse.Action):
    """Collects NAME=VALUE in a dictionary; a name may come once."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option: str | None = None
    ) -> None:
        """Add one."""
        name, value = values
        known = getattr(namespace, self.dest) or {}
        if name in known:
            raise argparse.ArgumentError(self, f"'{name}' is given twice")
        setattr(namespace, self.dest, {**known, name: value})


class NameAndNumbers(argparse.Action):
    """Takes a name and numbers after it."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option: str | None = None
    ) -> None:
        """Take them."""
        words: Sequence[str] = values
        if len(words) < 2:
            raise argparse.ArgumentError(self, f"no number after '{words[0]}'")
        try:
            numbers = [angle(word) for word in words[1:]]
        except argparse.ArgumentTypeError as error:
            raise argparse.ArgumentError(self, str(error)) from None
        setattr(namespace, self.dest, (words[0], numbers))
