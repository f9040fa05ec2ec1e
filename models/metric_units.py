"""Owns the units of what is composed: products, ratios and time integrals of units such as "kg m2" or "J/km"."""

from __future__ import annotations

import re
from collections import Counter

PART = re.compile(r"(?P<symbol>[^\s/\d]+)(?P<power>\d*)")
NONE = "1"


def product_unit(*units: str) -> str:
    """Return the unit of a product, "1" where all cancel."""
    powers: Counter[str] = Counter()
    for unit in units:
        powers.update(_powers(unit))
    return _written(powers)


def ratio_unit(unit: str, divisor: str) -> str:
    """Return the unit of a ratio, "1" where all cancels."""
    powers = _powers(unit)
    powers.subtract(_powers(divisor))
    return _written(powers)


def _powers(unit: str) -> Counter[str]:
    """Return the powers of the symbols; what stands between strokes after the first is all divided by."""
    powers: Counter[str] = Counter()
    for k, side in enumerate(unit.split("/")):
        for part in PART.finditer(side):
            powers[part["symbol"]] += (1 if k == 0 else -1) * int(part["power"] or 1)
    return powers


def _written(powers: Counter[str]) -> str:
    above = " ".join(_part(symbol, power) for symbol, power in powers.items() if power > 0)
    below = "".join("/" + _part(symbol, -power) for symbol, power in powers.items() if power < 0)
    return f"{above or NONE}{below}"


def _part(symbol: str, power: int) -> str:
    return symbol if power == 1 else f"{symbol}{power}"
