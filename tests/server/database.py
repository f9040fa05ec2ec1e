"""Owns the databases of the tests: a new SQLite file, and an emptied database of a PostgreSQL of our own on loopback.

PostgreSQL refuses to run as root: there its programs run as the user `postgres` that Debian's package makes. Where it
is missing the tests fail: `make test` installs it.
"""

from __future__ import annotations

import os
import pwd
import shutil
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import psycopg
import pytest

from server.store.database import Database, sqlite_url
from server.store.designs import DesignStore

USER, NAME = "postgres", "postgres"
STARTS_WITHIN = 30.0
SETTINGS = ("listen_addresses=127.0.0.1", "unix_socket_directories=", "fsync=off", "max_connections=120")
"""No lock files outside, no waiting for a disk whose content is thrown away."""


class Postgres:
    """A PostgreSQL of a cluster of its own, which sorts words as people do, not by code point."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.data = folder / "data"
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        self._process: subprocess.Popen[bytes] | None = None

    def make(self) -> None:
        if os.geteuid() == 0:
            os.chown(self.folder, pwd.getpwnam(USER).pw_uid, pwd.getpwnam(USER).pw_gid)
        words = ("--locale=C.UTF-8", "--encoding=UTF8", "--locale-provider=icu", "--icu-locale=en")
        command = self._command("initdb", "-D", self.data, "-U", USER, "-A", "trust", "--no-sync", *words)
        subprocess.run(command, cwd=self.folder, check=True, stdout=subprocess.DEVNULL)

    def start(self) -> None:
        options = [part for setting in SETTINGS for part in ("-c", setting)]
        command = self._command("postgres", "-D", self.data, "-p", str(self.port), *options)
        with (self.folder / "log").open("ab") as log:
            self._process = subprocess.Popen(command, cwd=self.folder, stdout=log, stderr=log)
        deadline = time.monotonic() + STARTS_WITHIN
        while True:
            try:
                psycopg.connect(self.url(NAME), connect_timeout=2).close()
                return
            except psycopg.OperationalError:
                assert self._process.poll() is None, (self.folder / "log").read_text()
                assert time.monotonic() < deadline, (self.folder / "log").read_text()
                time.sleep(0.05)

    def stop(self) -> None:
        if self._process is not None:
            subprocess.run(
                self._command("pg_ctl", "-D", self.data, "-m", "immediate", "stop"), cwd=self.folder, check=True,
                stdout=subprocess.DEVNULL,
            )  # fmt: skip
            self._process.wait(timeout=STARTS_WITHIN)
            self._process = None

    def url(self, name: str) -> str:
        return f"postgresql://{USER}@127.0.0.1:{self.port}/{name}"

    def emptied(self) -> str:
        """Return the URL of the database, with nothing in it; a new one each time would be a thousand files each."""
        with psycopg.connect(self.url(NAME), autocommit=True) as connection:
            connection.execute("SET lock_timeout = '20s'")
            connection.execute("DROP SCHEMA public CASCADE")
            connection.execute("CREATE SCHEMA public")
        return self.url(NAME)

    @staticmethod
    def _command(program: str, *arguments: object) -> list[str]:
        found = sorted(Path("/usr/lib/postgresql").glob(f"*/bin/{program}"))
        path = str(found[-1]) if found else shutil.which(program)
        assert path is not None, f"PostgreSQL's {program} is missing: `make postgres` installs it"
        as_user = ["runuser", "-u", USER, "--"] if os.geteuid() == 0 else []
        return [*as_user, path, *map(str, arguments)]


@pytest.fixture(scope="session")
def postgres() -> Iterator[Postgres]:
    folder = Path(tempfile.mkdtemp(prefix="glider-postgres-"))
    server = Postgres(folder)
    try:
        server.make()
        server.start()
        yield server
    finally:
        server.stop()
        shutil.rmtree(folder)


@pytest.fixture(params=["sqlite", "postgresql"])
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    if request.param == "sqlite":
        return sqlite_url(tmp_path / "studio.sqlite")
    server: Postgres = request.getfixturevalue("postgres")
    return server.emptied()


@pytest.fixture
def database(database_url: str) -> Iterator[Database]:
    opened = Database(database_url)
    yield opened
    opened.close()


@pytest.fixture
def store(database: Database) -> DesignStore:
    return DesignStore(database)
