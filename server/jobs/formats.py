"""Owns a job's results as files in the usual formats: JSON and CSV as streams, the others as files to send and forget.

A parameter's value that is no number is JSON in every format; in JSON it is simply itself.
"""

from __future__ import annotations

import csv
import json
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from io import StringIO
from pathlib import Path
from typing import Any, BinaryIO

import pyarrow as pa
import pyarrow.parquet as pq
from pydantic_core import to_json

from server.jobs.case_table import FIXED
from server.jobs.files import FULL, DiskFullError
from server.jobs.matlab import write_matlab
from server.jobs.netcdf import write_netcdf
from server.jobs.results import LostResultsError, Results
from server.jobs.results import about as told

BLOCK = 2**18
PREFIX = "download-"
FORGOTTEN_AFTER = 24 * 3600.0
"""After this long nobody sends a file any more; a server that was killed left it, s."""
REASON = FIXED.index("reason")
FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""How a cell begins that a spreadsheet would compute."""


def stream_json(results: Results) -> Iterator[bytes]:
    """Yield `{"columns": {name: [...]}, "units": {name: unit}}`, one column after another."""
    chunks = results.chunks()
    yield b'{"columns":{'
    for k, field in enumerate(results.schema):
        yield (b"," if k else b"") + to_json(field.name) + b":["
        is_json = field.name not in FIXED and pa.types.is_string(field.type)
        comma = b""
        for block in results.blocks([field.name], chunks=chunks):
            values = block.column(0).to_pylist()
            yield comma + (",".join(v or "null" for v in values).encode() if is_json else to_json(values)[1:-1])
            comma = b","
        yield b"]"
    units = {field.name: unit for field in results.schema if (unit := told(field, "unit"))}
    yield b'},"units":' + to_json(units) + b"}"


def stream_csv(results: Results) -> Iterator[bytes]:
    """Yield the table as CSV (RFC 4180, UTF-8): units in the header, all digits of numbers, an empty cell for nothing.

    A name or reason that a spreadsheet would take for a formula has an apostrophe before it.
    """
    chunks = results.chunks()
    yield _csv_lines([[_as_text(label(field)) for field in results.schema]])
    for block in results.blocks(chunks=chunks):
        columns = [column.to_pylist() for column in block.columns]
        columns[REASON] = [_as_text(reason) for reason in columns[REASON]]
        yield _csv_lines(zip(*columns, strict=True))


def label(field: pa.Field) -> str:
    """Return the heading of a column: its name, and its unit where it has one."""
    unit = told(field, "unit")
    return f"{field.name} [{unit}]" if unit and field.name not in FIXED else field.name


def parquet_file(results: Results, about: Mapping[str, Any]) -> Path:
    """Write the table as one Parquet file; the caller sends and deletes it.

    Units and meanings are in the metadata of its fields, `about` in that of its schema, what is no text as JSON.
    """
    chunks = results.chunks()
    told_of = {name: value if isinstance(value, str) else json.dumps(value) for name, value in about.items()}
    schema = results.schema.with_metadata(told_of)
    with _download(results, ".parquet") as path, pq.ParquetWriter(path, schema, compression="zstd") as writer:
        for block in results.blocks(chunks=chunks):
            writer.write_batch(block)
        return path


def netcdf_file(results: Results, about: Mapping[str, Any]) -> Path:
    """Write the table and the kept trajectories as NetCDF (see `netcdf`); the caller sends and deletes it."""
    with _download(results, ".nc") as path:
        write_netcdf(results, path, about)
        return path


def mat_file(results: Results, about: Mapping[str, Any]) -> Path:
    """Write the table for MATLAB (see `matlab`); the caller sends and deletes it. Raises `TooLargeError`."""
    with _download(results, ".mat") as path:
        write_matlab(results, path, about)
        return path


def file_blocks(path: Path) -> Iterator[bytes]:
    """Return the content of a file in blocks. Its name goes at once, its content with the iterator, used up or not."""
    file = path.open("rb")
    path.unlink()
    return _blocks_of(file)


def _blocks_of(file: BinaryIO) -> Iterator[bytes]:
    with file:
        yield from iter(lambda: file.read(BLOCK), b"")


@contextmanager
def _download(results: Results, ending: str) -> Iterator[Path]:
    """Make a file beside the chunks, where there is room for it; it is removed where what is within fails."""
    folder = results.files.folder if results.files.folder.is_dir() else Path(tempfile.gettempdir())
    _remove_forgotten(folder)
    with tempfile.NamedTemporaryFile(prefix=PREFIX, suffix=ending, dir=folder, delete=False) as file:
        path = Path(file.name)
    try:
        yield path
    except BaseException as error:
        path.unlink(missing_ok=True)
        if isinstance(error, FileNotFoundError):
            raise LostResultsError("the results are gone: the job was deleted meanwhile") from None
        if isinstance(error, OSError) and error.errno in FULL:
            message = f"the disk is full: there is no room to put a file of the results together ({error.strerror})"
            raise DiskFullError(f"{message}; free some space, or take CSV, which needs none") from None
        raise


def _remove_forgotten(folder: Path) -> None:
    for path in folder.glob(f"{PREFIX}*"):
        with suppress(OSError):
            if path.stat().st_mtime < time.time() - FORGOTTEN_AFTER:
                path.unlink()


def _as_text(text: str | None) -> str | None:
    return f"'{text}" if text is not None and text.startswith(FORMULA) else text


def _csv_lines(rows: Any) -> bytes:
    buffer = StringIO(newline="")
    csv.writer(buffer).writerows(rows)
    return buffer.getvalue().encode()
