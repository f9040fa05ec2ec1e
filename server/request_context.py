"""Owns what any code may know of the request it works for: its id and its user, for the log. It knows no HTTP."""

from __future__ import annotations

import re
import secrets
from contextvars import ContextVar
from dataclasses import dataclass

ACCEPTED_ID = re.compile(r"[A-Za-z0-9._-]{1,64}")


@dataclass(slots=True)
class RequestContext:
    """A request's id, and the name of the token that it brought."""

    id: str
    principal: str


_current: ContextVar[RequestContext | None] = ContextVar("glider_studio_request", default=None)
current = _current.get
"""Returns the request that this task or thread works for; None beside any request."""
enter, leave = _current.set, _current.reset


def request_id(given: str | None) -> str:
    """Return the id that a client sent, where it is plain and short, else a new one."""
    return given if given is not None and ACCEPTED_ID.fullmatch(given) else secrets.token_hex(8)


def name_principal(name: str) -> None:
    """Tell the log whose request this is."""
    context = current()
    if context is not None:
        context.principal = name
