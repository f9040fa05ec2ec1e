"""Owns what the formats of results are called, and how their files end; it imports nothing heavy."""

from __future__ import annotations

from collections.abc import Mapping

ENDINGS: Mapping[str, str] = {"csv": "csv", "parquet": "parquet", "netcdf": "nc", "mat": "mat", "json": "json"}
"""The ending of a file, by its format."""
_BY_ENDING = {ending: name for name, ending in ENDINGS.items()}


def format_named(given: str) -> str:
    """Return the name of the format that is asked for by its name or its ending; what is neither stays as it is."""
    return _BY_ENDING.get(given, given)
