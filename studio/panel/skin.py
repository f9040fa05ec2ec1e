"""Owns the looks of the panel: one style sheet, a unit after each row, the list of components, boxes of plain text.

All text from a document is escaped here or goes through the client's own text nodes; addresses of widgets are the
client's element ids. Purely cosmetic: without it every control still works.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files

from models.problems import Problem

BASE = files(__package__).joinpath("panel.css").read_text(encoding="utf-8")
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?", re.IGNORECASE)


def style(units: Iterable[tuple[str, str]], components: Iterable[tuple[str, str, str, bool]]) -> str:
    """Return the style sheet as HTML.

    `units` are (element id, unit); `components` are the buttons of the list: (element id, colour, mass, selected).
    """
    rules = [BASE]
    for identity, unit in units:
        row = f'.mantine-Flex-root:has(> div > p > label[for="{identity}"])'
        rules.append(
            f"{row}::after {{ content: '{unit}'; flex: 0 0 3.4em; padding-left: .5em; font-size: .75em; opacity: .62; "
            "white-space: nowrap; }"
        )
    for identity, color, mass, selected in components:
        rules += _list_row(f'button[id="{identity}"]', color, mass, selected=selected)
    return "<style>" + "\n".join(rules) + "</style>"


def _list_row(button: str, color: str, mass: str, *, selected: bool) -> list[str]:
    background = "var(--mantine-color-default-hover)" if selected else "transparent"
    border = "var(--mantine-color-default-border)" if selected else "transparent"
    return [
        f"{button} {{ background: {background}; border: 1px solid {border}; color: inherit; font-weight: 400; "
        "padding-inline: .6em; height: 1.9em !important; }",
        f"{button}:hover {{ background: var(--mantine-color-default-hover); color: inherit; }}",
        f"div:has(> {button}) {{ padding-bottom: 1px !important; }}",
        f"{button} .mantine-Button-inner {{ justify-content: flex-start; width: 100%; }}",
        f"{button} .mantine-Button-inner::before {{ content: ''; flex: none; width: 9px; height: 9px; "
        f"border-radius: 2px; background: {color}; margin-right: .7em; }}",
        f"{button} .mantine-Button-inner::after {{ content: '{mass}'; margin-left: auto; padding-left: .6em; "
        "opacity: .62; font-size: .9em; font-variant-numeric: tabular-nums; }",
    ]


def heading(text: str) -> str:
    """Return a heading between parts of the panel."""
    return f'<h2 class="studio-head">{escape(text)}</h2>'


def plain(text: str) -> str:
    """Return a paragraph of plain text."""
    return f'<p class="studio-note">{escape(text)}</p>'


def place(pointer: str, names: Sequence[str]) -> str:
    """Return where a pointer leads, in words: a component by its name, then the field."""
    tokens = [token.replace("~1", "/").replace("~0", "~") for token in pointer.split("/")[1:]]
    if tokens[:2] == ["vehicle", "components"] and len(tokens) > 2 and tokens[2].isdigit():
        index = int(tokens[2])
        tokens = [names[index] if index < len(names) else tokens[2], *tokens[3:]]
    return ", ".join(token.replace("_", " ") for token in tokens) or "The design"


def problem_box(problems: Iterable[Problem], names: Sequence[str]) -> str:
    """Return what was wrong with the last change, and what holds meanwhile; nothing where nothing was.

    `names` are those of the components.
    """
    items = []
    for problem in problems:
        limit = (
            ""
            if problem.limit is None or _says(problem.message, problem.limit)
            else f" Limit: {escape(_number(problem.limit))}."
        )
        hint = "" if problem.hint is None else f" {escape(problem.hint[:1].upper() + problem.hint[1:])}."
        where = escape(place(problem.pointer, names))
        items.append(f"<b>{where}</b>{escape(problem.message)}.<i>{limit}{hint}</i>")
    if not items:
        return ""
    kept = "<i>Not applied: the last good glide stays.</i>"
    return f'<div class="studio-problem" role="alert">{"".join(items[:4])}{kept}</div>'


def _says(message: str, limit: float | int | str) -> bool:
    """Return whether a message already gives the bound, in SI, millimetres or degrees; static/problem.js asks alike."""
    if isinstance(limit, str):
        return limit in message
    numbers = [float(number) for number in NUMBER.findall(message)]
    return any(math.isclose(n, limit * scale, rel_tol=1e-5) for n in numbers for scale in (1.0, 1e3, math.degrees(1.0)))


def _number(limit: float | int | str) -> str:
    return f"{limit:g}" if isinstance(limit, float) else str(limit)
