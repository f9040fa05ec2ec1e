"""Lists of stored designs: the search finds what is there and nothing else, and pages neither repeat nor skip."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from models.design import parse_design
from models.presets import load_preset
from server.store.database import Database, sqlite_url
from server.store.designs import DesignStore
from server.store.errors import CursorError
from server.store.listing import ORDERS, DesignQuery
from server.store.paging import after, read_cursor, write_cursor
from server.store.records import Content, fold
from server.store.tables import designs

DOCUMENT = load_preset("canete-dual-bellows").model_dump(mode="json")
WORDS = (
    "Seawing",
    "SLOCUM glider",
    "50% duty",
    "under_score",
    "back\\slash",
    "quote'\"d",
    "Ångström",
    "straße",
    "海 glider",
)


def content(name, *tags, notes=""):
    return Content(parse_design(DOCUMENT | {"name": name, "notes": notes}), tags)


def find(store, search="", *tags, **options):
    return [item.name for item in store.find(DesignQuery(search, tags, order="name", limit=200, **options)).items]


@pytest.fixture
def filled(store):
    for name in WORDS:
        store.create(content(name, f"about {name[:5]}".rstrip(), notes=f"These notes of {name} say deep-water."))
    return store


@pytest.mark.parametrize("name", WORDS)
def test_each_is_found_by_its_name_in_any_case(filled, name):
    for search in (name, name.upper(), name.lower(), name[1:], f"  {name} \n deep-water ", fold(name)[2:]):
        assert name in find(filled, search), search


@pytest.mark.parametrize(
    ("search", "found"),
    [
        ("glider", {"SLOCUM glider", "海 glider"}),
        ("glider slocum", {"SLOCUM glider"}),
        ("glider seawing", set()),
        ("%", {"50% duty"}),
        ("0%", {"50% duty"}),
        ("50% ", {"50% duty"}),
        ("_", {"under_score"}),
        ("r_s", {"under_score"}),
        ("r%s", set()),
        ("\\", {"back\\slash"}),
        ("k\\s", {"back\\slash"}),
        ("e'\"d", {"quote'\"d"}),
        ("海", {"海 glider"}),
        ("STRASSE", {"straße"}),
        ("ångström", {"Ångström"}),
        ("NOTES deep-water", set(WORDS)),
        ('"', {"quote'\"d"}),
        ("NEAR(a b)", set()),
        ("slocum OR seawing", set()),
        ("folded:seawing", set()),
        ("seaw*", set()),
        ("slocum\0glider", {"SLOCUM glider"}),
        ("", set(WORDS)),
    ],
)  # fmt: skip
def test_words_are_sought_as_they_are_written(filled, search, found):
    assert set(find(filled, search)) == found


def test_tags_are_sought_and_filtered(store):
    store.create(content("A", "Fast", "deep"))
    store.create(content("B", "fast"))
    store.create(content("C", "faster"))
    assert find(store, "", "FAST") == ["A", "B"]
    assert find(store, "", "fast", "deep") == ["A"]
    assert find(store, "fast") == ["A", "B", "C"]
    assert find(store, "fa") == ["A", "B", "C"]
    assert find(store, "faster") == ["C"]
    assert find(store, "", "none") == find(store, "", "fa%") == find(store, "", "a\0b") == []


def test_search_follows_changes(store):
    made = store.create(content("Albatross", "bird", notes="soars over waves"))
    store.change(made.id, lambda _: content("Manta", "fish", notes="flaps through water"))
    assert find(store, "albatross") == find(store, "bird") == find(store, "soars") == find(store, "", "bird") == []
    assert find(store, "manta") == find(store, "fish") == find(store, "flaps") == find(store, "", "fish") == ["Manta"]
    store.revert(made.id, 1)
    assert find(store, "albatross bird soars", "bird") == ["Albatross"]


def test_deleted_designs_are_listed_apart(store):
    made = [store.create(content(name, "t")) for name in ("A", "B")]
    store.delete(made[0].id)
    assert (find(store), find(store, deleted=True)) == (["B"], ["A"])
    assert (find(store, "", "t"), find(store, "", "t", deleted=True)) == (["B"], ["A"])
    store.restore(made[0].id)
    assert (find(store), find(store, deleted=True)) == (["A", "B"], [])


def clock():
    """Return a clock that often shows the same time twice."""
    return (float(n // 3) for n in itertools.count(10))


def pages(store, meanwhile=lambda: None, **options):
    seen, cursor = [], None
    while True:
        page = store.find(DesignQuery(cursor=cursor, **options))
        seen += page.items
        cursor = page.next
        if cursor is None:
            return seen
        assert len(page.items) == options["limit"]
        meanwhile()


@pytest.mark.parametrize("order", [*ORDERS, *(f"-{name}" for name in ORDERS)])
@pytest.mark.parametrize("limit", [1, 2, 5, 200])
def test_pages_hold_each_once_in_order(database, order, limit):
    times = clock()
    store = DesignStore(database, clock=lambda: next(times))
    names = ["b", "B", "a", "Z", "á", "ab", "A b", "_", "10", "9", "ß", "z"]
    ids = [store.create(content(name)).id for name in names]
    store.change(ids[3], lambda _: content("changed"))
    seen = pages(store, order=order, limit=limit)
    key = {"name": lambda i: fold(i.name), "created": lambda i: i.created, "updated": lambda i: i.updated}[
        order.strip("-")
    ]
    expected = sorted(seen, key=lambda i: (key(i), ids.index(i.id)), reverse=order.startswith("-"))
    assert seen == expected and sorted(i.id for i in seen) == sorted(ids)


@pytest.mark.parametrize("order", [*ORDERS, *(f"-{name}" for name in ORDERS)])
def test_what_is_added_meanwhile_neither_repeats_nor_hides_an_entry(store, order):
    there = {store.create(content(name)).id for name in "bdfhjl"}
    names = iter("acegikmnopqrstuv")
    seen = [i.id for i in pages(store, lambda: store.create(content(next(names))), order=order, limit=2)]
    assert len(seen) == len(set(seen)) and there <= set(seen)


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(text=st.text(max_size=80))
def test_cursors_survive_any_text(text):
    clean = text.replace("\0", "")
    assert read_cursor(write_cursor("name", clean, 7), "name", str, int) == [clean, 7]


@pytest.mark.parametrize(
    "cursor",
    ["", "x", "=", "é", "e30", write_cursor("name", "a", 1), write_cursor("-updated", 1, 2),
     write_cursor("-updated", 1.0), write_cursor("-updated", 1.0, 2, 3),
     write_cursor("-updated", "\0", 1), write_cursor("-updated", 1.0, 2**31),
     write_cursor("updated", 1.0, 2), "W" * 3000, "W" * 1999],
)  # fmt: skip
def test_other_cursors_are_refused(store, cursor):
    with pytest.raises(CursorError, match="begin"):
        store.find(DesignQuery(cursor=cursor))


def test_lists_walk_an_index(tmp_path):
    """A page of a long list is read from an index, not sorted: what makes it quick with any number of designs."""
    store = DesignStore(Database(sqlite_url(tmp_path / "studio.sqlite")))
    for name, column in ORDERS.items():
        condition = after(column, designs.c.number, ["a", 1], descending=True)
        statement = designs.select().where(condition).order_by(column.desc(), designs.c.number.desc()).limit(50)
        plain = str(statement.compile(store.database.engine, compile_kwargs={"literal_binds": True}))
        with store.database.read() as connection:
            plan = str(connection.exec_driver_sql(f"EXPLAIN QUERY PLAN {plain}").all())
        assert "USING INDEX" in plan and "TEMP B-TREE" not in plan, (name, plan)
    store.database.close()
