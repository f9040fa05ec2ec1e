"""Owns the worked examples of stored designs, and the small store that each is asked of, always as at the start."""

from __future__ import annotations

import itertools
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from models.design import Design, loads_design
from server.editing import apply_patch
from server.store.database import Database, sqlite_url
from server.store.designs import DesignStore
from server.store.records import Content

BEGIN = 1_767_268_800.0
"""2026-01-01 12:00 UTC, s since 1970: the examples' time, so that they stay as they are."""
MINUTE = 60.0
SEEDED = 2
DESIGN_ID, DELETED_ID = (f"01jdesgn{number:018d}" for number in range(SEEDED))
PICTURE = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 40 10">'
    '<rect x="2" y="3" width="36" height="4" rx="2" fill="#c43"/></svg>'
)
HEADERS = frozenset({"If-Match", "If-None-Match"})
AT_HEAD = {"design_id": DESIGN_ID, "If-Match": '"2"'}
"""The design, and the revision that a change starts from."""
LONGER: Sequence[Mapping[str, Any]] = [{"op": "replace", "path": "/mission/duration", "value": 20.0}]


def _store(path: Path, first: int) -> DesignStore:
    """Return a store whose clock and identifiers go on from a number."""
    times = (BEGIN + MINUTE * minute for minute in itertools.count(10 * first))
    numbers = itertools.count(first)
    make_id: Callable[[], str] = lambda: f"01jdesgn{next(numbers):018d}"  # noqa: E731
    return DesignStore(Database(sqlite_url(path)), clock=lambda: next(times), make_id=make_id)


@cache
def _seeded(document: str) -> bytes:
    """Return a database with a design of two revisions and a picture, and a deleted one."""
    design = loads_design(document)
    with tempfile.TemporaryDirectory() as folder:
        store = _store(Path(folder) / "seed.sqlite", 0)
        kept = store.create(Content(design, ("example", "bellows")), comment="As published")
        longer = Content(apply_patch(design, LONGER), kept.tags)
        store.change(kept.id, lambda _: longer, comment="A longer glide")
        store.set_thumbnail(kept.id, "image/svg+xml", PICTURE.encode())
        other = apply_patch(design, [{"op": "replace", "path": "/name", "value": "Given up"}])
        store.delete(store.create(Content(other)).id)
        store.database.close()
        return (Path(folder) / "seed.sqlite").read_bytes()


@contextmanager
def demo_store(design: Design) -> Iterator[DesignStore]:
    """Enter a store of its own for one example, as all of them begin."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "studio.sqlite"
        path.write_bytes(_seeded(design.to_json()))
        store = _store(path, SEEDED)
        try:
            yield store
        finally:
            store.database.close()


def stored_requests(api: str, design: dict[str, Any], part: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the examples by operation: method, path and media type, the parameters and the body."""
    all_of_them, one = f"{api}/designs", f"{api}/designs/{{design_id}}"
    plain = {"design_id": DESIGN_ID}
    rename = {"name": "Example glider, longer", "tags": ["example", "longer"], "comment": "Says what it is"}
    return {
        "list_designs": {"at": ("GET", all_of_them), "parameters": {"search": "glider", "limit": 10}},
        "create_design": {"at": ("POST", all_of_them), "request": {"design": design, "tags": ["example"]}},
        "get_design": {"at": ("GET", one), "parameters": plain},
        "replace_design": {"at": ("PUT", one), "parameters": AT_HEAD, "request": design},
        "change_design": {"at": ("PATCH", one), "parameters": AT_HEAD, "request": rename},
        "delete_design": {"at": ("DELETE", one), "parameters": AT_HEAD},
        "restore_design": {"at": ("POST", f"{one}:restore"), "parameters": {"design_id": DELETED_ID}},
        "list_revisions": {"at": ("GET", f"{one}/revisions"), "parameters": plain},
        "get_revision": {"at": ("GET", f"{one}/revisions/{{number}}"), "parameters": plain | {"number": 1}},
        "revert_design": {"at": ("POST", f"{one}:revert"), "parameters": AT_HEAD, "request": {"revision": 1}},
        "export_design": {"at": ("GET", f"{one}:export"), "parameters": plain},
        "export_designs": {"at": ("GET", f"{all_of_them}:export"), "parameters": {"ids": DESIGN_ID}},
        "import_designs": {"at": ("POST", f"{all_of_them}:import"), "request": design},
        "set_thumbnail": {
            "at": ("PUT", f"{one}/thumbnail", "image/svg+xml"), "parameters": plain, "request": PICTURE,
        },
        "get_thumbnail": {"at": ("GET", f"{one}/thumbnail"), "parameters": plain},
    } | _component_requests(f"{one}/components", plain, part, design["vehicle"]["components"][0]["name"])  # fmt: skip


def _component_requests(
    folder: str, plain: dict[str, Any], part: dict[str, Any], first: str
) -> dict[str, dict[str, Any]]:
    named, new = f"{folder}/{{name}}", {"name": first}
    return {
        "list_components": {"at": ("GET", folder), "parameters": plain},
        "add_component": {"at": ("POST", folder), "parameters": AT_HEAD, "request": part},
        "get_component": {"at": ("GET", named), "parameters": plain | new},
        "change_component": {"at": ("PATCH", named), "parameters": AT_HEAD | new, "request": {"notes": "As weighed"}},
        "remove_component": {"at": ("DELETE", named), "parameters": AT_HEAD | new},
    }
