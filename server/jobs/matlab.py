"""Owns a job's case table as a MATLAB file (version 5), written one column after another.

Numbers are column vectors. A column of texts, such as `status`, is a struct: `values`, a cell array of the different
texts, and `code`, numbers from 1 into it, 0 where there is none. The structs `names`, `units` and `meanings` tell of
every column.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from scipy.io import savemat

from server.jobs.case_table import FIXED
from server.jobs.column_names import plain_names
from server.jobs.results import Results
from server.jobs.results import about as told

LONGEST_NAME = 63
LARGEST_FILE = 2**31 - 1
KEYWORDS = (
    "break", "case", "catch", "classdef", "continue", "else", "elseif", "end", "for", "function", "global", "if",
    "otherwise", "parfor", "persistent", "return", "spmd", "switch", "try", "while",
)  # fmt: skip
FIXED_NAMES = dict(zip(FIXED, ("case_number", "status", "reason"), strict=True))
"""`case` is a word of the language."""
STRUCTS = ("names", "units", "meanings", "about")


class TooLargeError(Exception):
    """The results do not fit into the wanted format."""


def write_matlab(results: Results, path: Path, about: Mapping[str, Any], *, largest: int = LARGEST_FILE) -> None:
    """Write the case table that is there; `about` becomes a struct, what is no text or number as JSON.

    Raises
    ------
    TooLargeError
        Where the file would be larger than the format allows.

    """
    chunks = results.chunks()
    names = variable_names(results)
    _require_room(8 * results.count(chunks) * len(names), largest)
    with path.open("wb") as out:
        for field in results.schema:
            column = _texts if pa.types.is_string(field.type) else _numbers
            _append(out, {names[field.name]: column(results, field.name, chunks)})
            _require_room(out.tell(), largest)
        _append(out, _structs(results, names, about))


def variable_names(results: Results) -> dict[str, str]:
    """Return the name of the variable that holds each column; their own names are in the struct `names`."""
    taken = (*KEYWORDS, *STRUCTS, *FIXED_NAMES.values())
    return FIXED_NAMES | plain_names((c.name for c in results.columns()), longest=LONGEST_NAME, taken=taken)


def _append(out: BinaryIO, variables: Mapping[str, Any]) -> None:
    """Write variables at the end of a file; scipy writes the file's header where it is empty."""
    savemat(out, variables, long_field_names=True, oned_as="column")  # type: ignore[arg-type]  # takes files too


def _numbers(results: Results, name: str, chunks: Sequence[int]) -> NDArray[np.float64]:
    values, end = np.empty(results.count(chunks)), 0
    for block in results.blocks([name], chunks=chunks):
        values[end : end + block.num_rows] = block.column(0).to_numpy(zero_copy_only=False)
        end += block.num_rows
    return values


def _texts(results: Results, name: str, chunks: Sequence[int]) -> dict[str, NDArray[Any]]:
    places: dict[str | None, int] = {None: 0}
    codes, end = np.empty(results.count(chunks)), 0
    for block in results.blocks([name], chunks=chunks):
        codes[end : end + block.num_rows] = [
            places.setdefault(text, len(places)) for text in block.column(0).to_pylist()
        ]
        end += block.num_rows
    return {"code": codes, "values": np.array([*places][1:], dtype=object)}


def _structs(results: Results, names: Mapping[str, str], about: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    fields = [(names[field.name], field) for field in results.schema]
    structs = {
        "names": {plain: field.name for plain, field in fields},
        "units": {plain: told(field, "unit") for plain, field in fields},
        "meanings": {plain: told(field, "meaning") for plain, field in fields},
    }
    keys = plain_names(about, longest=LONGEST_NAME)
    given = {keys[key]: value if isinstance(value, str | float) else json.dumps(value) for key, value in about.items()}
    return structs | ({"about": given} if given else {})


def _require_room(size: int, largest: int) -> None:
    if size > largest:
        raise TooLargeError(
            f"a MATLAB file of version 5 holds up to {largest} bytes, and these results need more than {size}: take "
            "Parquet or NetCDF, which MATLAB reads too (parquetread, ncread)"
        )
