"""Owns the reading of a batch document from a file, where the design may be another file or a preset."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from models.presets import load_preset, preset_ids
from models.problems import DesignError, Problem, echo

PRESET = "preset:"


def read_document(path: Path) -> Any:
    """Return a decoded batch document with its design inside; what it says is checked later.

    Raises
    ------
    DesignError
        Where it is not JSON, or names a preset that does not exist.
    OSError
        Where a file cannot be read; its `filename` says which.

    """
    is_stream = str(path) == "-"
    document = _decoded(sys.stdin.buffer.read() if is_stream else path.read_bytes(), "", path)
    if isinstance(document, dict) and isinstance(named := document.get("design"), str):
        document["design"] = _design(named, Path() if is_stream else path.parent)
    return document


def _design(named: str, beside: Path) -> Any:
    if not named.startswith(PRESET):
        path = beside / named
        return _decoded(path.read_bytes(), "/design", path)
    try:
        return load_preset(named.removeprefix(PRESET)).model_dump(mode="json")
    except KeyError:
        offered = ", ".join(preset_ids())
        message = f"there is no preset {echo(named.removeprefix(PRESET))}"
        raise DesignError([Problem("/design", message, hint=f"there are {offered}")]) from None


def _decoded(content: bytes, pointer: str, path: Path) -> Any:
    try:
        return json.loads(content)
    except (ValueError, RecursionError) as error:  # not JSON, not UTF-8, or a number of thousands of digits
        raise DesignError([Problem(pointer, f"{path} is not JSON: {error}")]) from None
