"""Owns where a session's document came from: a stored design at a revision, or a case of a job."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class StoredOrigin:
    """The document was opened from a stored design, or saved as one."""

    design_id: str
    revision: int
    identity: str
    """That of the design then: with another one there is something to save."""


@dataclass(frozen=True, slots=True)
class CaseOrigin:
    """The document is that of a case of a job."""

    job_id: str
    job_name: str
    case: int
    identity: str


Origin = StoredOrigin | CaseOrigin
KINDS: dict[str, type[Origin]] = {"stored": StoredOrigin, "case": CaseOrigin}


def origin_document(origin: Origin | None) -> dict[str, Any] | None:
    """Return an origin as JSON."""
    if origin is None:
        return None
    return {"kind": "stored" if isinstance(origin, StoredOrigin) else "case"} | asdict(origin)


def read_origin(document: Any) -> Origin | None:
    """Return the origin in JSON that `origin_document` made; raises `KeyError` or `TypeError` for any other."""
    if document is None:
        return None
    fields = dict(document)
    return KINDS[fields.pop("kind")](**fields)
