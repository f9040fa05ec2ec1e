"""Owns the marks on the vehicle in the scene: forces, moments, centres of mass and buoyancy, and the overview's ball.

A page that plays a run gives arrows their direction and length; here they are made, hidden, and put where hull and wing
do not hide them. The centres stand beside the hull, port and starboard, for the same reason.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from models.design import Design
from models.mass_properties import initial_extensions, mass_balance
from models.run import Run
from studio import meshes, palette
from studio.bodies import x_axis_to
from studio.scene import add_mesh, half_width, vehicle_extent, vehicle_length

SHORTEST_ARROW = 1e-4
ARROWS = {"buoyancy": palette.BUOYANCY, "lift": palette.LIFT, "drag": palette.DRAG, "side": palette.SIDE}
"""The page's legend (static/tokens.css) names the forces in these colours too."""
MOMENTS = {"roll": (1.0, 0.0, 0.0), "pitch": (0.0, 1.0, 0.0), "yaw": (0.0, 0.0, 1.0)}
"""Moments and the body axes about which they are positive."""
SIDES = ("port", "starboard")


class Markers:
    """The nodes `/glider/arrow_…`, `/glider/moment_…`, `/glider/com`, `/glider/cob` and `/glider/beacon`."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._size: tuple[float, ...] | None = None
        self._arrows = [self._hidden(f"arrow_{name}", meshes.arrow(), color) for name, color in ARROWS.items()]
        self._moments = {name: self._hidden(f"moment_{name}", meshes.arc(), palette.MOMENT) for name in MOMENTS}
        for name, axis in MOMENTS.items():
            self._moments[name].wxyz = x_axis_to(axis)
        # where the glider is, for a page that shows the whole path and gives it its size
        self._hidden("beacon", meshes.sphere(1.0), palette.BEACON)
        self.centers: dict[str, Any] = {}

    def _hidden(self, name: str, mesh: meshes.Mesh, color: str) -> Any:
        node = add_mesh(self._scene, f"/glider/{name}", mesh, color)
        node.visible, node.scale = False, SHORTEST_ARROW
        return node

    def update(self, design: Design) -> None:
        """Put the marks where this design has room for them, and the centres where they are at the start."""
        low, high = vehicle_extent(design)
        size = (vehicle_length(design), half_width(design), low, high)
        if size != self._size:
            self._size = size
            self._stand_aside(*size)
            self._make_centers(size[0], size[1])
        balance = mass_balance(design.vehicle, initial_extensions(design))
        self.centers["com"].position = tuple(balance.center_of_mass.tolist())
        self.centers["cob"].position = tuple(balance.center_of_buoyancy.tolist())

    def place_centers(self, run: Run, t: float) -> None:
        """Put the centres where a run has them at a time."""
        for name, node in self.centers.items():
            columns = [run.values.get(f"{name}_{axis}") for axis in "xyz"]
            node.position = tuple(0.0 if c is None else float(np.interp(t, run.times, c)) for c in columns)

    def _stand_aside(self, length: float, half: float, low: float, high: float) -> None:
        """Let the arrows begin to starboard and above, where cameras stand: hull and wing would hide them."""
        side, above = half + 0.03 * length, 0.03 * length
        for arrow in self._arrows:
            arrow.position = (0.0, side, -above)
        self._moments["roll"].position = (high + 0.04 * length, 0.0, 0.0)
        self._moments["pitch"].position = ((low + high) / 2.0, side, 0.0)
        self._moments["yaw"].position = ((low + high) / 2.0, 0.0, -half - above)

    def _make_centers(self, length: float, half: float) -> None:
        side = half + 0.012 * length
        ball = meshes.both_sides(meshes.sphere(0.012 * length), side)
        ring = meshes.both_sides(meshes.ring(0.022 * length, 0.0035 * length), side)
        self.centers["com"] = add_mesh(self._scene, "/glider/com", ball, palette.CENTER_OF_MASS)
        self.centers["cob"] = add_mesh(self._scene, "/glider/cob", ring, palette.CENTER_OF_BUOYANCY)
        # children of the centre of buoyancy, where the way to the centre of mass begins
        for name, y in zip(SIDES, (-side, side), strict=True):
            line = add_mesh(self._scene, f"/glider/cob/offset_{name}", meshes.rod(0.004 * length), palette.OFFSET)
            line.position, line.scale, line.visible = (0.0, y, 0.0), SHORTEST_ARROW, False
