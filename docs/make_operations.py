"""Owns the table of settings in docs/operations.md: `python -m docs.make_operations` writes it anew."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic.fields import FieldInfo

from server.settings import Settings

PAGE = Path(__file__).parent / "operations.md"
MARK = "<!-- made by python -m docs.make_operations -->\n"


def _default(name: str, field: FieldInfo) -> str:
    value: Any = field.default
    if name == "data":
        return "the user's data folder"  # another on each machine
    if value is None or value == ():
        return ""
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    return f"`{value:g}`" if isinstance(value, float) else f"`{value}`"


def settings_table() -> str:
    """Return the table: name in the environment, default, what it is."""
    rows = [
        f"| `GLIDER_STUDIO_{name.upper()}` | {_default(name, field)} | {field.description} |"
        for name, field in Settings.model_fields.items()
    ]
    return "\n".join(["| Variable | Default | |", "|---|---|---|", *rows, ""])


def page() -> str:
    """Return the page with its table made anew."""
    return PAGE.read_text(encoding="utf-8").partition(MARK)[0] + MARK + settings_table()


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
