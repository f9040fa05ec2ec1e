"""Owns how Alembic runs the versions: on the connection it is given, all in that connection's transaction."""

from __future__ import annotations

from alembic import context

from server.store import (
    job_tables,  # noqa: F401  # adds its tables to the metadata
    tables,
)

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=tables.metadata,
    transactional_ddl=True,
    compare_server_default=True,
)
with context.begin_transaction():
    context.run_migrations()
