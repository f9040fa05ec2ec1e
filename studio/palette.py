"""Owns the colours: one component has one colour in every view."""

from __future__ import annotations

from collections.abc import Sequence

from models.components import Component, Rigid

Rgb = tuple[int, int, int]

CELLS = ("#f2b134", "#4fc3a1", "#7aa7ff", "#d98cc4", "#a6d678", "#e4875c", "#43e9e2", "#c8c0ff")
"""Apart from each other for each kind of colour blindness (tests/studio/test_palette.py)."""
RIGID = "#9fb3c8"
# cyan, yellow, vermilion, pale violet: apart from each other and from the water for each kind of colour blindness
BUOYANCY, LIFT, DRAG, SIDE = "#7fe7ff", "#ffe45c", "#ff7a59", "#cd9cff"
CENTER_OF_MASS, CENTER_OF_BUOYANCY = "#ff6f81", "#5bc8f5"
PATH, BEACON = "#f3f7fb", "#ef5b6f"
PATH_SCALE = ("#7a6ff0", "#4f9be8", "#3cc3c0", "#6bdc8a", "#c2e55b", "#fff06a")
"""From low to high: each lighter than the one before, and none as dark as the water."""
MOMENT = "#a9ef9b"
OFFSET, CURRENT = "#ffffff", "#9fe3d6"
KEPT = ("#e58bc8", "#f2a83b", "#b9a2ff", "#e8e06a")
"""Kept runs by their place, as static/tokens.css names them in the dark."""
WATER_TOP, WATER_BOTTOM = "#397fa5", "#0f2a45"
FOG = "#24587a"
DEPTH_LINE, WALL_LINE = "#7fb2cf", "#4d86a8"
SURFACE_LINE = "#5b9dc0"
SURFACE, BED = "#8fd0ee", "#4a463c"
PLOT_COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#5a5a5a")
"""Lines on white paper, apart for each kind of colour blindness (Okabe, Ito, 2008)."""


def rgb(color: str) -> Rgb:
    """Return the channels of #rrggbb, 0 to 255."""
    return int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16)


def component_colors(components: Sequence[Component]) -> list[str]:
    """Return each component's colour: its own, or one of the palette that no other component has."""
    taken = {c.color.lower() for c in components if c.color}
    free = [color for color in CELLS if color not in taken] or list(CELLS)
    colors, used = [], 0
    for component in components:
        if component.color:
            colors.append(component.color.lower())
        elif isinstance(component, Rigid):
            colors.append(RIGID)
        else:
            colors.append(free[used % len(free)])
            used += 1
    return colors
