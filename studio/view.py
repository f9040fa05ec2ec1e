"""Owns a session's view: its Viser server with scene and panel, redrawn from the session in one message at a time."""

from __future__ import annotations

import logging
import threading

import numpy as np

from models.design import Design
from models.problems import DesignError
from models.run import Run
from studio import palette
from studio.bodies import drawn_length
from studio.guard import GuardedServer, make_server
from studio.palette import rgb
from studio.panel.form import Form
from studio.scene import Gizmo, GliderNodes, pitch_quaternion, vehicle_extent, vehicle_length
from studio.session import Change, Session
from studio.water import WaterNodes, path_points

log = logging.getLogger(__name__)

FIELD_OF_VIEW = np.deg2rad(32.0)
EXAGGERATION = 10.0
"""How much larger the cells' growth is drawn where the server moves them: strokes are a millimetre or two."""
SMALLEST_STRETCH = 0.2
CAMERAS = {
    # where the camera stands, in lengths of the vehicle from its middle: x forward, y to starboard, z down
    "side": (0.2, 2.1, -0.62),
    "top": (0.0, 0.02, -2.6),
    "chase": (-2.4, 0.55, -0.8),
    "free": (1.5, 1.9, -1.1),
}


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

    def camera(self, view: str) -> None:
        """Look from the side, the top, behind, or freely, in every browser of the session."""
        look_at, position = self._camera_pose(view)
        for client in self.server.get_clients().values():
            with client.atomic():
                client.camera.fov = FIELD_OF_VIEW
                client.camera.up_direction = (0.0, 0.0, -1.0)
                client.camera.position = position
                client.camera.look_at = look_at

    def set_clock(self, t: float) -> None:
        """Show the glider at a time of the run; for pages that cannot move the nodes themselves."""
        run = self.session.run
        if run is None:
            return
        with self._lock, self.server.atomic():
            times = run.times

            def now(name: str) -> float:
                return float(np.interp(t, times, run.values[name]))

            self._pose(now("x"), now("z"), now("theta"))
            self.glider.centers["com"].position = (now("com_x"), 0.0, now("com_z"))
            self.glider.centers["cob"].position = (now("cob_x"), 0.0, now("cob_z"))
            self._stretch_cells(run, t)
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
        camera.near, camera.far = 0.01, 1000.0

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
            self._pose(initial.position[0], initial.position[2], initial.pitch)
        self.gizmo.update(self.session.selected_component, vehicle_length(design))
        if run is not None and run is not self._drawn_run:
            self._drawn_run = run
            points = path_points(run)
            self.water.show_path(points)
            self.water.frame_around(design, points)
        elif run is None:
            self.water.frame_around(design, np.array([design.mission.initial.position]))

    def _pose(self, x: float, z: float, theta: float) -> None:
        """Let the water move past the glider, which stays in the middle of the scene."""
        self.water.frame.position = (-x, 0.0, -z)
        self.glider.frame.wxyz = pitch_quaternion(theta)

    def _stretch_cells(self, run: Run, t: float) -> None:
        extensions = run.cell_values["extension"]
        for i, part in self.session.design.vehicle.actuated:
            stack, length = self.glider.stack(i), drawn_length(part)
            if stack is None or length is None or part.name not in run.cells:
                continue
            extension = float(np.interp(t, run.times, extensions[:, run.cells.index(part.name)]))
            stretch = 1.0 + EXAGGERATION * (extension - part.neutral) / length
            stack.scale = (max(stretch, SMALLEST_STRETCH), 1.0, 1.0)

    def _select(self, index: int) -> None:
        try:
            self.session.select(index)
        except DesignError:
            log.debug("a part was clicked that is no longer there")

    def _move_selected(self, position: tuple[float, float, float]) -> None:
        index = self.session.selected
        y = self.session.selected_component.position[1]
        place = [round(position[0], 5), y, round(position[2], 5)]
        try:
            self.session.set_field(f"/vehicle/components/{index}/position", place)
        except DesignError:
            log.debug("a dragged part was refused; the session tells why")


def _gradient(top: str, bottom: str) -> np.ndarray:
    """Return a small picture from one colour down to another, the background of the scene."""
    share = np.linspace(0.0, 1.0, 128)[:, None, None]
    colors = (1.0 - share) * np.array(rgb(top)) + share * np.array(rgb(bottom))
    return np.repeat(colors, 4, axis=1).round().astype(np.uint8)
