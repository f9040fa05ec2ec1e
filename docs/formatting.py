"""Owns how computed pages print numbers, tables and prose: few digits, so that another processor prints the same."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Sequence

WIDTH = 118
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def num(value: float, digits: int = 2) -> str:
    """Return a number with so many decimals, and a true minus sign; what rounds to zero has no sign."""
    text = f"{value:.{digits}f}"
    if float(text) == 0.0:
        text = text.lstrip("-")
    return text.replace("-", "−")


def signed(value: float, digits: int = 2) -> str:
    """Return a number with its sign, also where that is positive."""
    text = num(value, digits)
    return text if text.startswith("−") or float(text) == 0.0 else f"+{text}"


def order_of(value: float) -> str:
    """Return a number by one digit and its power of ten: for errors, of which only the size matters."""
    if value == 0.0:
        return "0"
    digit, exponent = f"{value:.0e}".split("e")
    return f"{digit} × 10{str(int(exponent)).translate(_SUPERSCRIPTS)}".replace("-", "−")


def bound(value: float) -> str:
    """Return the power of ten that lies at least a factor of two above a magnitude: for rounding errors."""
    exponent = max(math.ceil(math.log10(2.0 * abs(value))), -12) if value else -12
    return f"10{str(exponent).translate(_SUPERSCRIPTS)}"


def percent(share: float, digits: int = 0) -> str:
    """Return a share in per cent."""
    return f"{num(100.0 * share, digits)} %"


def markdown_table(header: Sequence[str], rows: Sequence[Sequence[str]], left: int = 1) -> str:
    """Return a Markdown table whose first `left` columns are aligned left, the others right."""
    rule = ["---"] * left + ["---:"] * (len(header) - left)
    return "\n".join("| " + " | ".join(row) + " |" for row in (header, rule, *rows))


def page_of(sections: Sequence[str]) -> str:
    """Return a page of its sections, prose wrapped anew since numbers took the places of expressions."""
    return "\n\n".join(_wrapped(block) for block in "\n".join(sections).strip().split("\n\n")) + "\n"


def _wrapped(block: str) -> str:
    """Wrap prose and the items of a list; keep headings, tables and pictures."""
    if block.lstrip().startswith(("#", "|", "![")):
        return block.strip("\n")
    wrapper = textwrap.TextWrapper(WIDTH, break_long_words=False, break_on_hyphens=False)
    lines = []
    for item in re.split(r"\n(?=- )", block.strip()):
        wrapper.subsequent_indent = "  " if item.startswith("- ") else ""
        lines += wrapper.wrap(" ".join(item.split()))
    return "\n".join(lines)
