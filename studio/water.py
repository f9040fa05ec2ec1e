"""Owns what is fixed in the water, under `/world`: surface, bed, depth lines, and the path of the glide."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from models.design import Design
from models.run import Run
from server.decimation import choose_samples
from studio import meshes, palette
from studio.palette import rgb
from studio.scene import add_mesh, vehicle_length

Array = NDArray[np.float64]

MAX_PATH_POINTS = 2000
MAX_DEPTH_LINES = 24
MAX_LABELS = 112


def nice_step(span: float, most: int) -> float:
    """Return the smallest of 1, 2, 5 times a power of ten that divides a span into at most `most` steps."""
    least = span / most
    power = 10.0 ** math.floor(math.log10(least))
    return next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= least * (1.0 - 1e-12))


def path_points(run: Run) -> Array:
    """Return the path of the body origin, at most `MAX_PATH_POINTS` rows of x, y, z, m."""
    x, z = run.values["x"], run.values["z"]
    chosen = choose_samples([z, x], MAX_PATH_POINTS)
    return np.column_stack([x[chosen], np.zeros(len(chosen)), z[chosen]])


def segments(points: Array) -> NDArray[np.float32]:
    """Return a line through points as segments (n - 1, 2, 3)."""
    line = points if len(points) > 1 else np.repeat(points, 2, axis=0)
    return np.stack([line[:-1], line[1:]], axis=1).astype(np.float32)


class WaterNodes:
    """The water around the glider. `/world/path` is one node, whose points alone are sent again after a run."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self.frame = scene.add_frame("/world", show_axes=False)
        self._path: Any = None
        self._frame_of: tuple[float, ...] | None = None
        self._grid: list[Any] = []

    def show_path(self, points: Array) -> None:
        """Draw the path."""
        line = segments(points)
        if self._path is None:
            self._path = self._scene.add_line_segments(
                "/world/path", line, rgb(palette.PATH), thickness=2.5, thickness_units="screen"
            )
        else:
            self._path.points = line

    def frame_around(self, design: Design, points: Array) -> None:
        """Draw surface, bed and depth lines around a path; anew only where it outgrew them."""
        length = vehicle_length(design)
        bed = design.mission.environment.bed_depth
        reach = 4.0 * length
        step = max(nice_step(reach, 5), nice_step(float(np.ptp(points[:, 2])) + length, MAX_DEPTH_LINES - 8))
        low = step * math.floor((points[:, 2].min() - reach) / step)
        high = step * math.ceil((points[:, 2].max() + reach) / step)
        begin = 4.0 * step * math.floor((points[:, 0].min() - reach) / (4.0 * step))
        end = 4.0 * step * math.ceil((points[:, 0].max() + reach) / (4.0 * step))
        wanted = (max(low, 0.0), high if bed is None else min(high, bed), begin, end, step, length, bed or 0.0)
        if wanted != self._frame_of:
            self._frame_of = wanted
            self._draw_frame(*wanted)

    def _draw_frame(
        self, low: float, high: float, begin: float, end: float, step: float, length: float, bed: float
    ) -> None:
        for node in self._grid:
            node.remove()
        behind = -2.5 * length
        first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
        depths = step * np.arange(first, last + 1, dtype=np.float64)
        # in the plane of the glide: behind it, perspective would put the glider at another line than its own
        lines = np.array([[(begin, 0.0, z), (end, 0.0, z)] for z in depths], dtype=np.float32).reshape(-1, 2, 3)
        self._grid = [
            self._scene.add_line_segments(
                "/world/grid", lines, rgb(palette.DEPTH_LINE), thickness=1.0, thickness_units="screen"
            )
        ]
        self._add_labels(depths, begin, end, 0.0, 3.5 * length)
        far = ((begin - 40.0 * length, end + 40.0 * length), (behind - 40.0 * length, 40.0 * length))
        # seen from below only: from above it would veil what lies under it
        sheet = meshes.sheet(*far)
        surface = add_mesh(self._scene, "/world/surface", sheet, palette.SURFACE, opacity=0.3, one_sided=True)
        self._grid.append(surface)
        if bed > 0.0:
            floor = add_mesh(self._scene, "/world/bed", sheet, palette.BED)
            floor.position = (0.0, 0.0, bed)
            self._grid.append(floor)

    def _add_labels(self, depths: Array, begin: float, end: float, behind: float, apart: float) -> None:
        # where the glider passes there should always be a label in sight
        columns = max(1, min(round((end - begin) / apart), MAX_LABELS // max(len(depths), 1)))
        places = np.linspace(begin, end, columns + 1)[:-1]
        for k, (x, z) in enumerate((x, z) for x in places for z in depths):
            # children of the grid: they leave the scene with it
            self._scene.add_label(
                f"/world/grid/label{k}", f"{z:g} m", position=(float(x), behind, float(z)), font_screen_scale=0.7,
                anchor="bottom-left",
            )  # fmt: skip
