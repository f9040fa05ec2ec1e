"""Owns a job's chunk files read as one table: page by page, case by case, or batch by batch in little memory.

Only cases below `cases` count, which is fewer than were computed where a job stopped early; chunks that are not written
yet are passed over.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from server.jobs.case_table import FIXED, table_schema
from server.jobs.files import TRAJECTORIES, JobFiles
from server.jobs.task import ColumnInfo

VALUES_A_BLOCK = 500_000
"""About how many values `blocks` holds at once."""
MOST_CHUNKS_A_PAGE = 2000
"""Most chunks that one page looks through; where few cases have the wanted status, a page may hold fewer than asked."""


class LostResultsError(Exception):
    """Results that were there are gone or cannot be read."""


class Results:
    """The case table of a job, of whose cases the first `cases` count."""

    def __init__(self, files: JobFiles, *, cases: int, chunk_size: int) -> None:
        self.files, self.cases, self.chunk_size = files, cases, chunk_size
        self._schema: pa.Schema | None = None

    @property
    def schema(self) -> pa.Schema:
        """Columns with their units, meanings and roles; the fixed ones only while no chunk is written."""
        if self._schema is None:
            first = self._any_chunk()
            if first is None:
                return table_schema(())
            with self._open(first) as file:
                self._schema = file.schema_arrow
        return self._schema

    def _any_chunk(self) -> int | None:
        """Return a chunk that is written, None where there is none; nearly always the first is, found at once."""
        if self.cases > 0 and self.files.path(0).exists():
            return 0
        return next(iter(self.chunks()), None)

    def columns(self) -> list[ColumnInfo]:
        """Return the job's own columns: its parameters, then its metrics."""
        return [_info(field) for field in self.schema if field.name not in FIXED]

    def chunks(self) -> list[int]:
        """Return the numbers of the chunks that are written and count, in order."""
        found = (int(path.stem.removeprefix("chunk-")) for path in self.files.written())
        return [chunk for chunk in found if chunk * self.chunk_size < self.cases]

    def count(self, chunks: Sequence[int] | None = None) -> int:
        """Return how many cases these chunks hold, or all that are written."""
        return sum(self._counted(chunk) for chunk in (self.chunks() if chunks is None else chunks))

    def trajectories(self, chunk: int) -> Path | None:
        """Return the file with a chunk's kept trajectories, None where it kept none."""
        path = self.files.path(chunk, TRAJECTORIES)
        return path if path.exists() else None

    def batches(
        self, names: Sequence[str] | None = None, *, chunks: Sequence[int] | None = None
    ) -> Iterator[pa.RecordBatch]:
        """Yield the table, one batch a chunk.

        Parameters
        ----------
        names
            Which columns, in which order; all by default.
        chunks
            Which chunks; by default those written when the first batch is asked for.

        Raises
        ------
        LostResultsError
            Where a chunk is gone or damaged.

        """
        chosen = self.chunks() if chunks is None else chunks
        wanted = self.schema if names is None else pa.schema([self.schema.field(name) for name in names])
        for chunk in chosen:
            yield self._read(chunk, wanted).combine_chunks().to_batches()[0]

    def blocks(
        self, names: Sequence[str] | None = None, *, chunks: Sequence[int] | None = None
    ) -> Iterator[pa.RecordBatch]:
        """Yield the table as `batches` does, small chunks together; a block ends where a chunk does."""
        held: list[pa.RecordBatch] = []
        values = 0
        for batch in self.batches(names, chunks=chunks):
            held.append(batch)
            values += batch.num_rows * batch.num_columns
            if values >= VALUES_A_BLOCK:
                yield _joined(held)
                held, values = [], 0
        if held:
            yield _joined(held)

    def page(
        self, after: int, limit: int, status: Collection[str] | None = None
    ) -> tuple[list[dict[str, Any]], int | None]:
        """Return up to `limit` cases beyond number `after`, and `after` for the next page, None where this is the last.

        The first page is that after -1. With `status` only cases that ended so are returned.
        """
        found: list[dict[str, Any]] = []
        looked = 0
        for chunk in range((after + 1) // self.chunk_size, -(-self.cases // self.chunk_size)):
            if looked == MOST_CHUNKS_A_PAGE:
                return found, chunk * self.chunk_size - 1
            table = self._matching(chunk, after, status)
            if table is None:
                continue
            looked += 1
            found += self._records(table.slice(0, limit + 1 - len(found)))
            if len(found) > limit:
                return found[:limit], int(found[limit - 1]["case"])
        return found, None

    def case(self, number: int) -> dict[str, Any] | None:
        """Return one case, None where it is not done or does not count."""
        if not 0 <= number < self.cases:
            return None
        table = self._matching(number // self.chunk_size, number - 1, None)
        return None if table is None else self._records(table.slice(0, 1))[0]

    def _counted(self, chunk: int) -> int:
        return max(0, min(self.chunk_size, self.cases - chunk * self.chunk_size))

    def _open(self, chunk: int) -> pq.ParquetFile:
        """Open a chunk's file, in memory: it is small, and the same to its end whatever happens to the file."""
        cases = f"cases {chunk * self.chunk_size} to {(chunk + 1) * self.chunk_size - 1}"
        try:
            return pq.ParquetFile(pa.BufferReader(self.files.path(chunk).read_bytes()))
        except FileNotFoundError:
            raise LostResultsError(f"the results of {cases} are gone: the job was deleted meanwhile") from None
        except (pa.ArrowInvalid, OSError) as error:
            message = f"the results of {cases} cannot be read ({error}): run the job again"
            raise LostResultsError(message) from None

    def _read(self, chunk: int, schema: pa.Schema) -> pa.Table:
        with self._open(chunk) as file:
            table = file.read(columns=schema.names, use_threads=False)
        table = table.slice(0, self._counted(chunk))
        return pa.Table.from_arrays([table.column(name) for name in schema.names], schema=schema)

    def _matching(self, chunk: int, after: int, status: Collection[str] | None) -> pa.Table | None:
        """Return the wanted cases of a chunk, None where it is not written."""
        if not self.files.path(chunk).exists():
            return None
        if status is not None and not self._may_hold(chunk, status):
            return self.schema.empty_table()
        table = self._read(chunk, self.schema).slice(max(0, after + 1 - chunk * self.chunk_size))
        if status is None:
            return table
        return table.filter(pc.is_in(table.column("status"), value_set=pa.array(list(status), pa.string())))

    def _may_hold(self, chunk: int, status: Collection[str]) -> bool:
        """Whether a chunk may hold a case that ended so, by what the file says about its column."""
        with self._open(chunk) as file:
            told = file.metadata.row_group(0).column(FIXED.index("status")).statistics
        return told is None or not told.has_min_max or told.min != told.max or told.min in status

    def _records(self, table: pa.Table) -> list[dict[str, Any]]:
        columns = self.columns()
        parameters = [column for column in columns if column.role == "parameter"]
        metrics = [column.name for column in columns if column.role == "metric"]
        return [
            {
                **{name: row[name] for name in FIXED},
                "parameters": {column.name: decoded(row[column.name], column) for column in parameters},
                "metrics": {name: row[name] for name in metrics},
            }
            for row in table.to_pylist()
        ]


def decoded(value: Any, column: ColumnInfo) -> Any:
    """Return a parameter's value as it was given; what is no number is kept as JSON."""
    return value if column.numeric or value is None else json.loads(value)


def about(field: pa.Field, what: str) -> str:
    """Return the unit, meaning or role of a column, empty where it has none."""
    return str((field.metadata or {}).get(what.encode(), b"").decode())


def _info(field: pa.Field) -> ColumnInfo:
    unit, meaning, role = (about(field, what) for what in ("unit", "meaning", "role"))
    return ColumnInfo(field.name, unit, meaning, role, bool(pa.types.is_floating(field.type)))


def _joined(batches: Sequence[pa.RecordBatch]) -> pa.RecordBatch:
    return pa.Table.from_batches(batches).combine_chunks().to_batches()[0]
