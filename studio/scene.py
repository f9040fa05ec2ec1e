"""Owns the vehicle in the 3D scene: its parts, cells, markers and force arrows, rebuilt only where they changed.

World and body axes are the physics' own (x forward, y to starboard, z down): positions and quaternions go unchanged.
`/world` holds what is fixed in the water, `/glider` the vehicle; by default the glider stays put and the water moves.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import viser

from models.components import Component
from models.design import Design
from models.mass_properties import initial_extensions, mass_balance
from studio import meshes, palette
from studio.attitude import Quaternion
from studio.bodies import Body, bodies, drawn_extent, extent
from studio.meshes import Mesh
from studio.palette import component_colors, rgb

SHORTEST_ARROW = 1e-4
LEVEL = (1.0, 0.0, 0.0, 0.0)
ARROWS = {"buoyancy": palette.BUOYANCY, "lift": palette.LIFT, "drag": palette.DRAG, "side": palette.SIDE}
"""The page's legend (static/tokens.css) names the forces in these colours too."""


class PartNodes:
    """The nodes of one component: `/glider/part<i>` for what does not grow, `/glider/cell<i>/stack` for what does."""

    def __init__(self, scene: viser.SceneApi, index: int, on_click: Callable[[int], None]) -> None:
        self._scene, self._index, self._on_click = scene, index, on_click
        self._drawn: tuple[tuple[Body, ...], str] | None = None
        self._frame: Any = None
        self.stack: Any = None

    def show(self, component: Component, color: str) -> None:
        """Draw the component, anew only where its bodies or colour changed."""
        wanted = bodies(component), color
        if wanted != self._drawn:
            self.remove()
            self._build(*wanted)
            self._drawn = wanted
        self.place(component.position, LEVEL)

    def place(self, position: tuple[float, float, float], attitude: Quaternion) -> None:
        """Put the component somewhere else in the vehicle: a mass that slid or turned."""
        self._frame.position, self._frame.wxyz = position, attitude

    def remove(self) -> None:
        """Take the component out of the scene."""
        if self._frame is not None:
            self._frame.remove()
        self._frame = self.stack = self._drawn = None

    def _build(self, wanted: tuple[Body, ...], color: str) -> None:
        kind = "cell" if any(body.grows for body in wanted) else "part"
        root = f"/glider/{kind}{self._index}"
        self._frame = self._scene.add_frame(root, show_axes=False)
        for k, body in enumerate(wanted):
            name = "stack" if body.grows else f"shape{k}"
            mesh = add_mesh(self._scene, f"{root}/{name}", body.mesh, color, opacity=body.opacity)
            mesh.position, mesh.wxyz = body.offset, body.attitude
            if body.opacity is None:  # what is see-through must not catch clicks meant for what is inside
                mesh.on_click(lambda _: self._on_click(self._index))
            if body.grows:
                self.stack = mesh


def add_mesh(
    scene: viser.SceneApi, name: str, mesh: Mesh, color: str, *, opacity: float | None = None, one_sided: bool = False
) -> Any:
    """Add a mesh in one colour."""
    return scene.add_mesh_simple(
        name, mesh.vertices.astype("float32"), mesh.faces.astype("uint32"), color=rgb(color), opacity=opacity,
        side="front" if one_sided else "double", cast_shadow=False, receive_shadow=False,
    )  # fmt: skip


class GliderNodes:
    """The vehicle under `/glider`."""

    def __init__(self, scene: viser.SceneApi, on_select: Callable[[int], None]) -> None:
        self._scene, self._on_select = scene, on_select
        self.frame = scene.add_frame("/glider", show_axes=False)
        self._parts: list[PartNodes] = []
        self._length = 0.0
        self._arrows: list[Any] = []
        self.centers: dict[str, Any] = {}
        for name, color in ARROWS.items():
            # a page that plays a run gives each its direction and length
            arrow = add_mesh(scene, f"/glider/arrow_{name}", meshes.arrow(), color)
            arrow.visible = False
            arrow.scale = SHORTEST_ARROW
            self._arrows.append(arrow)
        # where the glider is, for a page that shows the whole path and gives it its size
        self._beacon = add_mesh(scene, "/glider/beacon", meshes.sphere(1.0), palette.BEACON)
        self._beacon.visible, self._beacon.scale = False, SHORTEST_ARROW

    def update(self, design: Design) -> None:
        """Draw this design's components, and its centres at the start."""
        components = design.vehicle.components
        while len(self._parts) > len(components):
            self._parts.pop().remove()
        while len(self._parts) < len(components):
            self._parts.append(PartNodes(self._scene, len(self._parts), self._on_select))
        for nodes, component, color in zip(self._parts, components, component_colors(components), strict=True):
            nodes.show(component, color)
        self._show_centers(design)

    def stack(self, index: int) -> Any:
        """Return the growing body of component `index`, or None."""
        return self._parts[index].stack if index < len(self._parts) else None

    def place(self, index: int, position: tuple[float, float, float], attitude: Quaternion) -> None:
        """Put component `index` somewhere else in the vehicle: a mass that slid or turned."""
        if index < len(self._parts):
            self._parts[index].place(position, attitude)

    def _stand_aside(self, side: float, above: float) -> None:
        """Let the force arrows begin to starboard and above, where cameras stand: hull and wing would hide them."""
        for arrow in self._arrows:
            arrow.position = (0.0, side, -above)

    def _show_centers(self, design: Design) -> None:
        length = vehicle_length(design)
        if length != self._length:
            self._length = length
            # beside the hull, port and starboard: on the axis itself hull and wing would hide them
            side = half_width(design) + 0.012 * length
            self._stand_aside(half_width(design) + 0.03 * length, 0.03 * length)
            ball = meshes.both_sides(meshes.sphere(0.012 * length), side)
            ring = meshes.both_sides(meshes.ring(0.022 * length, 0.0035 * length), side)
            self.centers["com"] = add_mesh(self._scene, "/glider/com", ball, palette.CENTER_OF_MASS)
            self.centers["cob"] = add_mesh(self._scene, "/glider/cob", ring, palette.CENTER_OF_BUOYANCY)
        balance = mass_balance(design.vehicle, initial_extensions(design))
        self.centers["com"].position = tuple(balance.center_of_mass.tolist())
        self.centers["cob"].position = tuple(balance.center_of_buoyancy.tolist())


def vehicle_extent(design: Design) -> tuple[float, float]:
    """Return the smallest and largest x at which the vehicle is drawn, m."""
    reach = [(c.position[0], drawn_extent(c)) for c in design.vehicle.components]
    return min(x + e[0] for x, e in reach), max(x + e[1] for x, e in reach)


def vehicle_length(design: Design) -> float:
    """Return the length of the drawn vehicle, m; a little where nothing has a size."""
    low, high = vehicle_extent(design)
    return max(high - low, 0.05)


def half_width(design: Design) -> float:
    """Return how far the vehicle reaches to starboard, wings and fins apart, m."""
    reach = [
        c.position[1] + extent(body)[1][1]
        for c in design.vehicle.components
        for body in bodies(c)
        if body.kind not in ("wing", "fin")
    ]
    return max(reach, default=0.0)
