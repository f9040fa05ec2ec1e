"""Owns the case table as a Parquet file: one row a case; what it was given, how it ended, what it measured.

Columns: case, status, reason, one a parameter, one a metric, in this order. Units, meanings and roles are in the
fields' metadata. A value of a parameter that is no number is kept as JSON.
"""

from __future__ import annotations

import io
import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import pyarrow as pa
import pyarrow.parquet as pq

from server.jobs.task import CRASHED, REFUSED, ColumnInfo
from server.store.job_records import LONGEST_REASON

FIXED = ("case", "status", "reason")
NUMBER = re.compile(r"-?\d+(\.\d+)?([eE][-+]?\d+)?")


@dataclass(frozen=True, slots=True)
class CaseRow:
    """One case: `values` of the parameters, `metrics` (NaN where one does not apply)."""

    case: int
    status: str
    reason: str | None
    values: Sequence[object]
    metrics: Sequence[float]

    @property
    def group(self) -> str:
        """Under which reason it is counted with others."""
        return group_of(self.status, self.reason)


def group_of(status: str, reason: str | None) -> str:
    """Return a failure's reason without its numbers, so that those of one kind are counted together."""
    if status in (CRASHED, REFUSED):
        return f"{status}: {NUMBER.sub('…', reason or '')}"[:LONGEST_REASON]
    return status


def is_number(value: object) -> bool:
    """Whether a parameter's value is a number."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def table_schema(columns: Sequence[ColumnInfo]) -> pa.Schema:
    """Return the schema of the table."""
    about = [
        pa.field(
            column.name, pa.float64() if column.numeric else pa.string(), nullable=True,
            metadata={"unit": column.unit, "meaning": column.meaning, "role": column.role},
        )
        for column in columns
    ]  # fmt: skip
    fixed = [
        pa.field("case", pa.int64(), nullable=False, metadata={"unit": "1", "meaning": "number of the case"}),
        pa.field("status", pa.string(), nullable=False, metadata={"meaning": "how the case ended"}),
        pa.field("reason", pa.string(), metadata={"meaning": "why it failed"}),
    ]
    return pa.schema([*fixed, *about])


def write_table(rows: Sequence[CaseRow], columns: Sequence[ColumnInfo]) -> bytes:
    """Return the rows as a Parquet file; equal rows give equal bytes."""
    schema = table_schema(columns)
    parameters = sum(column.role == "parameter" for column in columns)
    data: list[Sequence[object]] = [
        [row.case for row in rows], [row.status for row in rows], [row.reason for row in rows],
    ]  # fmt: skip
    for i, column in enumerate(columns):
        if i < parameters:
            data.append([_cell(row.values[i], column) for row in rows])
        else:
            data.append([_finite(row.metrics[i - parameters]) for row in rows])
    arrays = [pa.array(column, field.type) for column, field in zip(data, schema, strict=True)]
    return parquet_bytes(pa.Table.from_arrays(arrays, schema=schema))


def parquet_bytes(table: pa.Table) -> bytes:
    """Return a table as a Parquet file."""
    out = io.BytesIO()
    pq.write_table(table, out, compression="zstd")
    return out.getvalue()


def read_table(content: bytes) -> pa.Table:
    """Read a chunk's file back."""
    return pq.read_table(io.BytesIO(content))


def _cell(value: object, column: ColumnInfo) -> object:
    if column.numeric:
        return float(value) if is_number(value) else None  # type: ignore[arg-type]
    return json.dumps(value)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
