"""Owns what is said of a name that nothing goes by: which one was probably meant."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


def suggestion(wanted: str, names: Iterable[str], *, prefix: str = "") -> str | None:
    """Return a hint for someone who wrote `wanted`, in whichever case; None where no name is like it.

    `prefix` is what all names begin with, which makes none of them more alike.
    """
    known = {name.lower(): prefix + name for name in names}
    like = [known[name] for name in get_close_matches(wanted.lower(), known, n=2)]
    return f"did you mean {' or '.join(like)}?" if like else None
