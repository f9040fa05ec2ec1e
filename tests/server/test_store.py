"""The store of designs keeps all that was ever made, lets one of two writers win, and is the same on both databases."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest
from hypothesis import HealthCheck, given, settings
from sqlalchemy import func, select

from models.design import parse_design
from models.presets import load_preset, preset_ids
from server.store.designs import DesignStore
from server.store.errors import DeletedError, NotFoundError, RevisionError
from server.store.identifiers import is_id, new_id
from server.store.records import Content, distinct, fold
from server.store.tables import documents
from tests import strategies

DESIGN = load_preset("canete-dual-bellows")
WRITERS = 8


def named(name, **changes):
    return parse_design(DESIGN.model_dump(mode="json") | {"name": name} | changes)


def content(name="A", *tags, **changes):
    return Content(named(name, **changes), tags)


@pytest.mark.parametrize("preset_id", preset_ids())
def test_what_is_kept_comes_back_whole(store, preset_id):
    design = load_preset(preset_id)
    made = store.create(Content(design, ("a", "b")), comment="first")
    found = store.get(made.id)
    assert found == made and found.design == design
    assert (found.revision, found.tags, found.comment) == (1, ("a", "b"), "first")
    assert found.identity == design.identity == hashlib.sha256(found.document.encode()).hexdigest()


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(design=strategies.designs())
def test_any_design_comes_back_whole(store, design):
    found = store.get(store.create(Content(design)).id)
    assert found.design == design and found.identity == design.identity


def test_text_of_every_kind_comes_back(store):
    notes = "Trøndelag — 海\n\x00 'quoted' \\ %_ \U0001f6a4"
    stored = store.create(content("Ångström ẞ", "größe", notes=notes), comment="naïve")
    found = store.get(stored.id)
    assert (found.design.notes, found.tags, found.comment) == (notes, ("größe",), "naïve")


def test_equal_documents_are_kept_once(store):
    first = store.create(content("A"))
    store.change(first.id, lambda _: content("B"))
    store.change(first.id, lambda _: content("A"))
    store.create(content("A"))
    with store.database.read() as connection:
        assert connection.execute(select(func.count()).select_from(documents)).scalar() == 2


def test_identifiers_sort_by_time_and_are_told_from_others():
    ids = [new_id() for _ in range(1000)]
    assert len(set(ids)) == 1000 and all(map(is_id, ids))
    assert [i[:9] for i in ids] == sorted(i[:9] for i in ids)
    for other in ("", "x", ids[0] + "\n", ids[0].upper(), ids[0][:-1] + "\0", "../../../../../etc/passwd"):
        assert not is_id(other)


@pytest.mark.parametrize("design_id", ["", "none", "0" * 26, "a\0b", "x" * 5000, "🛶"])
def test_what_is_not_there_is_told(store, design_id):
    for ask in (
        store.get, store.delete, store.restore, store.thumbnail, store.revisions,
        lambda i: store.revision(i, 1), lambda i: store.change(i, lambda c: c), lambda i: store.revert(i, 1),
    ):  # fmt: skip
        with pytest.raises(NotFoundError, match="there is no design"):
            ask(design_id)


def test_every_change_is_a_revision_and_none_is_lost(store):
    first = store.create(content("A", "x"))
    second = store.change(first.id, lambda before: Content(named("B"), before.tags), comment="renamed")
    third = store.change(first.id, lambda before: Content(before.design, ("y",)), expected={2})
    assert (second.revision, third.revision) == (2, 3)
    assert [store.revision(first.id, n) for n in (1, 2, 3)] == [first, second, third] and store.get(first.id) == third
    for number in (0, -1, 4, 2**31, 10**30):
        with pytest.raises(NotFoundError, match=f"no revision {number}: its newest is 3"):
            store.revision(first.id, number)


def test_the_same_content_is_no_revision(store):
    first = store.create(content("A", "x"))
    assert store.change(first.id, lambda before: before) == first
    assert store.change(first.id, lambda _: content("A", "x"), comment="nothing") == first
    assert store.change(first.id, lambda _: content("A", "x", "X")) == first
    assert len(store.revisions(first.id).items) == 1


def test_revisions_are_listed_newest_first_by_pages(store):
    made = store.create(content("0"))
    for number in range(1, 7):
        store.change(made.id, lambda _, n=number: content(str(n)), comment=f"c{number}")
    seen, cursor = [], None
    while True:
        page = store.revisions(made.id, cursor=cursor, limit=3)
        seen += [(r.revision, r.name, r.comment) for r in page.items]
        cursor = page.next
        if cursor is None:
            break
        store.change(made.id, lambda before: Content(before.design, (*before.tags, "later")[-1:]))
    assert seen == [(n + 1, str(n), f"c{n}" if n else "") for n in range(6, -1, -1)]


def test_reverting_makes_a_new_revision_equal_to_the_old(store):
    first = store.create(content("A", "x"))
    store.change(first.id, lambda _: content("B", "y"))
    back = store.revert(first.id, 1, expected={2})
    assert (back.revision, back.identity, back.tags, back.comment) == (3, first.identity, ("x",), "Back to revision 1")
    assert store.revert(first.id, 1, expected={3}) == back
    with pytest.raises(RevisionError):
        store.revert(first.id, 2, expected={1})


def test_deleted_designs_can_be_restored_with_their_history(store):
    made = store.create(content("A", "x"))
    changed = store.change(made.id, lambda _: content("B"))
    store.set_thumbnail(made.id, "image/svg+xml", b'<svg xmlns="http://www.w3.org/2000/svg"/>')
    with pytest.raises(RevisionError, match="at revision 2, and the change is for 1"):
        store.delete(made.id, expected={1})
    store.delete(made.id, expected={2})
    for ask in (
        store.get, store.delete, store.thumbnail, store.revisions, lambda i: store.revision(i, 1),
        lambda i: store.change(i, lambda _: content("C")),
    ):  # fmt: skip
        with pytest.raises(DeletedError, match="restore it"):
            ask(made.id)
    assert store.restore(made.id) == changed == store.restore(made.id) == store.get(made.id)
    assert store.revision(made.id, 1) == made and store.thumbnail(made.id).content


def test_a_change_needs_the_revision_it_started_from(store):
    made = store.create(content("A"))
    store.change(made.id, lambda _: content("B"), expected={1})
    for expected in ({1}, {3}, set(), {1, 3}):
        with pytest.raises(RevisionError) as caught:
            store.change(made.id, lambda _: content("C"), expected=expected)
        assert caught.value.current == 2
    assert store.change(made.id, lambda _: content("C"), expected={2, 9}).revision == 3


def at_once(action):
    """Let all writers act at the same moment; return what each got, an error or a result."""
    barrier = threading.Barrier(WRITERS)

    def one(k):
        barrier.wait()
        try:
            return action(k)
        except RevisionError as error:
            return error

    with ThreadPoolExecutor(WRITERS) as pool:
        return list(pool.map(one, range(WRITERS)))


def test_of_writers_from_the_same_revision_exactly_one_wins(store):
    made = store.create(content("start"))
    for revision in range(1, 9):
        results = at_once(
            lambda k, r=revision: store.change(made.id, lambda _: content(f"writer {k} of {r}"), expected={r})
        )
        won = [result for result in results if not isinstance(result, RevisionError)]
        assert len(won) == 1 and won[0].revision == revision + 1
        assert store.get(made.id) == won[0]
        assert {e.current for e in results if isinstance(e, RevisionError)} <= {revision + 1}
    assert len(store.revisions(made.id).items) == 9


def test_writers_who_name_no_revision_all_get_through(store):
    made = store.create(content("start"))
    results = at_once(lambda k: store.change(made.id, lambda before: Content(before.design, (*before.tags, f"t{k}"))))
    assert sorted(result.revision for result in results) == list(range(2, WRITERS + 2))
    assert set(store.get(made.id).tags) == {f"t{k}" for k in range(WRITERS)}


def test_two_programs_share_a_database(store, database_url):
    other = DesignStore(type(store.database)(database_url))
    try:
        made = store.create(content("A"))
        assert other.get(made.id) == made
        other.change(made.id, lambda _: content("B"), expected={1})
        with pytest.raises(RevisionError):
            store.change(made.id, lambda _: content("C"), expected={1})
    finally:
        other.database.close()


def test_deleting_and_changing_at_once_loses_neither(store):
    for _ in range(5):
        made = store.create(content("A"))

        def act(k, made=made):
            try:
                return store.delete(made.id, expected={1}) if k == 0 else store.change(made.id, lambda _: content("B"))
            except DeletedError as error:
                return error

        deleted, *changes = at_once(act)
        changed = [c for c in changes if not isinstance(c, DeletedError)]
        # either the deletion came first and no change was made, or it was refused, for it was made for another revision
        assert (deleted is None) == (not changed)
        assert store.restore(made.id).revision == (1 if deleted is None else 2)


def test_a_change_that_fails_leaves_everything_as_it_was(store, monkeypatch):
    made = store.create(content("A", "x"))

    def fails(*arguments):
        raise RuntimeError("in the middle")

    monkeypatch.setattr("server.store.designs._file_under", fails)
    with pytest.raises(RuntimeError):
        store.change(made.id, lambda _: content("B", "y"))
    with pytest.raises(RuntimeError):
        store.create(content("C", "y"))
    monkeypatch.undo()
    assert store.get(made.id) == made and len(store.revisions(made.id).items) == 1
    with store.database.read() as connection:
        assert connection.execute(select(func.count()).select_from(documents)).scalar() == 1


def test_thumbnails_replace_one_another(store):
    made = store.create(content("A"))
    with pytest.raises(NotFoundError, match="has no thumbnail"):
        store.thumbnail(made.id)
    for color in ("red", "blue"):
        svg = f'<svg xmlns="http://www.w3.org/2000/svg"><rect fill="{color}"/></svg>'.encode()
        kept = store.set_thumbnail(made.id, "image/svg+xml", svg)
        assert store.thumbnail(made.id) == kept and kept.content == svg
        assert kept.digest == hashlib.sha256(svg).hexdigest()
    assert store.get(made.id) == made


def test_tags_that_differ_by_case_alone_are_one():
    assert distinct(["Fast", "fast", "FAST", "größe", "GRÖSSE", "slow"]) == ("Fast", "größe", "slow")
    assert fold("Straße\0") == "strasse "


def test_records_are_plain_data(store):
    stored = store.create(content("A"))
    assert json.loads(dataclasses.asdict(stored)["document"]) == stored.design.model_dump(mode="json")
