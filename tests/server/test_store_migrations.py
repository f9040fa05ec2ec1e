"""The schema: upgraded from every version on both databases, equal to the tables, by any number of programs at once."""

from __future__ import annotations

import sqlite3
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing

import pytest
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import inspect, text

from models.presets import load_preset
from server.store import job_tables  # noqa: F401
from server.store.database import Database, sqlite_url
from server.store.designs import DesignStore
from server.store.errors import UnavailableError
from server.store.listing import DesignQuery
from server.store.migrations import HEAD, HERE, current_version
from server.store.records import Content
from server.store.tables import metadata
from tests.server.old_rows import DESIGN, GLIDER, insert_rows, read_rows, rows_until

SEARCH = "design_search"
"""SQLite's full-text index and its own tables, which are no tables of ours."""


def scripts():
    config = Config()
    config.set_main_option("script_location", str(HERE))
    config.set_main_option("path_separator", "os")
    return ScriptDirectory.from_config(config)


VERSIONS = [script.revision for script in reversed(list(scripts().walk_revisions()))]


def test_the_newest_version_is_the_one_the_program_asks_for():
    assert scripts().get_heads() == [HEAD] == VERSIONS[-1:]


@pytest.mark.parametrize("version", VERSIONS)
def test_every_version_comes_to_the_newest_and_equals_the_tables(database_url, version):
    old = Database(database_url, version=version)
    with old.read() as connection:
        assert current_version(connection) == version
    old.close()
    new = Database(database_url)
    with new.write() as connection:
        assert current_version(connection) == HEAD

        def ours(name, kind, parents):
            return not (kind == "table" and name.startswith(SEARCH))

        context = MigrationContext.configure(connection, opts={"include_name": ours, "compare_type": True})
        assert compare_metadata(context, metadata) == []
    store = DesignStore(new)
    made = store.create(Content(load_preset("three-cell-glider"), ("kept",)))
    new.close()
    assert store.get(made.id) == made and store.find(DesignQuery("battery")).items
    new.close()


@pytest.mark.parametrize("version", VERSIONS)
def test_every_row_of_an_older_version_is_there_after_the_upgrade(database_url, version):
    rows = rows_until(version)
    old = Database(database_url, version=version)
    with old.write() as connection:
        insert_rows(connection, rows)
        ours = {name for name in inspect(connection).get_table_names() if not name.startswith(SEARCH)}
        assert set(rows) == ours - {"alembic_version"}, "tests/server/old_rows.py has no row of some table"
    old.close()
    store = DesignStore(Database(database_url))
    with store.database.read() as connection:
        assert read_rows(connection, rows) == rows
    kept = store.get(DESIGN)
    assert (kept.revision, kept.tags, kept.document) == (2, ("Lake",), GLIDER.document)
    assert [item.id for item in store.find(DesignQuery("LONG ago", tags=("Lake",))).items] == [DESIGN]
    assert store.create(GLIDER).id in {item.id for item in store.find(DesignQuery()).items}
    store.database.close()


def test_what_is_stored_survives_a_second_start(database_url):
    first = DesignStore(Database(database_url))
    made = first.create(Content(load_preset("three-cell-glider")))
    first.database.close()
    second = DesignStore(Database(database_url))
    assert second.get(made.id) == made
    second.database.close()


def test_several_may_start_at_once(database_url):
    databases = [Database(database_url) for _ in range(6)]
    with ThreadPoolExecutor(6) as pool:
        list(pool.map(lambda database: DesignStore(database).find(DesignQuery()), databases))
    with databases[0].read() as connection:
        assert connection.execute(text("SELECT count(*) FROM alembic_version")).scalar() == 1
    for database in databases:
        database.close()


def test_a_new_file_that_another_is_writing_to_is_waited_for(tmp_path):
    path = tmp_path / "studio.sqlite"
    with closing(sqlite3.connect(path, isolation_level=None, check_same_thread=False)) as other:
        other.execute("CREATE TABLE notes (line TEXT)")
        other.execute("BEGIN IMMEDIATE")
        other.execute("INSERT INTO notes VALUES ('half a line')")
        with ThreadPoolExecutor(1) as pool:
            opening = pool.submit(lambda: DesignStore(Database(sqlite_url(path))).find(DesignQuery()))
            with pytest.raises(TimeoutError):
                opening.result(0.5)
            other.execute("COMMIT")
            assert not opening.result(10).items


def test_several_programs_may_start_at_once(database_url):
    code = (
        "import sys; from server.store.database import Database; d = Database(sys.argv[1]); "
        "d.engine; d.close(); print('opened')"
    )
    started = [
        subprocess.Popen([sys.executable, "-c", code, database_url], stdout=subprocess.PIPE, text=True)
        for _ in range(3)
    ]
    assert [process.communicate(timeout=60)[0] for process in started] == ["opened\n"] * 3


def test_a_database_of_a_newer_program_is_left_alone(database_url):
    database = Database(database_url)
    with database.write() as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = '9999'"))
    database.close()
    for _ in range(2):
        with pytest.raises(UnavailableError, match="version 9999, which this program does not know: use a newer"):
            _ = database.engine
    database.close()


def test_nothing_is_opened_before_its_use(tmp_path):
    database = Database(sqlite_url(tmp_path / "a" / "studio.sqlite"))
    assert not (tmp_path / "a").exists()
    with database.read() as connection:
        pragmas = {
            name: connection.exec_driver_sql(f"PRAGMA {name}").scalar()
            for name in ("journal_mode", "synchronous", "foreign_keys", "busy_timeout")
        }
    assert pragmas == {"journal_mode": "wal", "synchronous": 1, "foreign_keys": 1, "busy_timeout": 10000}
    database.close()


@pytest.mark.parametrize("name", ["a b", "100%", "a%20b", "ü", "a?b", "a#b", "a@b:c"])
def test_folders_of_any_name(tmp_path, name):
    database = Database(sqlite_url(tmp_path / name / "studio.sqlite"))
    with database.read():
        assert (tmp_path / name / "studio.sqlite").exists()
    database.close()


def test_what_cannot_be_opened_is_told_without_its_password(tmp_path):
    (tmp_path / "file").write_text("x")
    (tmp_path / "no.sqlite").write_bytes(b"not a database, whatever it is called" * 50)
    for url, says in (
        (sqlite_url(tmp_path / "file" / "studio.sqlite"), "folder of the database cannot be made"),
        (sqlite_url(tmp_path / "no.sqlite"), "not a database"),
        ("postgresql://anna:secret@127.0.0.1:1/studio", "does not answer"),
    ):
        with pytest.raises(UnavailableError, match=says) as caught:
            _ = Database(url).engine
        assert "secret" not in str(caught.value)


def test_a_full_disk_is_told_as_such_and_loses_nothing(tmp_path):
    store = DesignStore(Database(sqlite_url(tmp_path / "studio.sqlite")))
    made = store.create(Content(load_preset("three-cell-glider")))
    with store.database.read() as connection:
        pages = connection.exec_driver_sql("PRAGMA page_count").scalar()
    for connection in [store.database.engine.raw_connection() for _ in range(1)]:
        connection.cursor().execute(f"PRAGMA max_page_count={pages}")
        connection.close()
    with pytest.raises(UnavailableError, match="the disk is full: free some space"):
        for _ in range(50):
            store.create(Content(load_preset("canete-dual-bellows")))
    assert store.get(made.id) == made
    store.database.close()
