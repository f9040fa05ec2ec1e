"""Owns the tables of jobs: what was asked, how far it is, which chunks are written, and who works on it.

Times are seconds since 1970. A chunk counts once its file is written whole: (job, chunk) is the key, so that no second
worker can count it again.
"""

from __future__ import annotations

from sqlalchemy import Boolean, Column, Float, ForeignKey, Index, Integer, String, Table, Text, UniqueConstraint

from server.store.tables import metadata

jobs = Table(
    "jobs",
    metadata,
    Column("id", String(26), primary_key=True),
    Column("kind", String(20), nullable=False),
    Column("name", String(200), nullable=False),
    Column("spec", Text, nullable=False),  # the batch document, the design inside it
    Column("about", Text, nullable=False),  # parameters, metrics, design and engine, as the record shows them (JSON)
    Column("checksum", String(64), nullable=False),
    Column("principal", String(80), nullable=False),
    Column("idempotency_key", String(255)),
    Column("request_digest", String(64), nullable=False),
    Column("state", String(20), nullable=False),
    Column("reason", Text),
    Column("cases", Integer, nullable=False),
    Column("chunk_size", Integer, nullable=False),
    Column("chunks", Integer, nullable=False),
    Column("done", Integer, nullable=False),
    Column("failed", Integer, nullable=False),
    Column("chunks_done", Integer, nullable=False),
    Column("rate", Float),  # cases a second, lately
    Column("processors", Text, nullable=False),  # kinds that computed its chunks, one a line
    Column("stopped_at", Integer),  # cases that count, where enough were known early
    Column("created", Float, nullable=False),
    Column("started", Float),
    Column("finished", Float),
    Column("cancel_requested", Boolean, nullable=False),
    Column("owner", String(64)),
    Column("lease_until", Float, nullable=False),
    Column("sequence", Integer, nullable=False),
    UniqueConstraint("principal", "idempotency_key", name="one_job_a_key"),
    Index("jobs_by_age", "created", "id"),
    Index("jobs_by_state", "state", "created", "id"),
    Index("jobs_by_checksum", "checksum"),
)

job_chunks = Table(
    "job_chunks",
    metadata,
    Column("job_id", String(26), ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True),
    Column("chunk", Integer, primary_key=True),
    Column("cases", Integer, nullable=False),
    Column("failed", Integer, nullable=False),
    Column("seconds", Float, nullable=False),
    Column("written", Float, nullable=False),
)

job_failures = Table(
    "job_failures",
    metadata,
    Column("job_id", String(26), ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True),
    Column("reason", String(400), primary_key=True),
    Column("cases", Integer, nullable=False),
    Column("first_case", Integer, nullable=False),
)
