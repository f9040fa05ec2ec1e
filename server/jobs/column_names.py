"""Owns names of columns for formats that take only letters, digits and underscores."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection, Iterable

OTHERS = re.compile(r"[^A-Za-z0-9]+")


def plain_names(names: Iterable[str], *, longest: int, taken: Collection[str] = ()) -> dict[str, str]:
    """Return a plain name for each name. It begins with a letter; in any case, no two are alike, nor like any `taken`.

    Accents are dropped, what else does not fit becomes an underscore, and a number tells apart what is then alike.
    """
    used = {name.lower() for name in taken}
    plain = {}
    for name in names:
        base = _plain(name)[:longest]
        found, number = base, 2
        while found.lower() in used:
            ending = f"_{number}"
            found, number = base[: longest - len(ending)] + ending, number + 1
        used.add(found.lower())
        plain[name] = found
    return plain


def _plain(name: str) -> str:
    letters = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    words = OTHERS.sub("_", letters).strip("_")
    return words if words[:1].isalpha() else f"column_{words}".rstrip("_")
