"""Owns a session's view: its Viser server with scene and panel, redrawn from the session in one message at a time."""

from __future__ import annotations

import logging
import threading

import numpy as np
from numpy.typing import NDArray

from models.components import Actuated, Mover, RollingMass
from models.design import Design
from models.problems import DesignError
from models.run import Run
from studio import palette
from studio.attitude import Quaternion, attitude_at, attitude_of, quaternion_about, rotate
from studio.bodies import drawn_length
from studio.gizmo import Gizmo
from studio.grid import room_box
from studio.guard import GuardedServer, make_server
from studio.outlook import outlook
from studio.palette import rgb
from studio.panel.form import Form
from studio.scene import LEVEL, GliderNodes, vehicle_extent, vehicle_length
from studio.session import Change, Session
from studio.water import WaterNodes, path_points

log = logging.getLogger(__name__)

Array = NDArray[np.float64]
Vector = tuple[float, float, float]

FIELD_OF_VIEW = np.deg2rad(32.0)
EXAGGERATION = 10.0
"""How much larger the cells' growth is drawn where the server moves them: strokes are a millimetre or two."""
SMALLEST_STRETCH = 0.2
CAMERAS = {
    # where the camera stands, in lengths of the vehicle from its middle: x forward, y to starboard, z down
    "side": (0.2, 2.1, -0.62),
    "top": (0.0, 0.02, -2.6),
    "chase": (-2.5, 0.0, -0.9),
    "free": (1.5, 1.9, -1.1),
}
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
        self._drawn_run: Run | None = None
        try:
            with self.server.atomic():
                self._build()
        except BaseException:
            self.server.stop()  # a design that cannot be drawn must not leave a server behind at each try
            raise
        self._unsubscribe = session.subscribe(self._changed)

    def _build(self) -> None:
        self._prepare_scene()
        self.glider = GliderNodes(self.server.scene, self._select)
        self.water = WaterNodes(self.server.scene)
        self.gizmo = Gizmo(self.server.scene, self._move_selected)
        self.form = Form(self.server.gui, self.session)
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
        far_off = view == OVERVIEW
        box = self._path_box()
        size = float(np.linalg.norm(box[1] - box[0]))
        for client in self.server.get_clients().values():
            look_at, position = (
                outlook(box, float(FIELD_OF_VIEW), client.camera.aspect, covered)
                if far_off
                else self._camera_pose(view)
            )
            with client.atomic():
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

            def now(name: str) -> float:
                return float(np.interp(t, run.times, run.values[name])) if name in run.values else 0.0

            self._pose((now("x"), now("y"), now("z")), attitude_at(run, t))
            for center in ("com", "cob"):
                place = (now(f"{center}_x"), now(f"{center}_y"), now(f"{center}_z"))
                self.glider.centers[center].position = place
            self._move_parts(run, t)
        self.server.flush()

    def _prepare_scene(self) -> None:
        scene, gui = self.server.scene, self.server.gui
        scene.set_up_direction("-z")
        scene.configure_default_lights(True, cast_shadow=False)
        scene.set_background_image(_gradient(palette.WATER_TOP, palette.WATER_BOTTOM), format="png")
        gui.configure_theme(dark_mode=True, show_logo=False, show_share_button=False, brand_color=(63, 167, 214))

    def _look(self, view: str) -> None:
        camera = self.server.initial_camera
        look_at, position = self._camera_pose(view)
        camera.fov, camera.up = float(FIELD_OF_VIEW), (0.0, 0.0, -1.0)
        camera.position, camera.look_at = position, look_at
        camera.near, camera.far = NEAR, FAR

    def _path_box(self) -> tuple[Array, Array]:
        """Return the corners (3,) of the box around the path and, where it turns, its walls; from the path's middle."""
        design, run = self.session.design, self.session.run
        length = vehicle_length(design)
        points = np.zeros((1, 3)) if run is None else path_points(run)
        low, high = points.min(axis=0), points.max(axis=0)
        middle = (low + high) / 2.0
        if high[1] - low[1] > length:
            low, high = room_box(points, length, design.mission.environment.bed_depth)
        return np.minimum(low - middle, -length), np.maximum(high - middle, length)

    def _camera_pose(self, view: str) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        low, high = vehicle_extent(self.session.design)
        length = vehicle_length(self.session.design)
        x, y, z = CAMERAS[view]
        middle = (low + high) / 2.0
        return (middle, 0.0, 0.0), (middle + x * length, y * length, z * length)

    def _changed(self, _: Change) -> None:
        with self._lock, self.server.atomic():
            self.form.update()
            self._redraw()
        self.server.flush()

    def _redraw(self) -> None:
        """Draw the newest document and run; what has not changed sends nothing."""
        design, run = self.session.design, self.session.run
        if design is not self._drawn:
            self._drawn = design
            self.glider.update(design)
            initial = design.mission.initial
            self._pose(initial.position, attitude_of(initial.roll, initial.pitch, initial.yaw))
        sideways = design.mission.solver.model == "spatial"
        self.gizmo.update(self.session.selected_component, vehicle_length(design), sideways=sideways)
        if run is not None and run is not self._drawn_run:
            self._drawn_run = run
            points = path_points(run)
            self.water.show_path(points)
            self.water.frame_around(design, points)
        elif run is None:
            self.water.frame_around(design, np.array([design.mission.initial.position]))

    def _pose(self, position: Vector, attitude: Quaternion) -> None:
        """Let the water move past the glider, which stays in the middle of the scene."""
        x, y, z = position
        self.water.frame.position = (-x, -y, -z)
        self.glider.frame.wxyz = attitude

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
                stretch = 1.0 + EXAGGERATION * (extension - part.neutral) / length
                stack.scale = (max(stretch, SMALLEST_STRETCH), 1.0, 1.0)

    def _select(self, index: int) -> None:
        try:
            self.session.select(index)
        except DesignError:
            log.debug("a part was clicked that is no longer there")

    def _move_selected(self, position: Vector) -> None:
        index = self.session.selected
        place = [round(v, 5) for v in position]
        if self.session.design.mission.solver.model == "planar":
            place[1] = self.session.selected_component.position[1]
        try:
            self.session.set_field(f"/vehicle/components/{index}/position", place)
        except DesignError:
            log.debug("a dragged part was refused; the session tells why")


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
