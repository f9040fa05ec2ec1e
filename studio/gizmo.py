"""Owns the arrows in the scene that move the selected component."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import viser

from models.components import Component
from studio.bodies import bodies, extent

Vector = tuple[float, float, float]


class Gizmo:
    """Arrows above the selected component that move it along the body's x and z axes, and along y in three dimensions.

    A child of `/glider`: what it reports is in body axes whatever attitude a page shows. It stands clear of the
    component, for a part that can be clicked would take the pointer from it.
    """

    UPSIDE_DOWN = (0.0, 1.0, 0.0, 0.0)

    def __init__(self, scene: viser.SceneApi, on_move: Callable[[str, Vector], None]) -> None:
        self._scene, self._on_move = scene, on_move
        self._handle: Any = None
        self._made: tuple[float, bool] | None = None
        self._clearance = 0.0
        self._dragging = False

    def update(self, component: Component, length: float, *, sideways: bool) -> None:
        """Put it on a component of a vehicle of this length; while it is dragged it stays with the pointer."""
        wanted = round(0.14 * length, 2), sideways
        if wanted != self._made:
            self._make(*wanted)
        if not self._dragging:
            x, y, z = component.position
            top = min((extent(body)[0][2] for body in bodies(component)), default=0.0)
            self._clearance = 0.03 * length - top
            self._handle.position = (x, y, z - self._clearance)

    def _make(self, scale: float, sideways: bool) -> None:
        if self._handle is not None:
            self._handle.remove()
        self._made = scale, sideways
        self._handle = self._scene.add_transform_controls(
            "/glider/gizmo", scale=scale, active_axes=(True, sideways, True), disable_sliders=True,
            disable_rotations=True, depth_test=False, line_width=2.0, opacity=0.9, wxyz=self.UPSIDE_DOWN,
        )  # fmt: skip
        # coroutines keep the order of a drag's phases
        self._handle.on_update(self._moved)

    async def _moved(self, event: Any) -> None:
        if event.client is None:
            return
        self._dragging = event.phase != "end"
        x, y, z = (float(v) for v in event.target.position)
        self._on_move(event.phase, (x, y, z + self._clearance))
