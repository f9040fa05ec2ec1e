"""Owns the tokens that open the API: how several are written in one setting, each with a name for logs and quotas."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

LEAST_TOKEN = 16
NAMED = re.compile(r"(?:(?P<name>[A-Za-z0-9._-]{1,40}):)?(?P<secret>.*)", re.DOTALL)


@dataclass(frozen=True)
class NamedToken:
    """A token, and the name under which its use is logged and counted."""

    name: str
    secret: str = field(repr=False)


def read_tokens(text: str) -> tuple[NamedToken, ...]:
    """Return the tokens of `name:token,name:token`; those without a name are called token-1, token-2.

    Raises
    ------
    ValueError
        Where a token is weak, or a name or a token comes twice. No message repeats a token.

    """
    tokens = []
    for place, item in enumerate(text.split(","), start=1):
        match = NAMED.fullmatch(item.strip())
        assert match is not None, "the pattern matches any text"
        secret = match["secret"]
        if len(secret) < LEAST_TOKEN or not secret.isascii() or not secret.isprintable() or " " in secret:
            raise ValueError(
                f"GLIDER_STUDIO_TOKEN must be at least {LEAST_TOKEN} printable ASCII characters without spaces, "
                "or several such, each as token or name:token, separated by commas"
            )
        tokens.append(NamedToken(match["name"] or f"token-{place}", secret))
    for kind, values in (("name", [t.name for t in tokens]), ("token", [t.secret for t in tokens])):
        if len(set(values)) < len(values):
            raise ValueError(f"GLIDER_STUDIO_TOKEN holds the same {kind} twice: give every user another")
    return tuple(tokens)
