"""Owns the ghost in the scene: the vehicle of a kept run as a translucent silhouette, and that run's path."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from models.components import Component
from models.run import Run
from studio import meshes, palette
from studio.attitude import attitude_at, rotate
from studio.bodies import bodies
from studio.grid import segments
from studio.kept_runs import KeptRun
from studio.meshes import Mesh
from studio.palette import rgb
from studio.scene import add_mesh
from studio.water import path_points, position_at

Array = NDArray[np.float64]

OPACITY = 0.34
LARGER = 1.012
"""A little larger than life: where both gliders are in one place their faces must not fight."""


@lru_cache(maxsize=8)
def silhouette(components: tuple[Component, ...]) -> Mesh:
    """Return all bodies of a vehicle with neutral cells as one mesh, in body axes."""
    drawn = []
    for component in components:
        for body in bodies(component):
            place = np.array(component.position) + np.array(body.offset)
            drawn.append(Mesh(rotate(body.mesh.vertices, body.attitude) + place, body.mesh.faces))
    return meshes.joined(drawn) if drawn else Mesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int32))


class GhostNodes:
    """`/ghost`, which a page moves like the glider, and `/world/ghost_path`; nothing where there is no ghost."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._shown: KeptRun | None = None
        self._nodes: list[Any] = []

    def show(self, kept: KeptRun | None) -> None:
        """Draw the ghost of a kept run, or none; one that is still to be computed has none."""
        if kept is self._shown:
            return
        for node in self._nodes:
            node.remove()
        self._nodes, self._shown = [], kept
        if kept is not None and kept.run is not None:
            self._build(kept.run, palette.KEPT[kept.place])

    def place(self, t: float, anchor: tuple[float, float, float]) -> None:
        """Show it where its own run has it at a time, in water that passes through the scene's middle at `anchor`."""
        if self._shown is None or self._shown.run is None:
            return
        frame, run = self._nodes[0], self._shown.run
        frame.position = tuple(p - a for p, a in zip(position_at(run, t), anchor, strict=True))
        frame.wxyz = attitude_at(run, t)

    def _build(self, run: Run, color: str) -> None:
        frame = self._scene.add_frame("/ghost", show_axes=False)
        vehicle = silhouette(run.design.vehicle.components)
        body = None
        if len(vehicle.vertices):
            body = add_mesh(self._scene, "/ghost/silhouette", vehicle, color, opacity=OPACITY)
            body.scale = LARGER
        path = self._scene.add_line_segments(
            "/world/ghost_path", segments(path_points(run)), rgb(color), thickness=1.5, thickness_units="screen"
        )
        self._nodes = [frame, path]  # the silhouette is the frame's child: it leaves the scene with it
