"""Owns what programs of each version of the schema kept: rows by table, in the order in which they can be inserted.

They are written out, since the stores write what the newest version does. A version that makes a table adds its rows.
"""

from __future__ import annotations

from typing import Any

from sqlalchemy import Connection, text

from models.presets import load_preset
from server.store.records import Content

GLIDER = Content(load_preset("three-cell-glider"))
DESIGN, OTHER, JOB = (f"01hq{'0' * 21}{letter}" for letter in "abj")
Rows = dict[str, list[dict[str, Any]]]
ROWS: dict[str, Rows] = {
    "0001": {
        "documents": [
            {"identity": GLIDER.identity, "content": GLIDER.document},
            {"identity": "e" * 64, "content": '{"format": "glider-design", "name": "Größe Ω"}'},
        ],
        "designs": [
            {
                "id": DESIGN, "name": "Tres células", "name_folded": "tres células", "summary": "planar, 3 cells",
                "tags": '["Lake"]', "revision": 2, "identity": GLIDER.identity, "created": 1.7e9 + 1 / 3,
                "updated": 1.7e9 + 0.1, "deleted": None,
            },
            {
                "id": OTHER, "name": "Größe Ω", "name_folded": "grösse ω", "summary": "", "tags": "[]", "revision": 1,
                "identity": "e" * 64, "created": 1.6e9, "updated": 1.6e9, "deleted": 1.65e9 + 1e-6,
            },
        ],
        "revisions": [
            {
                "design_id": DESIGN, "number": 1, "identity": "e" * 64, "name": "Größe Ω", "tags": "[]", "comment": "",
                "created": 1.7e9 + 1 / 3,
            },
            {
                "design_id": DESIGN, "number": 2, "identity": GLIDER.identity, "name": "Tres células",
                "tags": '["Lake"]', "comment": "a heavier \"ballast\"\n", "created": 1.7e9 + 0.1,
            },
            {
                "design_id": OTHER, "number": 1, "identity": "e" * 64, "name": "Größe Ω", "tags": "[]", "comment": "",
                "created": 1.6e9,
            },
        ],
        "design_tags": [{"design": 1, "tag": "lake"}],
        "design_texts": [
            {"design": 1, "folded": "tres células\nlake\na note of long ago"},
            {"design": 2, "folded": "grösse ω"},
        ],
        "thumbnails": [
            {
                "design_id": DESIGN, "media_type": "image/png", "digest": "d" * 64, "created": 1.7e9 + 0.2,
                "content": bytes(range(256)),
            }
        ],
    },
    "0002": {
        "jobs": [
            {
                "id": JOB, "kind": "sweep", "name": "Lengths", "spec": '{"kind": "sweep"}', "about": '{"metrics": []}',
                "checksum": "c" * 64, "principal": "anna", "idempotency_key": "monday", "request_digest": "r" * 64,
                "state": "paused", "reason": "the disk is full", "cases": 2_000_000_000, "chunk_size": 100_000,
                "chunks": 20_000, "done": 200_000, "failed": 7, "chunks_done": 2, "rate": 1234.5, "processors": "a\nb",
                "stopped_at": None, "created": 1.7e9 + 1 / 3, "started": 1.7e9 + 1.0, "finished": None,
                "cancel_requested": True, "owner": None, "lease_until": 0.0, "sequence": 41,
            }
        ],
        "job_chunks": [
            {"job_id": JOB, "chunk": 0, "cases": 100_000, "failed": 7, "seconds": 0.1, "written": 1.7e9 + 2.0},
            {"job_id": JOB, "chunk": 19_999, "cases": 100_000, "failed": 0, "seconds": 0.2, "written": 1.7e9 + 3.0},
        ],
        "job_failures": [{"job_id": JOB, "reason": "refused: … outside …", "cases": 7, "first_case": 3}],
    },
}  # fmt: skip


def rows_until(version: str) -> Rows:
    """Return what a database of a version holds."""
    return {table: rows for known, tables in ROWS.items() if known <= version for table, rows in tables.items()}


def insert_rows(connection: Connection, tables: Rows) -> None:
    """Insert rows in plain SQL: `designs` count themselves, from 1."""
    for table, rows in tables.items():
        names = list(rows[0])
        values = ", ".join(f":{name}" for name in names)
        connection.execute(text(f"INSERT INTO {table} ({', '.join(names)}) VALUES ({values})"), rows)


def read_rows(connection: Connection, tables: Rows) -> Rows:
    """Return the whole of these tables in the columns, and the order, of the rows given."""
    found: Rows = {}
    for table, rows in tables.items():
        names = list(rows[0])
        selected = connection.execute(text(f"SELECT {', '.join(names)} FROM {table}")).mappings()
        found[table] = sorted((dict(row) for row in selected), key=lambda row: rows.index(row) if row in rows else -1)
    return found
