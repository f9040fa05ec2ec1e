"""Jobs: what was asked, how far it is, the chunks that count, and failures by reason."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision: str | None = "0001"


def upgrade() -> None:
    """Make the tables of jobs."""
    op.create_table(
        "jobs",
        sa.Column("id", sa.String(26), nullable=False),
        *(sa.Column(name, sa.String(size), nullable=False) for name, size in (("kind", 20), ("name", 200))),
        *(sa.Column(name, sa.Text, nullable=False) for name in ("spec", "about")),
        *(sa.Column(name, sa.String(size), nullable=False) for name, size in (("checksum", 64), ("principal", 80))),
        sa.Column("idempotency_key", sa.String(255)),
        *(sa.Column(name, sa.String(size), nullable=False) for name, size in (("request_digest", 64), ("state", 20))),
        sa.Column("reason", sa.Text),
        *(sa.Column(name, sa.Integer, nullable=False) for name in ("cases", "chunk_size", "chunks")),
        *(sa.Column(name, sa.Integer, nullable=False) for name in ("done", "failed", "chunks_done")),
        sa.Column("rate", sa.Float),
        sa.Column("processors", sa.Text, nullable=False),
        sa.Column("stopped_at", sa.Integer),
        sa.Column("created", sa.Float, nullable=False),
        *(sa.Column(name, sa.Float) for name in ("started", "finished")),
        sa.Column("cancel_requested", sa.Boolean, nullable=False),
        sa.Column("owner", sa.String(64)),
        sa.Column("lease_until", sa.Float, nullable=False),
        sa.Column("sequence", sa.Integer, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_jobs"),
        sa.UniqueConstraint("principal", "idempotency_key", name="one_job_a_key"),
    )
    op.create_index("jobs_by_age", "jobs", ["created", "id"])
    op.create_index("jobs_by_state", "jobs", ["state", "created", "id"])
    op.create_index("jobs_by_checksum", "jobs", ["checksum"])
    _make_chunks()


def _make_chunks() -> None:
    op.create_table(
        "job_chunks",
        sa.Column("job_id", sa.String(26), sa.ForeignKey("jobs.id", name="fk_job_chunks_job_id", ondelete="CASCADE")),
        *(sa.Column(name, sa.Integer, nullable=False) for name in ("chunk", "cases", "failed")),
        *(sa.Column(name, sa.Float, nullable=False) for name in ("seconds", "written")),
        sa.PrimaryKeyConstraint("job_id", "chunk", name="pk_job_chunks"),
    )
    op.create_table(
        "job_failures",
        sa.Column("job_id", sa.String(26), sa.ForeignKey("jobs.id", name="fk_job_failures_job_id", ondelete="CASCADE")),
        sa.Column("reason", sa.String(400), nullable=False),
        *(sa.Column(name, sa.Integer, nullable=False) for name in ("cases", "first_case")),
        sa.PrimaryKeyConstraint("job_id", "reason", name="pk_job_failures"),
    )
