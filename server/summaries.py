"""Owns how notes are shortened for lists."""

from __future__ import annotations

import re

LONGEST_SUMMARY = 220


def summarize(notes: str) -> str:
    """Return the first sentences of some notes that fit, or the beginning of the first, cut at a word."""
    # a full stop after a single letter is an initial, not the end of a sentence
    sentences = re.split(r"(?<=[\w)\]'\"%][\w)\]'\"%][.!?])\s+(?=[A-Z])", notes.strip())
    summary = sentences[0]
    for sentence in sentences[1:]:
        if len(summary) + 1 + len(sentence) > LONGEST_SUMMARY:
            break
        summary = f"{summary} {sentence}"
    if len(summary) <= LONGEST_SUMMARY:
        return summary
    return summary[: LONGEST_SUMMARY - 1].rsplit(" ", 1)[0].rstrip(" ,;:") + "…"
