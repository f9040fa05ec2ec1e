"""Owns the upgrade of a database to the newest version of its schema, run by the program itself."""

from __future__ import annotations

from pathlib import Path

from sqlalchemy import Connection, inspect, text

HERE = Path(__file__).parent
HEAD = "0002"
"""The newest version in versions/; asked for at every start, so that Alembic loads only where there is work for it."""


class NewerSchemaError(Exception):
    """A database is of a version that this program does not know."""


def upgrade(connection: Connection, version: str = HEAD) -> None:
    """Bring a database to a version, in the transaction of `connection`, which must allow it to write.

    Raises
    ------
    NewerSchemaError
        Where the database was brought to a version that this program does not know.

    """
    if connection.dialect.name == "postgresql":
        # several programs may start at once: the second waits here, and finds the work done
        connection.execute(text("SELECT pg_advisory_xact_lock(7310578)"))
    now = current_version(connection)
    if now == version:
        return
    from alembic import command
    from alembic.config import Config
    from alembic.util import CommandError

    config = Config()
    config.set_main_option("script_location", str(HERE).replace("%", "%%"))
    config.set_main_option("path_separator", "os")
    config.attributes["connection"] = connection
    try:
        command.upgrade(config, version)
    except CommandError as error:
        if "Can't locate revision" in str(error):
            raise NewerSchemaError(now) from None
        raise


def current_version(connection: Connection) -> str | None:
    """Return the version of a database's schema, or None where it is empty."""
    if not inspect(connection).has_table("alembic_version"):
        return None
    version: str | None = connection.execute(text("SELECT version_num FROM alembic_version")).scalar()
    return version
