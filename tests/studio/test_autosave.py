from __future__ import annotations

import json
import stat
from pathlib import Path

import pytest

from models.design import Design
from studio.autosave import Autosave, SavedSession, is_session_id
from studio.registry import Sessions
from tests.studio.conftest import wait_until


def saved(design: Design, revision: int) -> SavedSession:
    return SavedSession("session-one", "hash", revision, "", design)


def test_the_newest_state_is_written_whole_and_read_back(tmp_path: Path, dual_bellows: Design) -> None:
    autosave = Autosave(tmp_path / "sessions", pause=0.0)
    for revision in range(1, 30):
        autosave.save(saved(dual_bellows, revision))
    autosave.flush()
    loaded = autosave.load("session-one")
    autosave.close()
    assert loaded is not None
    assert loaded.revision == 29
    assert loaded.design == dual_bellows
    assert [path.name for path in (tmp_path / "sessions").iterdir()] == ["session-one.json"]


def test_only_the_owner_reads_the_file_and_it_holds_no_secret(tmp_path: Path, dual_bellows: Design) -> None:
    sessions = Sessions(tmp_path)
    opened, secret = sessions.create(dual_bellows)
    sessions.close()
    path = tmp_path / f"{opened.session.id}.json"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert secret not in path.read_text()


@pytest.mark.parametrize("text", ["", "short", "../../etc/passwd", "a/b/c/d/e", "abcdefgh.json", "é" * 10, "a" * 41])
def test_no_other_text_becomes_a_file_name(tmp_path: Path, text: str) -> None:
    assert not is_session_id(text)
    assert Autosave(tmp_path).load(text) is None


@pytest.mark.parametrize("content", ["", "[]", '{"design": 1}', '{"secret_hash": "x", "revision": 1, "design": {}}'])
def test_a_damaged_file_is_no_session(tmp_path: Path, content: str) -> None:
    (tmp_path / "session-one.json").write_text(content)
    assert Sessions(tmp_path).find("session-one") is None


def test_a_session_comes_back_after_a_restart(kernel: None, tmp_path: Path, dual_bellows: Design) -> None:
    before = Sessions(tmp_path)
    opened, secret = before.create(dual_bellows)
    opened.session.set_field("/vehicle/components/1/position/0", 0.17)
    before.close()
    after = Sessions(tmp_path)
    again = after.find(opened.session.id)
    assert again is not None
    assert again.admits(secret)
    assert not again.admits("another secret")
    assert again.session.design == opened.session.design
    assert again.session.revision == opened.session.revision
    wait_until(lambda: again.session.run is not None)
    after.close()


def test_no_number_of_a_run_means_another_one_after_a_restart(
    kernel: None, tmp_path: Path, dual_bellows: Design
) -> None:
    """A page that stayed open holds curves of runs by their numbers."""
    before = Sessions(tmp_path)
    session = before.create(dual_bellows)[0].session
    numbers = {}
    for place in (0.17, 0.16, 0.15):
        session.set_field("/vehicle/components/1/position/0", place)
        wait_until(lambda: not session.simulating)
        numbers[session.run_number] = session.design
    before.close()
    after = Sessions(tmp_path)
    again = after.get(session.id)
    assert again is not None
    wait_until(lambda: again.run is not None)
    assert again.run_number >= max(numbers)
    assert numbers.get(again.run_number, again.design) == again.design
    again.set_field("/vehicle/components/1/position/0", 0.14)
    wait_until(lambda: not again.simulating)
    assert again.run_number not in numbers
    after.close()


def test_idle_sessions_leave_memory_and_come_back(kernel: None, tmp_path: Path, dual_bellows: Design) -> None:
    sessions = Sessions(tmp_path)
    opened, _ = sessions.create(dual_bellows)
    opened.connections = 1
    assert sessions.reap(idle=-1.0) == 0, "a session with a browser is never idle"
    opened.connections = 0
    assert sessions.reap(idle=-1.0) == 1
    assert len(sessions) == 0
    assert json.loads((tmp_path / f"{opened.session.id}.json").read_text())["id"] == opened.session.id
    assert sessions.find(opened.session.id) is not None
    sessions.close()


def test_a_session_that_one_process_opened_is_there_for_another_at_once(
    kernel: None, tmp_path: Path, dual_bellows: Design
) -> None:
    """Several processes share the folder; the page that follows may be asked of another one than the opening."""
    one, other = Sessions(tmp_path), Sessions(tmp_path)
    opened, secret = one.create(dual_bellows)
    found = other.find(opened.session.id)
    assert found is not None and found.admits(secret) and found.session.design == dual_bellows
    one.close()
    other.close()
