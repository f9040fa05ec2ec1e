"""Owns the pictures of presets: the glider's silhouette from the side and the path of its glide, as SVG."""

from __future__ import annotations

from functools import lru_cache
from html import escape

import numpy as np
from scipy.spatial import ConvexHull

from models.design import Design
from models.presets import load_preset, preset_ids
from models.run import Run
from models.simulate import simulate
from models.warm import kernel_is_ready
from studio import palette
from studio.attitude import rotate
from studio.bodies import Body, bodies
from studio.meshes import Array
from studio.palette import component_colors
from studio.water import path_points

WIDTH, HEIGHT = 480, 216
GLIDER_BAND, PATH_BAND, WHOLE_BAND = (24.0, 96.0), (118.0, 192.0), (36.0, 180.0)
MARGIN = 36.0
FROM_NORTH_EAST = np.array([[0.82, 0.21], [-0.57, 0.30], [0.0, 0.93]])
"""Takes north, east and down to across and down in a picture from the north-east, a little from above."""


def preset_svg(preset_id: str) -> tuple[str, bool]:
    """Return a preset's picture, and whether it is complete (the path needs the kernel). Raises `KeyError`."""
    if not kernel_is_ready():
        return draw(load_preset(preset_id), None), False
    return _complete_svg(preset_id), True


def draw_all_presets() -> None:
    """Have every preset's picture ready before somebody waits for it; the kernel must be."""
    for preset_id in preset_ids():
        _complete_svg(preset_id)


@lru_cache(maxsize=32)
def _complete_svg(preset_id: str) -> str:
    design = load_preset(preset_id)
    return draw(design, simulate(design))


def draw(design: Design, run: Run | None) -> str:
    """Return the picture of a design, with the path of a run where there is one."""
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img">',
        f"<title>{escape(design.name)}</title>",
        '<defs><linearGradient id="water" x1="0" y1="0" x2="0" y2="1">'
        f'<stop offset="0" stop-color="{palette.WATER_TOP}"/><stop offset="1" stop-color="{palette.WATER_BOTTOM}"/>'
        "</linearGradient></defs>",
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="url(#water)"/>',
        *_silhouette(design, WHOLE_BAND if run is None else GLIDER_BAND),
    ]
    if run is not None:
        parts += _path(run)
    return "".join([*parts, "</svg>"])


def _outline(body: Body, position: tuple[float, float, float]) -> Array:
    """Return the outline of a body seen from starboard: rows of x and z, m."""
    points = rotate(body.mesh.vertices, body.attitude) + np.array(body.offset) + np.array(position)
    flat = points[:, [0, 2]]
    if body.kind == "bellows":  # its zigzag is not convex: the profile, up one side and down the other
        rings = body.mesh.vertices.reshape(-1, 48, 3)
        profile = np.stack([rings[:, 0, 0], rings[:, 0, 1]], axis=1)
        around = np.concatenate([profile, profile[::-1] * (1.0, -1.0)])
        turned = rotate(np.column_stack([around[:, 0], np.zeros(len(around)), around[:, 1]]), body.attitude)
        return np.asarray((turned + np.array(body.offset) + np.array(position))[:, [0, 2]])
    return np.asarray(flat[ConvexHull(flat).vertices])


def _silhouette(design: Design, band: tuple[float, float]) -> list[str]:
    components = design.vehicle.components
    drawn = [
        (_outline(body, component.position), color, body.opacity)
        for component, color in zip(components, component_colors(components), strict=True)
        for body in bodies(component)
    ]
    if not drawn:
        return []
    corners = np.concatenate([outline for outline, _, _ in drawn])
    low, high = corners.min(axis=0), corners.max(axis=0)
    top, bottom = band
    scale = min((WIDTH - 2 * MARGIN) / max(high[0] - low[0], 1e-6), (bottom - top) / max(high[1] - low[1], 1e-6))
    middle = (low + high) / 2.0
    shapes = []
    for outline, color, opacity in drawn:
        at = (outline - middle) * scale + np.array([WIDTH / 2.0, (top + bottom) / 2.0])
        corners_text = " ".join(f"{x:.1f},{y:.1f}" for x, y in at)
        shapes.append(f'<polygon points="{corners_text}" fill="{color}" fill-opacity="{opacity or 0.95:.2f}"/>')
    return shapes


def _path(run: Run) -> list[str]:
    whole = path_points(run)
    turns = float(np.ptp(whole[:, 1])) > 0.1 * float(np.ptp(whole[:, 0]))
    points = whole @ FROM_NORTH_EAST if turns else whole[:, [0, 2]]
    points = points[:: max(1, len(points) // 240)]
    low, high = points.min(axis=0), points.max(axis=0)
    top, bottom = PATH_BAND
    # both axes alike where that fills the band, else the depth enlarged: its shape is what one recognises
    across = (WIDTH - 2 * MARGIN) / max(high[0] - low[0], 1e-6)
    down = (bottom - top) / max(high[1] - low[1], 1e-6)
    if turns:  # a circle enlarged one way would be none
        across = down = min(across, down)
    at = (points - low) * (across, min(down, 4.0 * across)) + np.array([MARGIN, top])
    at[:, 0] += (WIDTH - MARGIN - at[:, 0].max()) / 2.0
    line = " ".join(f"{x:.1f},{y:.1f}" for x, y in at)
    return [
        f'<polyline points="{line}" fill="none" stroke="{palette.PATH}" stroke-opacity=".9" stroke-width="2" '
        'stroke-linejoin="round" stroke-linecap="round"/>',
        f'<circle cx="{at[0][0]:.1f}" cy="{at[0][1]:.1f}" r="4" fill="{palette.PATH}"/>',
    ]
