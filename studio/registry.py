"""Owns the open sessions: making them, finding them by id, bringing them back from disk, and closing idle ones."""

from __future__ import annotations

import hashlib
import hmac
import logging
import secrets
import threading
import time
from pathlib import Path

from models.design import Design
from models.limits import DEFAULT_LIMITS, Limits
from models.problems import DesignError
from models.warm import kernel_is_ready, warm_kernel_in_background
from studio.autosave import Autosave, SavedSession, is_session_id
from studio.origin import Origin
from studio.part_marks import read_marks
from studio.session import Session
from studio.state_feed import StateFeed
from studio.view import View

log = logging.getLogger(__name__)

IDLE = 1800.0
"""How long a session without a browser stays in memory, s; its file stays."""


class OpenSession:
    """A session in memory, with its view once a browser asked for one."""

    def __init__(self, session: Session, secret_hash: str, autosave: Autosave, *, saved_at: str | None = None) -> None:
        self.session, self.saved_at = session, saved_at
        self.connections = 0
        self.closed = False
        self.last_seen = time.monotonic()
        self._secret_hash, self._autosave = secret_hash, autosave
        self._saved = _saveable(session) if saved_at is not None else None
        self.saving = threading.Lock()
        self._view: View | None = None
        self._view_lock = threading.Lock()
        session.subscribe(lambda _change: self.save())
        self.feed = StateFeed(session, lambda: self.saved_at)

    def admits(self, secret: str) -> bool:
        """Whether a secret from a cookie belongs to this session."""
        return hmac.compare_digest(hash_secret(secret), self._secret_hash)

    def view(self) -> View:
        """Return the session's view; the first call starts its Viser server."""
        with self._view_lock:
            if self._view is None:
                self._view = View(self.session)
            return self._view

    def touch(self) -> None:
        """Remember that somebody uses the session."""
        self.last_seen = time.monotonic()

    def save(self) -> None:
        """Have the document written with what belongs to it, where any of it has changed."""
        session, state = self.session, _saveable(self.session)
        if state == self._saved:
            return
        self._saved = state
        saved = SavedSession(
            session.id, self._secret_hash, session.revision, "", session.design, session.origin,
            session.marks.document(), session.kept.saved(), session.display,
        )  # fmt: skip
        self._autosave.save(saved, on_saved=self._was_saved)

    def _was_saved(self, at: str) -> None:
        self.saved_at = at

    def close(self) -> None:
        """Save, and stop the view and the session."""
        self.closed = True
        self.save()
        self.session.close()
        with self._view_lock:
            if self._view is not None:
                self._view.close()
                self._view = None


class Sessions:
    """All sessions of this process. Those on disk open again when somebody asks for them."""

    def __init__(self, folder: Path, *, limits: Limits = DEFAULT_LIMITS) -> None:
        self._limits = limits
        self._autosave = Autosave(folder)
        self._open: dict[str, OpenSession] = {}
        self._lock = threading.Lock()
        self._kernel_started = False

    def create(self, design: Design, origin: Origin | None = None) -> tuple[OpenSession, str]:
        """Open a session on a design; returns it and the secret of its cookie. Raises `DesignError`."""
        session_id, secret = secrets.token_urlsafe(9), secrets.token_urlsafe(24)
        session = Session(session_id, design, limits=self._limits, origin=origin)
        opened = OpenSession(session, hash_secret(secret), self._autosave)
        with self._lock:
            self._open[session_id] = opened
        self._start_kernel()
        opened.save()
        self._autosave.flush()  # a proxy may send the page that follows to another process, which reads the file
        return opened, secret

    def get(self, session_id: str) -> Session | None:
        """Return a session by id, from memory or from disk; None where there is none."""
        opened = self.find(session_id)
        return None if opened is None else opened.session

    def find(self, session_id: str) -> OpenSession | None:
        """Return an open session by id, opened from disk if need be; None where there is none."""
        if not is_session_id(session_id):
            return None
        with self._lock:
            return self._open.get(session_id) or self._restore(session_id)

    def _restore(self, session_id: str) -> OpenSession | None:
        saved = self._autosave.load(session_id)
        if saved is None:
            return None
        try:
            session = Session(
                session_id, saved.design, limits=self._limits, revision=saved.revision, origin=saved.origin,
                kept=saved.kept, display=saved.display,
            )  # fmt: skip
            session.marks = read_marks(saved.marks)
        except DesignError as error:
            log.warning("the saved session %s cannot be used: %s", session_id, error)
            return None
        opened = OpenSession(session, saved.secret_hash, self._autosave, saved_at=saved.saved_at)
        self._open[session_id] = opened
        self._start_kernel()
        return opened

    def _start_kernel(self) -> None:
        """Have the kernel compiled, unless somebody has done so."""
        if not self._kernel_started and not kernel_is_ready():
            self._kernel_started = True
            warm_kernel_in_background()

    def reap(self, *, idle: float = IDLE) -> int:
        """Close sessions that nobody has used for a while; returns how many. Their files stay."""
        now = time.monotonic()
        with self._lock:
            quiet = [s for s in self._open.values() if s.connections == 0 and now - s.last_seen > idle]
            for opened in quiet:
                opened.save()
            self._autosave.flush()
            for opened in quiet:
                del self._open[opened.session.id]
        for opened in quiet:
            opened.close()
        return len(quiet)

    def close(self) -> None:
        """Save and close every session."""
        with self._lock:
            opened, self._open = list(self._open.values()), {}
        for session in opened:
            session.close()
        self._autosave.close()

    def __len__(self) -> int:
        return len(self._open)


def _saveable(session: Session) -> tuple[object, ...]:
    """Return what changes whenever there is something to save."""
    return session.revision, session.origin, session.marks.document(), session.kept.changes, session.display


def hash_secret(secret: str) -> str:
    """Return what is kept of a session's secret: long and random, it needs no salt."""
    return hashlib.sha256(secret.encode()).hexdigest()
