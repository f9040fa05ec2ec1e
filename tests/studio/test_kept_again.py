"""Kept runs, their ghost and the path's colours outlive a restart of the server and the session's time in memory."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import orjson
import pytest
from fastapi import HTTPException

from models.design import Design
from models.limits import DEFAULT_LIMITS, Limits
from models.run import Run
from models.simulate import Control, run_assembly, simulate
from studio import kept_again
from studio.kept_again import SLIP, STAYS, KeptAgain
from studio.kept_runs import MOST_KEPT, OTHERWISE, KeptRun, KeptRuns, read_saved, saved_document
from studio.registry import OpenSession, Sessions
from studio.run_operations import run_kept_as
from studio.scene_display import FIRST_DISPLAY, Display
from studio.session import Session
from studio.state import state_of
from tests.studio.conftest import wait_until

SHOWN = ("kept", "scene", "revision", "name", "origin", "selected", "components", "schedules")


@pytest.fixture
def folder(kernel: None, tmp_path: Path) -> Path:
    return tmp_path / "sessions"


@pytest.fixture
def open_again(folder: Path) -> Iterator[Callable[..., OpenSession]]:
    """Opens a session as a server that begins anew does; one that was begun before has stopped then."""
    begun: list[Sessions] = []

    def again(session_id: str, limits: Limits = DEFAULT_LIMITS) -> OpenSession:
        for former in begun:
            former.close()
        begun.append(Sessions(folder, limits=limits))
        found = begun[-1].find(session_id)
        assert found is not None
        return found

    yield again
    for sessions in begun:
        sessions.close()


def fly(session: Session) -> None:
    wait_until(lambda: not session.simulating)


def settled(session: Session) -> Session:
    """Wait until all kept runs are computed anew, or are known not to be."""
    wait_until(lambda: session.run is not None and all(kept.state != "computing" for kept in session.kept))
    return session


def shown(session: Session) -> dict[str, Any]:
    state = state_of(session, saved_at=None)
    return {name: state[name] for name in SHOWN}


def two_kept(folder: Path, design: Design) -> tuple[Sessions, Session]:
    """Keep two runs of a glider that goes on changing; one more was kept and deleted."""
    sessions = Sessions(folder)
    session = sessions.create(design)[0].session
    for name, place in (("As published", 0.18), ("Deleted", 0.17), ("Forward", 0.16)):
        session.set_field("/vehicle/components/1/position/0", place)
        fly(session)
        session.keep_run(name)
    session.forget_run("run-2")
    session.rename_run("run-1", "Before")
    session.show(Display("z", "run-3"))
    session.set_field("/mission/duration", 20.0)
    fly(session)
    return sessions, session


def saved_file(folder: Path, session: Session) -> dict[str, Any]:
    document: dict[str, Any] = json.loads((folder / f"{session.id}.json").read_bytes())
    return document


def rewrite(folder: Path, session: Session, change: Callable[[dict[str, Any]], object]) -> None:
    document = saved_file(folder, session)
    change(document)
    (folder / f"{session.id}.json").write_text(json.dumps(document))


def only(session: Session) -> KeptRun:
    (kept,) = session.kept
    return kept


@pytest.mark.parametrize("how", ["the server begins anew", "nobody looked for long"])
def test_what_was_kept_is_there_again(
    folder: Path, dual_bellows: Design, open_again: Callable[..., OpenSession], how: str
) -> None:
    sessions, session = two_kept(folder, dual_bellows)
    before, runs = shown(session), [kept.run for kept in session.kept]
    if how == "nobody looked for long":
        assert sessions.reap(idle=-1.0) == 1
    sessions.close()
    again = settled(open_again(session.id).session)
    assert shown(again) == before
    assert [kept.name for kept in again.kept] == ["Before", "Forward"]
    for now, then in zip((kept.run for kept in again.kept), runs, strict=True):
        assert now is not None and then is not None and now.design == then.design
        assert np.array_equal(now.times, then.times)
        assert all(np.array_equal(now.values[name], then.values[name], equal_nan=True) for name in then.values)
    assert again.keep_run().id == "run-4", "a page may still hold the curves of the deleted run-2"


def test_it_is_listed_before_it_is_computed_and_its_ghost_comes_with_it(
    folder: Path, dual_bellows: Design, open_again: Callable[..., OpenSession], monkeypatch: pytest.MonkeyPatch
) -> None:
    sessions, session = two_kept(folder, dual_bellows)
    before = shown(session)
    sessions.close()
    monkeypatch.setattr(kept_again, "run_assembly", until_cancelled)
    opened = open_again(session.id)
    again, drawn = opened.session, opened.view().ghost
    wait_until(lambda: again.run is not None)
    computing = [kept | {"state": "computing"} for kept in before["kept"]]
    assert shown(again)["kept"] == computing and shown(again)["scene"]["ghost"] == "run-3"
    assert drawn._nodes == []
    with pytest.raises(HTTPException, match="ask again in a moment"):
        run_kept_as("run-1", again)
    monkeypatch.undo()
    opened = open_again(session.id)
    settled(opened.session)
    wait_until(lambda: len(opened.view().ghost._nodes) == 2)


def until_cancelled(*_: object, control: Control, **__: object) -> None:
    end = time.monotonic() + 20.0
    while not control.cancelled:
        assert time.monotonic() < end, "nobody cancelled it"
        time.sleep(0.005)


def one_kept(folder: Path, design: Design) -> Session:
    """Keep the run of a glider whose mission is then made shorter, and stop."""
    sessions = Sessions(folder)
    session = sessions.create(design)[0].session
    fly(session)
    session.keep_run("Long")
    session.set_field("/mission/duration", 12.0)
    fly(session)
    sessions.close()
    return session


def test_what_cannot_be_computed_any_more_is_told_and_not_lost(
    folder: Path, dual_bellows: Design, open_again: Callable[..., OpenSession]
) -> None:
    before = one_kept(folder, dual_bellows)
    session = settled(open_again(before.id, replace(DEFAULT_LIMITS, duration=15.0)).session)
    (listed,) = shown(session)["kept"]
    assert listed["name"] == "Long" and listed["state"] == "failed"
    assert listed["note"].startswith("It cannot be computed any more: /mission/duration: ")
    assert "15" in listed["note"] and listed["note"].endswith(STAYS)
    with pytest.raises(HTTPException, match="/mission/duration"):
        run_kept_as("run-1", session)
    session.rename_run("run-1", "Longer")
    again = settled(open_again(before.id).session)
    assert shown(again)["kept"] == [{**listed, "name": "Longer", "state": "ready", "note": None}]


def test_a_design_that_this_version_cannot_read_is_told_and_kept_as_it_is(
    folder: Path, dual_bellows: Design, open_again: Callable[..., OpenSession]
) -> None:
    before = one_kept(folder, dual_bellows)
    newer = {"format": "glider-design", "version": 99, "sails": 2}
    rewrite(folder, before, lambda document: document["kept"]["runs"][0].update(design=newer))
    session = open_again(before.id).session
    assert "/version: the document has version 99" in str(only(settled(session)).problem)
    session.rename_run("run-1", "Of a newer program")
    assert only(open_again(before.id).session).name == "Of a newer program"
    assert saved_file(folder, before)["kept"]["runs"][0]["design"] == newer


def test_a_slip_of_the_program_is_told_in_the_page_too(
    folder: Path, dual_bellows: Design, open_again: Callable[..., OpenSession], monkeypatch: pytest.MonkeyPatch
) -> None:
    before = one_kept(folder, dual_bellows)

    def fail(*_: object, **__: object) -> Run:
        raise MemoryError

    monkeypatch.setattr(kept_again, "run_assembly", fail)
    assert only(settled(open_again(before.id).session)).note == f"{SLIP} {STAYS}"


@pytest.mark.parametrize("other", [{"kernel": "of another version"}, {"end": 3.0}])
def test_a_run_that_may_differ_from_what_was_kept_says_so(
    folder: Path, dual_bellows: Design, open_again: Callable[..., OpenSession], other: dict[str, Any]
) -> None:
    before = one_kept(folder, dual_bellows)
    rewrite(folder, before, lambda document: document["kept"]["runs"][0].update(other))
    kept = only(settled(open_again(before.id).session))
    assert kept.state == "ready" and kept.note == OTHERWISE


def test_a_run_that_is_deleted_while_it_is_computed_stays_deleted(
    kernel: None, dual_bellows: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = KeptRuns()
    before.keep(simulate(dual_bellows))
    kept, done = KeptRuns(read_saved(orjson.loads(orjson.dumps(saved_document(before.saved()))))), threading.Event()

    def deleted_meanwhile(*arguments: Any, **more: Any) -> Run:
        assert kept.forget("run-1")
        return run_assembly(*arguments, **more)

    monkeypatch.setattr(kept_again, "run_assembly", deleted_meanwhile)
    KeptAgain(kept, limits=DEFAULT_LIMITS, on_done=done.set).start()
    assert done.wait(20.0)
    assert list(kept) == []


def test_a_close_while_it_begins_waits_for_it_and_none_begins_after(
    kernel: None, dual_bellows: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = KeptRuns()
    before.keep(simulate(dual_bellows))
    kept = KeptRuns(read_saved(orjson.loads(orjson.dumps(saved_document(before.saved())))))
    about_to_begin, go_on, begin = threading.Event(), threading.Event(), threading.Thread.start
    slips: list[str] = []

    def slow_start(thread: threading.Thread) -> None:
        if thread.name == "kept-again":
            about_to_begin.set()
            assert go_on.wait(20.0)
        begin(thread)

    def closed() -> None:
        try:
            again.close()
        except RuntimeError as error:
            slips.append(str(error))

    monkeypatch.setattr(threading.Thread, "start", slow_start)
    again = KeptAgain(kept, limits=DEFAULT_LIMITS, on_done=lambda: None)
    starter, closer = threading.Thread(target=again.start), threading.Thread(target=closed)
    starter.start()
    assert about_to_begin.wait(20.0)
    closer.start()
    time.sleep(0.05)  # time enough for the close to come to its thread
    go_on.set()
    for thread in (starter, closer):
        thread.join(20.0)
        assert not thread.is_alive()
    assert slips == [] and "kept-again" not in {thread.name for thread in threading.enumerate()}

    late = KeptAgain(kept, limits=DEFAULT_LIMITS, on_done=lambda: None)
    late.close()
    late.start()
    assert "kept-again" not in {thread.name for thread in threading.enumerate()}


def test_files_from_before_runs_were_kept_open(
    folder: Path, dual_bellows: Design, open_again: Callable[..., OpenSession]
) -> None:
    before = one_kept(folder, dual_bellows)
    rewrite(folder, before, lambda document: [document.pop(name) for name in ("kept", "display")])
    session = open_again(before.id).session
    fly(session)
    assert list(session.kept) == [] and session.display == FIRST_DISPLAY
    assert session.keep_run().id == "run-1"


def test_a_colour_that_this_version_does_not_know_is_the_first_one(
    folder: Path, dual_bellows: Design, open_again: Callable[..., OpenSession]
) -> None:
    before = one_kept(folder, dual_bellows)
    rewrite(folder, before, lambda document: document["display"].update(color_by="mood"))
    assert open_again(before.id).session.display == FIRST_DISPLAY


def test_no_place_is_read_that_has_no_colour(folder: Path, dual_bellows: Design) -> None:
    before = one_kept(folder, dual_bellows)
    rewrite(folder, before, lambda document: document["kept"]["runs"][0].update(place=MOST_KEPT))
    sessions = Sessions(folder)
    assert sessions.find(before.id) is None
    sessions.close()
