"""Owns the connection to the database: SQLite in a file, or PostgreSQL; opened and upgraded at its first use."""

from __future__ import annotations

import logging
import sqlite3
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Engine, Insert, Table, create_engine, event, func, select
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import (
    DatabaseError,
    DataError,
    IntegrityError,
    InterfaceError,
    InternalError,
    NotSupportedError,
    ProgrammingError,
    SQLAlchemyError,
    TimeoutError,
)

from server.store.errors import UnavailableError
from server.store.migrations import HEAD, NewerSchemaError, upgrade

WRITES = "glider_writes"
PAUSE = 0.02  # s between tries
PATIENCE = 10.0
"""How long a connection waits for other writers, s."""
PRAGMAS = (f"busy_timeout={1e3 * PATIENCE:.0f}", "synchronous=NORMAL", "foreign_keys=ON")
POOL: dict[str, Any] = {"pool_size": 10, "max_overflow": 40, "pool_timeout": 10.0}
"""As many connections as the server has worker threads, so that none waits for another's."""
OURS = (DataError, IntegrityError, InternalError, NotSupportedError, ProgrammingError)
"""Errors of a database that are faults of the program."""
_log = logging.getLogger(__name__)


def sqlite_url(path: Path) -> str:
    """Return the URL of a database in a file."""
    return URL.create("sqlite", database=str(path)).render_as_string()


class Database:
    """One database. Nothing is opened until it is first used; then its schema is brought to a version, the newest."""

    def __init__(self, url: str, *, version: str = HEAD) -> None:
        self.url = make_url(url)
        if self.url.get_backend_name() == "postgresql":
            self.url = self.url.set(drivername="postgresql+psycopg")
        self._version = version
        self._engine: Engine | None = None
        self._opening = threading.Lock()

    @property
    def engine(self) -> Engine:
        """The engine, its schema up to date."""
        if self._engine is None:
            with self._opening:
                if self._engine is None:
                    self._engine = self._opened()
        return self._engine

    def _opened(self) -> Engine:
        engine = _make_engine(self.url)
        try:
            with _told(), _transaction(engine, writes=True) as connection:
                upgrade(connection, self._version)
        except NewerSchemaError as error:
            engine.dispose()
            raise UnavailableError(
                f"the database has version {error}, which this program does not know: use a newer glider studio"
            ) from None
        except BaseException:
            engine.dispose()
            raise
        return engine

    @contextmanager
    def read(self) -> Iterator[Connection]:
        """Enter a transaction that only reads: all it sees is of one instant in SQLite."""
        with _told(), _transaction(self.engine, writes=False) as connection:
            yield connection

    @contextmanager
    def write(self) -> Iterator[Connection]:
        """Enter a transaction that writes; it is kept whole, or undone whole where an exception leaves it."""
        with _told(), _transaction(self.engine, writes=True) as connection:
            yield connection

    def close(self) -> None:
        """Close all connections; a later use opens the database again."""
        with self._opening:
            if self._engine is not None:
                self._engine.dispose()
            self._engine = None


def insert_once(connection: Connection, table: Table) -> Insert:
    """Return an INSERT that leaves a row that is already there as it is."""
    dialect = sqlite if connection.dialect.name == "sqlite" else postgresql
    statement: Insert = dialect.insert(table).on_conflict_do_nothing()
    return statement


def hold_word(connection: Connection, word: str) -> None:
    """Have others who hold the same word wait until this transaction, which writes, ends; SQLite has one writer."""
    if connection.dialect.name == "postgresql":
        connection.execute(select(func.pg_advisory_xact_lock(func.hashtextextended(word, 0))))


def _make_engine(url: URL) -> Engine:
    if url.get_backend_name() != "sqlite":
        return create_engine(url, pool_pre_ping=True, connect_args={"connect_timeout": 5}, **POOL)
    try:
        Path(url.database or "").parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UnavailableError(f"the folder of the database cannot be made: {error}") from None
    engine = create_engine(url, **POOL)
    event.listen(engine, "connect", _prepare)
    event.listen(engine, "begin", _begin)
    return engine


def _prepare(connection: Any, record: object) -> None:
    connection.isolation_level = None  # the driver would begin transactions late, when it meets the first write
    connection.create_function("lower", 1, _lower, deterministic=True)
    for pragma in PRAGMAS:
        connection.execute(f"PRAGMA {pragma}").close()
    _write_ahead(connection)


def _lower(value: Any) -> Any:
    """Stand for SQLite's own `lower`, which knows the letters of ASCII alone."""
    return value.lower() if isinstance(value, str) else value


def _write_ahead(connection: Any) -> None:
    """Have a new file keep a write-ahead log; while others open it too SQLite refuses that without its own patience."""
    until = time.monotonic() + PATIENCE
    while True:
        try:
            connection.execute("PRAGMA journal_mode=WAL").close()
            return
        except sqlite3.OperationalError as error:
            if error.sqlite_errorcode & 0xFF != sqlite3.SQLITE_BUSY or time.monotonic() > until:
                raise
        time.sleep(PAUSE)


def _begin(connection: Connection) -> None:
    # a writer takes its lock at once: to wait for it later, after having read, is refused by SQLite
    connection.exec_driver_sql("BEGIN IMMEDIATE" if connection.get_execution_options().get(WRITES) else "BEGIN")


@contextmanager
def _transaction(engine: Engine, *, writes: bool) -> Iterator[Connection]:
    with engine.connect().execution_options(**{WRITES: writes}) as connection, connection.begin():
        yield connection


@contextmanager
def _told() -> Iterator[None]:
    """Turn what the database cannot do into an `UnavailableError`; its own words may hold addresses: to the log."""
    try:
        yield
    except (DatabaseError, InterfaceError, TimeoutError) as error:
        if isinstance(error, OURS):
            raise
        _log.error("the database failed", exc_info=error)
        raise UnavailableError(_reason(error)) from None


def _reason(error: SQLAlchemyError) -> str:
    words = str(getattr(error, "orig", error))
    for said, reason in (
        ("disk is full", "the disk is full: free some space, and try again"),
        ("No space left", "the database's disk is full: free some space, and try again"),
        ("readonly", "the database cannot be written: check who owns its file"),
        (
            "not a database",
            "the database's file is not a database: move it away, or name another in GLIDER_STUDIO_DATA",
        ),
        ("malformed", "the database's file is damaged: restore it from a copy"),
        ("unable to open", "the database's file cannot be opened: check GLIDER_STUDIO_DATA and who owns it"),
        ("locked", "the database is busy with other writers: try again"),
    ):
        if said in words:
            return reason
    return "the database does not answer: try again, or look into the server's log"
