"""Owns what is fixed in the water, under `/world`: surface, bed, lines of depth, and the path of the glide."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from models.design import Design
from models.run import Run
from studio import grid, meshes, palette
from studio.curves import MAX_POINTS, curve_samples
from studio.grid import Lines, nice_step, segments
from studio.palette import rgb
from studio.path_colors import Scale, colors_of, linear
from studio.scene import add_mesh, vehicle_length
from studio.scene_current import current_arrows

Array = NDArray[np.float64]

LIKE_LENGTH = 0.1
"""By how much a vehicle may grow or shrink before the lines around it are spaced anew."""
MUCH_LARGER = 1.6
"""How many times as large as wanted a frame may be."""


def path_points(run: Run) -> Array:
    """Return the path of the body origin at the samples of the page's curves, rows of x, y, z, m."""
    return points_at(run, curve_samples(run, MAX_POINTS[run.model]))


def points_at(run: Run, chosen: NDArray[np.int64]) -> Array:
    """Return the path of the body origin at some samples."""
    x, z = run.values["x"][chosen], run.values["z"][chosen]
    return np.column_stack([x, run.values["y"][chosen] if run.model == "spatial" else np.zeros(len(chosen)), z])


def segment_colors(run: Run, chosen: NDArray[np.int64], scale: Scale | None) -> NDArray[np.uint8]:
    """Return the colours (n - 1, 2, 3) of the path's segments by a quantity, or in one colour without a scale."""
    if scale is None:
        return np.broadcast_to(linear(np.array(rgb(palette.PATH))), (max(len(chosen) - 1, 1), 2, 3))
    colors = linear(colors_of(run.values[scale.name][chosen], scale))
    line = colors if len(colors) > 1 else np.repeat(colors, 2, axis=0)
    return np.stack([line[:-1], line[1:]], axis=1)


def position_at(run: Run, t: float) -> tuple[float, float, float]:
    """Return where the body origin is at a time, m."""

    def now(name: str) -> float:
        return float(np.interp(t, run.times, run.values[name])) if name in run.values else 0.0

    return now("x"), now("y"), now("z")


@dataclass(frozen=True)
class Frame:
    """What is drawn around a path: lines in its plane or a room, between two corners, for a vehicle of some length."""

    kind: str
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    length: float
    bed: float | None

    def suits(self, wanted: Frame, points: Array, margin: float) -> bool:
        """Whether this frame can stay where another is wanted: around the path all the same, and not much larger."""
        if (self.kind, self.bed) != (wanted.kind, wanted.bed) or not math.isclose(
            self.length, wanted.length, rel_tol=LIKE_LENGTH
        ):
            return False
        for i in (0, 1, 2) if self.kind == "space" else (0, 2):
            # surface and bed bound the frame, whatever the path does there
            low_enough = self.low[i] <= max(points[:, i].min() - margin, wanted.low[i])
            high_enough = self.high[i] >= min(points[:, i].max() + margin, wanted.high[i])
            if not (low_enough and high_enough):
                return False
            if self.high[i] - self.low[i] > MUCH_LARGER * (wanted.high[i] - wanted.low[i]):
                return False
        return True


class WaterNodes:
    """The water around the glider. `/world/path` is one node, whose points alone are sent again after a run."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self.frame = scene.add_frame("/world", show_axes=False)
        self._path: Any = None
        self._frame: Frame | None = None
        self._fixed: list[Any] = []
        self._rungs: list[Any] = []
        self._current: list[Any] = []
        self._current_of: tuple[object, ...] | None = None

    def show_path(self, points: Array, colors: NDArray[np.uint8]) -> None:
        """Draw the path, each segment (n - 1, 2, 3) in its colours."""
        line = segments(points)
        if self._path is None:
            self._path = self._scene.add_line_segments(
                "/world/path", line, colors, thickness=3.0, thickness_units="screen"
            )
        else:
            self._path.points, self._path.colors = line, colors

    def frame_around(self, design: Design, points: Array) -> None:
        """Draw surface, bed and lines of depth around a path; what is fixed anew only where the path outgrew it.

        A path that hardly leaves the plane y = 0 has its lines in it, one that turns a ladder of its own and walls.
        """
        if float(np.ptp(points[:, 1])) > vehicle_length(design):
            self._frame_space(design, points)
        else:
            self._frame_plane(design, points)

    def _frame_plane(self, design: Design, points: Array) -> None:
        length = vehicle_length(design)
        bed = design.mission.environment.bed_depth
        reach = 4.0 * length
        step = max(nice_step(reach, 5), nice_step(float(np.ptp(points[:, 2])) + length, grid.MAX_DEPTH_LINES - 8))
        low = step * math.floor((points[:, 2].min() - reach) / step)
        high = step * math.ceil((points[:, 2].max() + reach) / step)
        begin = 4.0 * step * math.floor((points[:, 0].min() - reach) / (4.0 * step))
        end = 4.0 * step * math.ceil((points[:, 0].max() + reach) / (4.0 * step))
        low, high = max(low, 0.0), high if bed is None else min(high, bed)
        wanted = Frame("plane", (begin, 0.0, low), (end, 0.0, high), length, bed)
        if self._is_new(wanted, points, reach / 2.0):
            self._draw("grid", grid.plane(low, high, begin, end, step=step, apart=3.5 * length), palette.DEPTH_LINE)
            self._add_sheets((begin, end), (-2.5 * length, 0.0), length, bed)
        self._show_current(design, points)

    def _frame_space(self, design: Design, points: Array) -> None:
        length, bed = vehicle_length(design), design.mission.environment.bed_depth
        low, high = grid.room_box(points, length, bed)
        (x0, y0, z0), (x1, y1, z1) = low.tolist(), high.tolist()
        if self._is_new(Frame("space", (x0, y0, z0), (x1, y1, z1), length, bed), points, length):
            self._draw("room", grid.room(low, high), palette.WALL_LINE)
            self._add_sheets((x0, x1), (y0, y1), length, bed)
        self._show_rungs(grid.rungs(points, length))
        self._show_current(design, points)

    def _is_new(self, wanted: Frame, points: Array, margin: float) -> bool:
        """Whether a frame must be drawn anew, and if so take the old one away; it stays while it still suits.

        Dozens of labels are most of what a redraw costs: while somebody drags, a path that moves a little keeps them.
        """
        drawn = self._frame
        if drawn is not None and drawn.suits(wanted, points, margin):
            return False
        self._frame = wanted
        for node in (*self._fixed, *self._rungs[:1]):  # labels are children: they leave with their lines
            node.remove()
        self._fixed, self._rungs = [], []
        return True

    def _draw(self, name: str, drawn: Lines, color: str) -> None:
        root = f"/world/{name}"
        self._fixed.append(
            self._scene.add_line_segments(root, drawn.lines, rgb(color), thickness=1.0, thickness_units="screen")
        )
        for k, label in enumerate(drawn.labels):
            self._add_label(f"{root}/label{k}", *label)  # a child of the lines: it leaves the scene with them

    def _add_label(self, name: str, text: str, place: tuple[float, float, float]) -> Any:
        return self._scene.add_label(name, text, position=place, font_screen_scale=0.7, anchor="bottom-left")

    def _show_rungs(self, drawn: Lines) -> None:
        """Move the rungs to where the path now passes: their lines in one node, and as many labels as are needed."""
        if not self._rungs:
            lines = self._scene.add_line_segments(
                "/world/rungs", drawn.lines, rgb(palette.DEPTH_LINE), thickness=1.0, thickness_units="screen"
            )
            self._rungs = [lines]
        self._rungs[0].points = drawn.lines
        labels = self._rungs[1:]
        while len(labels) > len(drawn.labels):
            labels.pop().remove()
        for k, (text, place) in enumerate(drawn.labels):
            if k == len(labels):
                labels.append(self._add_label(f"/world/rungs/label{k}", text, place))
            labels[k].text, labels[k].position = text, place
        self._rungs = [self._rungs[0], *labels]

    def _show_current(self, design: Design, points: Array) -> None:
        drawn = current_arrows(design.mission.environment.current, points, vehicle_length(design))
        wanted = drawn.arrows.tobytes(), tuple(drawn.labels)
        if wanted == self._current_of:
            return
        for node in self._current:
            node.remove()
        self._current, self._current_of = [], wanted
        if not len(drawn.arrows):
            return
        length = vehicle_length(design)
        self._current.append(
            self._scene.add_arrows(
                "/world/current", drawn.arrows, rgb(palette.CURRENT),
                shaft_radius=0.008 * length, head_radius=0.03 * length, head_length=0.09 * length,
            )
        )  # fmt: skip
        for k, label in enumerate(drawn.labels):
            self._add_label(f"/world/current/label{k}", *label)

    def _add_sheets(self, x: tuple[float, float], y: tuple[float, float], length: float, bed: float | None) -> None:
        # beyond what is seen from any depth: an edge would look like a wall
        far = max(40.0 * length, 2.0 * (x[1] - x[0]), 2.0 * (y[1] - y[0]), 8.0 * (bed or 0.0))
        sheet = meshes.sheet((x[0] - far, x[1] + far), (y[0] - far, y[1] + far))
        # seen from below only: from above it would veil what lies under it
        self._fixed.append(add_mesh(self._scene, "/world/surface", sheet, palette.SURFACE, opacity=0.3, one_sided=True))
        self._fixed.append(
            self._scene.add_line_segments(
                "/world/surface_grid", grid.level_grid(x, y, length), rgb(palette.SURFACE_LINE),
                thickness=1.0, thickness_units="screen", position=(0.0, 0.0, -0.004 * length),
            )  # a little above the surface, or the two would fight for who is in front
        )  # fmt: skip
        if bed is not None:
            floor = add_mesh(self._scene, "/world/bed", sheet, palette.BED)
            floor.position = (0.0, 0.0, bed)
            self._fixed.append(floor)
