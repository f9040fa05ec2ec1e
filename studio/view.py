"""Owns a session's view: its Viser server with the scene, redrawn from the session in one message at a time."""

from __future__ import annotations

import logging
import threading
from itertools import product

import numpy as np
from numpy.typing import NDArray

from models.components import Actuated, Mover, RollingMass
from models.design import Design
from models.mission import Initial
from models.problems import DesignError
from models.run import Run
from studio import palette
from studio.attitude import Quaternion, attitude_at, attitude_of, quaternion_about, rotate
from studio.bodies import breath, drawn_length
from studio.curves import MAX_POINTS, curve_samples
from studio.gizmo import Gizmo
from studio.guard import GuardedServer, make_server
from studio.outlook import outlook
from studio.palette import rgb
from studio.path_colors import scale_of
from studio.scene import LEVEL, GliderNodes, vehicle_extent, vehicle_length
from studio.scene_drag import PartMoves
from studio.scene_ghost import GhostNodes
from studio.scene_markers import Markers
from studio.session import Change, Session
from studio.water import WaterNodes, path_points, points_at, position_at, segment_colors

log = logging.getLogger(__name__)

Array = NDArray[np.float64]
Vector = tuple[float, float, float]

FIELD_OF_VIEW = np.deg2rad(32.0)
EXAGGERATION = 10.0
"""How much larger the cells' growth is drawn where the server moves them: strokes are a millimetre or two."""
CAMERAS = {
    # where the camera stands, in lengths of the vehicle from its middle: x forward, y to starboard, z down
    "side": (0.2, 2.1, -0.62),
    "top": (0.0, 0.02, -2.6),
    "chase": (-2.5, 0.0, -0.9),
    "free": (1.5, 1.9, -1.1),
}
FOG = (6.0, 42.0)
"""Where fog begins and hides, in lengths of the vehicle."""
FOG_OF_PATH = 2.0
"""Where it begins at least in the overview, in diagonals of the path's box."""
FRAMED_ANEW = 2.0
"""A vehicle so many times longer or shorter than the one that cameras and fog were set for has them set again."""
OVERVIEW = "overview"
VIEWS = (*CAMERAS, OVERVIEW)
NEAR, FAR = 0.01, 1000.0
NEAR_OFF = 0.5
"""Nothing is near in the overview; a metre away Viser keeps the background, which must not be cut off."""


class View:
    """What the browsers of one session see."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self._lock = threading.RLock()
        self.server: GuardedServer = make_server()
        self._drawn: Design | None = None
        self._drawn_run: tuple[Run, str | None] | None = None
        self._shown: Quaternion = LEVEL
        self._initial: Initial | None = None
        self._framed = vehicle_length(session.design)
        self._looking = ("side", 0.0)
        try:
            with self.server.atomic():
                self._build()
        except BaseException:
            self.server.stop()  # a design that cannot be drawn must not leave a server behind at each try
            raise
        self._unsubscribe = session.subscribe(self._changed)

    def _build(self) -> None:
        self._prepare_scene()
        self.moves = PartMoves(self.session, lambda: self._shown)
        self.glider = GliderNodes(self.server.scene, self._select, self.moves.drag)
        self.markers = Markers(self.server.scene)
        self.water = WaterNodes(self.server.scene)
        self.ghost = GhostNodes(self.server.scene)
        self.gizmo = Gizmo(self.server.scene, self.moves.drag_by_arrows)
        self._look("side")
        self._redraw()

    def close(self) -> None:
        """Stop following the session, and stop the server."""
        self._unsubscribe()
        self.server.stop()

    def camera(self, view: str, covered: float = 0.0) -> None:
        """Look from the side, the top, behind, freely, or at the whole path, in every browser of the session.

        `covered` is the share of the picture, from its top, that lies under the page's buttons.
        """
        self._framed, self._looking = vehicle_length(self.session.design), (view, covered)
        far_off = view == OVERVIEW
        points = self._path_and_around()
        size = float(np.linalg.norm(np.ptp(points, axis=0)))
        for client in self.server.get_clients().values():
            look_at, position = (
                outlook(points, float(FIELD_OF_VIEW), client.camera.aspect, covered)
                if far_off
                else self._camera_pose(view)
            )
            with client.atomic():
                client.scene.configure_fog(*self._fog(size if far_off else None), color=rgb(palette.FOG))
                client.camera.fov = FIELD_OF_VIEW
                client.camera.up_direction = (0.0, 0.0, -1.0)
                client.camera.near, client.camera.far = (NEAR_OFF, 10.0 * size) if far_off else (NEAR, FAR)
                client.camera.position = position
                client.camera.look_at = look_at

    def set_clock(self, t: float) -> None:
        """Show the glider at a time of the run; for pages that cannot move the nodes themselves."""
        run = self.session.run
        if run is None:
            return
        with self._lock, self.server.atomic():
            position = position_at(run, t)
            self._pose(position, attitude_at(run, t))
            self.ghost.place(t, position)
            self.markers.place_centers(run, t)
            self._move_parts(run, t)
        self.server.flush()

    def shown_at(self, attitude: Quaternion) -> None:
        """Hear from a page how it shows the glider turned: a part that is dragged there moves along those axes."""
        self._shown = attitude

    def _prepare_scene(self) -> None:
        scene, gui = self.server.scene, self.server.gui
        scene.set_up_direction("-z")
        scene.configure_default_lights(True, cast_shadow=False)
        scene.configure_fog(*self._fog(None), color=rgb(palette.FOG))
        scene.set_background_image(_gradient(palette.WATER_TOP, palette.WATER_BOTTOM), format="png")
        gui.configure_theme(dark_mode=True, show_logo=False, show_share_button=False, brand_color=(63, 167, 214))

    def _fog(self, size: float | None) -> tuple[float, float]:
        """Return where the water begins to hide things and where it does, m: further off for a path of some size."""
        length = vehicle_length(self.session.design)
        seen = FOG_OF_PATH * (0.0 if size is None else size)
        return max(FOG[0] * length, seen), max(FOG[1] * length, 7.0 * seen)

    def _look(self, view: str) -> None:
        camera = self.server.initial_camera
        look_at, position = self._camera_pose(view)
        camera.fov, camera.up = float(FIELD_OF_VIEW), (0.0, 0.0, -1.0)
        camera.position, camera.look_at = position, look_at
        camera.near, camera.far = NEAR, FAR

    def _path_and_around(self) -> Array:
        """Return points (n, 3) that the overview shows: the path, from the middle of its box, and a vehicle's length.

        The walls around a path that turns may reach beyond the picture: in a picture of them all it would be small.
        """
        run, length = self.session.run, vehicle_length(self.session.design)
        points = np.zeros((1, 3)) if run is None else path_points(run)
        middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
        return np.concatenate([points - middle, length * np.array(list(product((-1.0, 1.0), repeat=3)))])

    def _camera_pose(self, view: str) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        low, high = vehicle_extent(self.session.design)
        length = vehicle_length(self.session.design)
        x, y, z = CAMERAS[view]
        middle = (low + high) / 2.0
        return (middle, 0.0, 0.0), (middle + x * length, y * length, z * length)

    def _changed(self, _: Change) -> None:
        with self._lock, self.server.atomic():
            self._redraw()
        self.server.flush()

    def _redraw(self) -> None:
        """Draw the newest document and run; what has not changed sends nothing."""
        design, run = self.session.design, self.session.run
        self.glider.update(design, self.session.marks.hidden)
        if design is not self._drawn:
            self._drawn = design
            self.markers.update(design)
            self._frame_anew(vehicle_length(design))
        initial = design.mission.initial
        if initial != self._initial:  # else a part that is dragged would throw the glider back to the start
            self._initial = initial
            self._pose(initial.position, attitude_of(initial.roll, initial.pitch, initial.yaw))
        self.glider.tell(self.moves.label, vehicle_length(design))
        sideways = design.mission.solver.model == "spatial"
        self.gizmo.update(self.session.selected_component, vehicle_length(design), sideways=sideways)
        self._redraw_run(design, run)
        self.ghost.show(self.session.ghost)

    def _frame_anew(self, length: float) -> None:
        """Set fog and cameras for a vehicle of quite another size: another design was opened, not a part moved."""
        if 1.0 / FRAMED_ANEW < length / self._framed < FRAMED_ANEW:
            return
        self.server.scene.configure_fog(*self._fog(None), color=rgb(palette.FOG))
        self._look("side")
        self.camera(*self._looking)

    def _redraw_run(self, design: Design, run: Run | None) -> None:
        if run is None:
            self.water.frame_around(design, np.array([design.mission.initial.position]))
            return
        drawn = run, self.session.display.color_by
        if drawn == self._drawn_run:
            return
        self._drawn_run = drawn
        chosen = curve_samples(run, MAX_POINTS[run.model])
        points = points_at(run, chosen)
        self.water.show_path(points, segment_colors(run, chosen, scale_of(run, drawn[1])))
        self.water.frame_around(design, points)

    def _pose(self, position: Vector, attitude: Quaternion) -> None:
        """Let the water move past the glider, which stays in the middle of the scene."""
        x, y, z = position
        self.water.frame.position = (-x, -y, -z)
        self.glider.frame.wxyz = self._shown = attitude

    def _move_parts(self, run: Run, t: float) -> None:
        extensions = run.cell_values["extension"]
        for i, part in self.session.design.vehicle.actuated:
            if part.name not in run.cells:
                continue
            extension = float(np.interp(t, run.times, extensions[:, run.cells.index(part.name)]))
            stack, length = self.glider.stack(i), drawn_length(part)
            if isinstance(part, Mover):
                self.glider.place(i, *moved_to(part, extension))
            elif stack is not None and length is not None:
                stack.scale = breath(part, EXAGGERATION * (extension - part.neutral))

    def _select(self, index: int) -> None:
        try:
            self.session.select(index)
        except DesignError:
            log.debug("a part was clicked that is no longer there")


def moved_to(part: Actuated, extension: float) -> tuple[Vector, Quaternion]:
    """Return where a mass that slides or rolls is at an extension, and how it is turned, in body axes."""
    travel = extension - part.neutral
    if isinstance(part, RollingMass):
        turn, pivot = quaternion_about(part.axis, travel), np.array(part.pivot)
        x, y, z = (float(v) for v in pivot + rotate(np.array([part.position]) - pivot, turn)[0])
        return (x, y, z), turn
    along = travel / float(np.linalg.norm(part.axis))
    x, y, z = (p + along * a for p, a in zip(part.position, part.axis, strict=True))
    return (x, y, z), LEVEL


def _gradient(top: str, bottom: str) -> np.ndarray:
    """Return a small picture from one colour down to another, the background of the scene."""
    share = np.linspace(0.0, 1.0, 128)[:, None, None]
    colors = (1.0 - share) * np.array(rgb(top)) + share * np.array(rgb(bottom))
    return np.repeat(colors, 4, axis=1).round().astype(np.uint8)
