"""Owns the setting of notes in presets."""

from __future__ import annotations


def prose(paragraph: str) -> str:
    """Return a paragraph on one line."""
    return " ".join(paragraph.split())
