"""Owns the identifiers of designs: 26 characters that sort by the time they were made, safe in addresses and files."""

from __future__ import annotations

import re
import secrets
import time

ALPHABET = "0123456789abcdefghjkmnpqrstvwxyz"
LENGTH = 26
ID = re.compile(rf"[{ALPHABET}]{{{LENGTH}}}\Z")


def new_id() -> str:
    """Return a new identifier: 48 bits of milliseconds since 1970, then 80 random bits, in Crockford's base 32."""
    number = int(time.time() * 1000.0) << 80 | secrets.randbits(80)
    return "".join(ALPHABET[number >> shift & 31] for shift in range(5 * (LENGTH - 1), -1, -5))


def is_id(text: str) -> bool:
    """Whether text can be an identifier at all; what cannot never reaches the database."""
    return ID.match(text) is not None
