"""Owns a job's results as one NetCDF 4 file by the CF conventions, written block by block.

The case table lies along `case`. Kept trajectories are a contiguous ragged array as in the chunks' own files: samples
along `obs`, and `row_size` counts those of each case, none where none was kept.

The file is defined by h5netcdf, then filled by h5py, since h5netcdf looks dimensions up at every access. Room on the
disk is taken before: HDF5 does not survive a disk that is full while it writes.
"""

from __future__ import annotations

import errno
import json
import os
import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5netcdf
import h5py
import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from models.variables import ALL_CELL_VARIABLES, ALL_VARIABLES
from server.jobs.case_table import FIXED
from server.jobs.column_names import plain_names
from server.jobs.results import Results
from server.jobs.results import about as told
from server.jobs.trajectories import CONVENTIONS

TEXT = h5py.string_dtype()
LONGEST_NAME = 80
ROWS_AT_ONCE = 100_000
"""Most samples of one variable that are copied at once."""
BYTES_A_TEXT = 40
"""What a text takes beside its letters."""
BYTES_A_VARIABLE = 4096
"""What a variable takes beside its values, at most."""
MARGIN, LEAST_ROOM = 1.1, 2**20
PLACES = ("time", "x", "y", "z")
"""Where and when a sample is: the auxiliary coordinates of the others."""
TAKEN = (*FIXED, "row_size", "time", "obs", "cell", *ALL_VARIABLES, *ALL_CELL_VARIABLES)


@dataclass(frozen=True, slots=True)
class _Kept:
    """Trajectories of one chunk: `rows` of the table have `sizes` samples each."""

    path: Path
    rows: NDArray[np.int64]
    sizes: NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class _Samples:
    """All kept trajectories: `variables` holds attributes by name, `cells` the names along `cell`."""

    kept: Sequence[_Kept]
    variables: Mapping[str, tuple[tuple[str, ...], dict[str, Any]]]
    cells: Sequence[str]

    @property
    def count(self) -> int:
        """How many samples there are."""
        return sum(int(each.sizes.sum()) for each in self.kept)

    @property
    def bytes(self) -> int:
        """About how many bytes they take."""
        by_cell = sum("cell" in dimensions for dimensions, _ in self.variables.values())
        return 8 * self.count * (len(self.variables) + by_cell * len(self.cells))


def write_netcdf(results: Results, path: Path, about: Mapping[str, Any]) -> None:
    """Write the results that are there; `about` becomes global attributes, what is no text or number as JSON.

    Raises
    ------
    OSError
        Where the disk has no room.

    """
    chunks, names = results.chunks(), column_names(results)
    samples = _look_through(results, chunks)
    attributes = {"Conventions": CONVENTIONS} | {name: _attribute(value) for name, value in about.items()}
    size = _table_bytes(results, chunks) + samples.bytes + BYTES_A_VARIABLE * (len(names) + len(samples.variables))
    size += sum(len(str(value)) for value in attributes.values())
    _take_room(path, size)  # is there any?
    with h5netcdf.File(path, "w") as file:  # gives it back
        file.dimensions = {"case": results.count(chunks)}
        for field in results.schema:
            _add_column(file, names[field.name], field)
        if samples.kept:
            file.variables["case"].attrs["cf_role"] = "trajectory_id"
            attributes["featureType"] = "trajectory"
            _define_samples(file, samples)
        file.attrs.update(attributes)
    _take_room(path, size)
    with h5py.File(path, "r+") as file:
        _fill_table(file, results, chunks)
        if samples.kept:
            _fill_samples(file, samples)


def column_names(results: Results) -> dict[str, str]:
    """Return the name of the variable that holds each column; their own names are in `long_name`."""
    own = plain_names((c.name for c in results.columns()), longest=LONGEST_NAME, taken=TAKEN)
    return {name: name for name in FIXED} | own


def _take_room(path: Path, size: int) -> None:
    """Have the disk set room aside for what comes; HDF5 gives back what it does not need."""
    wanted = int(MARGIN * size) + LEAST_ROOM
    if not hasattr(os, "posix_fallocate"):  # macOS has none: a look is what there is
        if shutil.disk_usage(path.parent).free < wanted:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return
    with path.open("r+b") as file:
        os.posix_fallocate(file.fileno(), 0, wanted)


def _table_bytes(results: Results, chunks: Sequence[int]) -> int:
    """Return about how many bytes the table takes; texts lie in a heap beside it."""
    texts = [field.name for field in results.schema if pa.types.is_string(field.type)]
    length = sum(
        pc.sum(pc.binary_length(column)).as_py() or 0
        for block in results.blocks(texts, chunks=chunks)
        for column in block.columns
    )
    return length + results.count(chunks) * (8 * len(results.schema) + BYTES_A_TEXT * len(texts))


def _fill_table(file: Any, results: Results, chunks: Sequence[int]) -> None:
    names, begin = column_names(results), 0
    for block in results.blocks(chunks=chunks):
        end = begin + block.num_rows
        for field, column in zip(block.schema, block.columns, strict=True):
            file[names[field.name]][begin:end] = _values(column)
        begin = end


def _add_column(file: Any, name: str, field: pa.Field) -> None:
    attributes = {"long_name": field.name, "comment": told(field, "meaning")}
    if field.name == "case":
        variable = file.create_variable(name, ("case",), np.int64)
        attributes = {"long_name": told(field, "meaning")}
    elif pa.types.is_string(field.type):
        variable = file.create_variable(name, ("case",), TEXT)
    else:
        variable = file.create_variable(name, ("case",), np.float64, fillvalue=np.nan)
        attributes["units"] = told(field, "unit") or "1"
    if role := told(field, "role"):
        attributes["role"] = role
    variable.attrs.update({key: value for key, value in attributes.items() if value})


def _values(column: pa.Array) -> NDArray[Any]:
    if not pa.types.is_string(column.type):
        return np.asarray(column.to_numpy(zero_copy_only=False))
    # HDF5 ends a text at a zero character
    return np.array([(text or "").replace("\0", "\\0") for text in column.to_pylist()], dtype=object)


def _look_through(results: Results, chunks: Sequence[int]) -> _Samples:
    """Return what the trajectory files of some chunks hold."""
    kept: list[_Kept] = []
    variables: dict[str, tuple[tuple[str, ...], dict[str, Any]]] = {}
    cells: dict[str, None] = {}
    seen: set[str] = set()
    begin = 0
    for chunk in chunks:
        path, end = results.trajectories(chunk), begin + results.count([chunk])
        if path is not None:
            with h5py.File(path, "r") as file:
                rows = file["case"][:] - chunk * results.chunk_size + begin
                counted = rows < end
                sizes, names, own = file["row_size"][:][counted], set(file), file["cell"].asstr()[:].tolist()
            if counted.any():
                kept.append(_Kept(path, rows[counted], sizes))
                cells |= dict.fromkeys(own)
                if not names <= seen:
                    variables = _described(path) | variables
                seen |= names
        begin = end
    return _Samples(kept, variables, list(cells))


def _described(path: Path) -> dict[str, tuple[tuple[str, ...], dict[str, Any]]]:
    """Return dimensions and attributes of the variables along `obs` of a chunk's file."""
    with h5netcdf.File(path, "r") as file:
        return {
            name: (variable.dimensions, dict(variable.attrs))
            for name, variable in file.variables.items()
            if variable.dimensions[:1] == ("obs",) and 0 not in variable.shape
        }


def _define_samples(file: Any, samples: _Samples) -> None:
    file.dimensions["obs"] = samples.count
    row_size = file.create_variable("row_size", ("case",), np.int64)
    row_size.attrs.update({"long_name": "number of samples of the case", "sample_dimension": "obs"})
    if samples.cells:
        file.dimensions["cell"] = len(samples.cells)
        cell = file.create_variable("cell", ("cell",), TEXT)
        cell.attrs["long_name"] = "buoyancy cell or moving part"
    places = " ".join(name for name in PLACES if name in samples.variables)
    for name, (dimensions, given) in samples.variables.items():
        variable = file.create_variable(name, dimensions, np.float64, fillvalue=np.nan)
        attributes = {key: value for key, value in given.items() if key != "_FillValue"}
        variable.attrs.update(attributes if name in PLACES else attributes | {"coordinates": places})


def _fill_samples(file: Any, samples: _Samples) -> None:
    sizes = np.zeros(file["row_size"].shape, dtype=np.int64)
    begin = 0
    for each in samples.kept:
        size = int(each.sizes.sum())
        sizes[each.rows] = each.sizes
        with h5py.File(each.path, "r") as source:
            columns = [samples.cells.index(cell) for cell in source["cell"].asstr()[:].tolist()]
            for name in samples.variables:
                if name in source:
                    _copy(source[name], file[name], columns, begin, size)
        begin += size
    file["row_size"][:] = sizes
    if samples.cells:
        file["cell"][:] = np.array(samples.cells, dtype=object)


def _copy(source: Any, target: Any, columns: Sequence[int], begin: int, size: int) -> None:
    for first, last in _ranges(size):
        values = source[first:last]
        if target.ndim == 2:
            values = _spread(values, columns, target.shape[1])
        target[begin + first : begin + last] = values


def _ranges(size: int) -> Iterator[tuple[int, int]]:
    for first in range(0, size, ROWS_AT_ONCE):
        yield first, min(first + ROWS_AT_ONCE, size)


def _spread(values: NDArray[np.float64], columns: Sequence[int], count: int) -> NDArray[np.float64]:
    """Return a table by cell with the columns of all cells, NaN where the chunk has none."""
    table = np.full((len(values), count), np.nan)
    table[:, columns] = values
    return table


def _attribute(value: Any) -> Any:
    return value if isinstance(value, str | int | float) and not isinstance(value, bool) else json.dumps(value)
