"""Owns the pages that are files, and the files that they load, which are kept in memory.

Each page is answered with all modules that its scripts import announced in its head: a browser that had to read a
module before it knows the next would fetch the studio's many in a long row of rounds. It names them in a folder that
is called after what they hold, so that a browser that has them need not ask for them again.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Mapping
from functools import lru_cache
from importlib.resources import files
from pathlib import Path

from fastapi.responses import HTMLResponse, Response

STATIC = Path(str(files("static")))
KINDS = {
    ".js": "text/javascript", ".css": "text/css", ".html": "text/html", ".svg": "image/svg+xml", ".woff2": "font/woff2",
    ".png": "image/png",
}  # fmt: skip
"""What is served of the folder; no Python."""
SNIFF_NOT = {"X-Content-Type-Options": "nosniff"}
ASKED_EACH_TIME = SNIFF_NOT | {"Cache-Control": "no-cache"}
KEPT_FOR_GOOD = SNIFF_NOT | {"Cache-Control": "max-age=31536000, immutable"}
_FOLDER = re.compile(r'(?:href|src)="(?:\.\./)*static/')
_SCRIPT = re.compile(r'<script type="module" src="(?P<folder>[^"]*/)(?P<name>[^"/]+)"></script>')
_IMPORT = re.compile(r'^(?:import|export|\}) .*?"\./(?P<name>[\w.-]+\.js)";', re.MULTILINE)


def static_file(name: str, known: str | None, release: str | None = None) -> Response:
    """Return the file static/`name`, or 304 where `known`, an If-None-Match, names it. Raises `KeyError`.

    Asked for by the present `release_of_files` it may be kept for good. A studio's page asks for a hundred of them at
    once: to read each by a thread of its own would take three times as long.
    """
    path = STATIC / name
    if Path(name).name != name or path.suffix not in KINDS or not path.is_file():
        raise KeyError(name)
    content, tag = _content(path, path.stat().st_mtime_ns)
    for_good = release is not None and release == release_of_files()
    headers = (KEPT_FOR_GOOD if for_good else ASKED_EACH_TIME) | {"ETag": tag}
    if known is not None and tag in known:
        return Response(status_code=304, headers=headers)
    return Response(content, media_type=KINDS[path.suffix], headers=headers)


@lru_cache(maxsize=512)
def _content(path: Path, _changed: int) -> tuple[bytes, str]:
    content = path.read_bytes()
    return content, f'"{hashlib.sha256(content).hexdigest()[:32]}"'


def release_of_files() -> str:
    """Return what names the present content of all that is served of the folder."""
    return _release(_stamps())


@lru_cache(maxsize=8)
def _release(stamps: tuple[tuple[str, int], ...]) -> str:
    tags = "".join(_content(STATIC / name, changed)[1] for name, changed in stamps)
    return hashlib.sha256(tags.encode()).hexdigest()[:16]


def file_page(name: str, headers: Mapping[str, str]) -> Response:
    """Return the page in the file static/`name`."""
    return HTMLResponse(_page(name, _stamps()), headers=dict(headers))


def _stamps() -> tuple[tuple[str, int], ...]:
    """Return what changes whenever a page or a file that it loads does."""
    with os.scandir(STATIC) as entries:
        return tuple(sorted((e.name, e.stat().st_mtime_ns) for e in entries if Path(e.name).suffix in KINDS))


@lru_cache(maxsize=8)
def _page(name: str, stamps: tuple[tuple[str, int], ...]) -> str:
    page = (STATIC / name).read_text(encoding="utf-8")
    page = _FOLDER.sub(lambda folder: f"{folder[0]}{_release(stamps)}/", page)
    return _SCRIPT.sub(lambda script: _links(script["folder"], script["name"]) + script[0], page)


def _links(folder: str, script: str) -> str:
    return "".join(f'<link rel="modulepreload" href="{folder}{name}">\n  ' for name in imported_by(script))


def imported_by(script: str) -> list[str]:
    """Return the modules that a module in static/ imports, and those that these do, each once, without itself."""
    found, waiting = [script], [script]
    while waiting:
        text = (STATIC / waiting.pop(0)).read_text(encoding="utf-8")
        fresh = [name for name in _IMPORT.findall(text) if name not in found]
        fresh = list(dict.fromkeys(fresh))
        found += fresh
        waiting += fresh
    return found[1:]
