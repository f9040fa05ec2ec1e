"""Owns the files of sessions: DATA/sessions/<id>.json, written whole by a thread of its own, read after a restart.

A file holds a hash of the session's secret, never the secret: the browser's cookie still opens it after a restart.
"""

from __future__ import annotations

import contextlib
import json
import logging
import os
import re
import tempfile
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

import orjson

from models.design import Design, parse_design
from models.problems import DesignError
from studio.kept_runs import NO_RUNS, SavedRuns, read_saved, saved_document
from studio.origin import Origin, origin_document, read_origin
from studio.part_marks import Document, read_marks
from studio.scene_display import FIRST_DISPLAY, Display, read_display

log = logging.getLogger(__name__)

SESSION_ID = re.compile(r"[A-Za-z0-9_-]{8,40}")
PAUSE = 0.3
"""Pause after each pass of the writer, s: a drag is written a few times a second, not at every step."""


@dataclass(frozen=True)
class SavedSession:
    """What a session's file holds."""

    id: str
    secret_hash: str
    revision: int
    saved_at: str
    design: Design
    origin: Origin | None = None
    marks: Document = field(default_factory=dict)
    kept: SavedRuns = NO_RUNS
    display: Display = FIRST_DISPLAY


def is_session_id(text: str) -> bool:
    """Whether a text from an address can be a session's id; only such texts become file names."""
    return SESSION_ID.fullmatch(text) is not None


class Autosave:
    """Writes the newest state of each session soon after it changed."""

    def __init__(self, folder: Path, *, pause: float = PAUSE) -> None:
        self._folder, self._pause = folder, pause
        self._wake = threading.Condition()
        self._pending: dict[str, tuple[SavedSession, Callable[[str], None]]] = {}
        self._writing = self._closed = False
        self._thread: threading.Thread | None = None

    def save(self, session: SavedSession, *, on_saved: Callable[[str], None] = lambda _: None) -> None:
        """Write a session soon, in place of any older state of it that waits; `on_saved` hears the time."""
        with self._wake:
            self._pending[session.id] = session, on_saved
            if self._thread is None:
                self._thread = threading.Thread(target=self._work, name="autosave", daemon=True)
                self._thread.start()
            self._wake.notify_all()

    def flush(self) -> None:
        """Return once everything that waits is written."""
        with self._wake:
            self._wake.wait_for(lambda: self._thread is None or not (self._pending or self._writing), timeout=10.0)

    def close(self) -> None:
        """Write what waits, and stop."""
        with self._wake:
            self._closed = True
            self._wake.notify_all()
        if self._thread is not None:
            self._thread.join(timeout=10.0)

    def load(self, session_id: str) -> SavedSession | None:
        """Return the saved session of an id, or None where there is none that can be read."""
        if not is_session_id(session_id):
            return None
        try:
            saved = json.loads(self._path(session_id).read_bytes())
            design, origin = parse_design(saved["design"]), read_origin(saved.get("origin"))
            marks = read_marks(saved.get("marks")).document()
            return SavedSession(
                session_id, str(saved["secret_hash"]), int(saved["revision"]), str(saved["saved_at"]), design, origin,
                marks, read_saved(saved.get("kept")), read_display(saved.get("display")),
            )  # fmt: skip
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, TypeError, DesignError) as error:
            log.warning("the saved session %s cannot be read: %s", session_id, error)
            return None

    def _path(self, session_id: str) -> Path:
        return self._folder / f"{session_id}.json"

    def _work(self) -> None:
        while True:
            with self._wake:
                self._wake.wait_for(lambda: self._pending or self._closed)
                if not self._pending:
                    return
                batch, self._pending = self._pending, {}
                self._writing = True
            for session, on_saved in batch.values():
                self._write_and_tell(session, on_saved)
            with self._wake:
                self._writing = False
                self._wake.notify_all()
                self._wake.wait_for(lambda: self._closed, timeout=self._pause)

    def _write_and_tell(self, session: SavedSession, on_saved: Callable[[str], None]) -> None:
        try:
            now = datetime.now(UTC).isoformat(timespec="milliseconds")
            self._write(session, now)
            on_saved(now)
        except OSError as error:
            log.error("session %s could not be saved: %s", session.id, error)

    def _write(self, session: SavedSession, saved_at: str) -> None:
        self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        content = {
            "id": session.id,
            "secret_hash": session.secret_hash,
            "revision": session.revision,
            "saved_at": saved_at,
            "origin": origin_document(session.origin),
            "marks": session.marks,
            "display": session.display.document(),
            "kept": saved_document(session.kept),
            "design": orjson.Fragment(session.design.model_dump_json().encode()),
        }
        # mkstemp makes the file readable by its owner alone
        descriptor, temporary = tempfile.mkstemp(dir=self._folder, prefix=f".{session.id}.")
        try:
            with os.fdopen(descriptor, "wb") as stream:
                stream.write(orjson.dumps(content))
            Path(temporary).replace(self._path(session.id))
        except BaseException:
            with contextlib.suppress(OSError):
                Path(temporary).unlink()
            raise
