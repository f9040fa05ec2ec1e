"""Owns the comparison of a computed page with the committed one."""

from __future__ import annotations

import re

NUMBER = re.compile(r"[−+-]?\d+(?:\.\d+)?")
POWER = re.compile(r"10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)")
DIGITS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


def words(text: str) -> list[str]:
    """The text between the numbers; line breaks move with the width of a number, so they do not count."""
    return " ".join(NUMBER.sub("#", POWER.sub("#", text)).split()).split(" ")


def assert_same_page(new: str, committed: str, command: str) -> None:
    """All words are equal, every number to one unit of its last digit, every bound of an error to one power of ten.

    Another processor rounds differently in the last bits (fused multiply-add, other sums in BLAS), which may carry a
    number over a rounding edge, but no further: numbers are printed with far fewer digits than the runs resolve.
    """
    assert words(new) == words(committed), f"the page is stale: run `{command}`"
    for a, b in zip(POWER.findall(new), POWER.findall(committed), strict=True):
        assert abs(int(a.translate(DIGITS)) - int(b.translate(DIGITS))) <= 1, f"10{a} is not 10{b}"
    texts = [POWER.sub("", text) for text in (new, committed)]
    for a, b in zip(*(NUMBER.findall(text) for text in texts), strict=True):
        unit = 10.0 ** -max(len(x.partition(".")[2]) for x in (a, b))
        assert abs(float(a.replace("−", "-")) - float(b.replace("−", "-"))) <= 1.01 * unit, f"{a} is not {b}"
