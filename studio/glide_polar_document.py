"""Owns the glide polar as the page draws it: glides at some heaves of the cells, by their speeds, and the best ones."""

from __future__ import annotations

from typing import Any

from models.assemble import Assembly
from models.glide_polar import GlidePolar, glide_polar
from models.trim import Trim
from studio.held_glides import trim_document

POINTS = 24
"""Trims a curve: enough for a smooth line on a screen."""


def glide_polar_document(assembly: Assembly) -> dict[str, Any]:
    """Return the envelope of a design's glides with all its cells free; raises what `glide_polar` does."""
    polar = glide_polar(assembly, points=POINTS)
    return {
        "cells": polar.cells,
        "curves": [
            {"heave": curve.heave, "points": [_point(trim) for trim in curve.points]}
            for curve in polar.curves
            if curve.points
        ],
        "best": best_points(polar),
        "left_out": polar.left_out,
        "energy": polar.energy,
    }


def best_points(polar: GlidePolar) -> list[dict[str, Any]]:
    """Return the best points with a name for each; what there is none of is left out."""
    best = polar.best_energy
    named: tuple[tuple[str, Trim | None, dict[str, Any]], ...] = (
        ("Best range", polar.best_range, {}),
        ("Slowest sink", polar.slowest_sink, {}),
        ("Least energy", None if best is None else best.trim, {} if best is None else {"per_km": best.per_km}),
        ("Tightest turn", polar.tightest_turn, {}),
    )
    return [
        {"name": name} | trim_document(trim) | {"extensions": dict(trim.extensions)} | more
        for name, trim, more in named
        if trim is not None
    ]


def _point(trim: Trim) -> list[float]:
    """Return horizontal and vertical speed (m/s, down positive), angle of attack and whether it is stable (1 or 0)."""
    return [trim.horizontal_speed, trim.sink_rate, trim.angle_of_attack, float(trim.stable)]
