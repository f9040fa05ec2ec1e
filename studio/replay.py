"""Owns the replay of a glide as one HTML file that opens without a network: Viser's client, the scene, and a player.

The scene is serialized once, still; the page's own modules (static/replay.js and what it imports) move it, so that a
replay shows what the studio shows. They travel as data addresses behind an import map, since a file has no server.
"""

from __future__ import annotations

import base64
import json
import re
from datetime import UTC, datetime
from html import escape
from importlib.resources import files
from typing import Any

from models.problems import DesignError, Problem
from server.answers import series_json
from studio.session import Session
from studio.state import state_of
from studio.view import View

MOST_BYTES = 3_000_000
TRIES = 3
"""How often a replay is begun again because the design changed meanwhile."""
ENTRY = "replay.js"
STYLES = ("tokens.css", "replay.css")
SHOWN = (
    "name",
    "components",
    "model",
    "length",
    "duration",
    "bed_depth",
    "hydrodynamics",
    "hydrodynamics_range",
    "solver",
    "run",
)
_IMPORT = re.compile(r'(?<=from )"\./([a-z0-9]+\.js)"')


def replay_html(session: Session) -> str:
    """Return the present glide as one HTML file.

    Raises
    ------
    DesignError
        Where there is no glide of the present design, or the file would be too large.

    """
    for _ in range(TRIES):
        design, run = session.design, session.run
        if run is None or session.simulating:
            message = "the glide of the present design is not computed yet"
            raise DesignError([Problem("", message, hint="wait until the page says Ready, then export again")])
        scene, state = _scene(session), state_of(session, saved_at=None)
        if design is session.design and run is session.run:
            legend = {name: state["scene"][name] for name in ("path", "path_colors")}
            return _checked(_assembled(scene, {name: state[name] for name in SHOWN} | {"scene": legend}))
    message = "the design changed while its replay was made"
    raise DesignError([Problem("", message, hint="export again when the edit is done")])


def _scene(session: Session) -> str:
    """Return Viser's client with the scene in it, from a server of its own: nobody's view is recorded."""
    view = View(session)
    try:
        return str(view.server.get_scene_serializer().as_html(dark_mode=True))
    finally:
        view.close()


def _assembled(client: str, document: dict[str, Any]) -> str:
    modules = _modules(ENTRY)
    addresses = {f"studio/{name}": f"data:text/javascript;base64,{_base64(text)}" for name, text in modules.items()}
    # no text of a design may end the script that it stands in
    data = series_json(document).decode().replace("<", "\\u003c")
    made = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    start = f'import {{ startReplay }} from "studio/{ENTRY}"; startReplay({json.dumps(made)});'
    head = (
        f'<script type="importmap">{json.dumps({"imports": addresses})}</script>'
        f"<style>{''.join(_static(name) for name in STYLES)}</style>"
        f'<script type="application/json" id="replay-data">{data}</script>'
        f'<script type="module">{start}</script>'
    )
    title = f"<title>{escape(document['name'])} · Replay</title>"
    page = re.sub(r"<title>.*?</title>", lambda _: title, client, count=1)
    # before the client's own modules: an import map that comes later would be ignored by some browsers
    return page.replace('<meta charset="utf-8" />', f'<meta charset="utf-8" />{head}', 1)


def _modules(name: str, known: dict[str, str] | None = None) -> dict[str, str]:
    """Return a module of the page and all that it imports, their imports by the names of the import map."""
    found = {} if known is None else known
    if name not in found:
        text = _static(name)
        found[name] = _IMPORT.sub(r'"studio/\1"', text)
        for imported in _IMPORT.findall(text):
            _modules(imported, found)
    return found


def _static(name: str) -> str:
    return files("static").joinpath(name).read_text(encoding="utf-8")


def _base64(text: str) -> str:
    return base64.b64encode(text.encode()).decode("ascii")


def _checked(page: str) -> str:
    size = len(page.encode())
    if size > MOST_BYTES:
        message = f"the replay would have {size / 1e6:.1f} MB"
        raise DesignError(
            [Problem("", message, limit=MOST_BYTES, hint="replay a shorter mission, or fewer components")]
        )
    return page
