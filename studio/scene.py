"""Owns the vehicle in the 3D scene: its parts and cells, rebuilt only where they changed, and its size.

World and body axes are the physics' own (x forward, y to starboard, z down): positions and quaternions go unchanged.
`/world` holds what is fixed in the water, `/glider` the vehicle; by default the glider stays put and the water moves.
"""

from __future__ import annotations

from collections.abc import Callable, Container
from typing import Any

import viser

from models.components import Component
from models.design import Design
from models.memory import remembered
from studio.attitude import Quaternion
from studio.bodies import Body, bodies, drawn_extent, extent
from studio.meshes import Mesh
from studio.palette import component_colors, rgb
from studio.scene_drag import MODIFIERS

Listener = Callable[[int], None]
DragListener = Callable[[int, Any], None]

Vector = tuple[float, float, float]

LEVEL = (1.0, 0.0, 0.0, 0.0)


class PartNodes:
    """The nodes of one component: `/glider/part<i>` for what does not grow, `/glider/cell<i>/stack` for what does."""

    def __init__(self, scene: viser.SceneApi, index: int, on_click: Listener, on_drag: DragListener) -> None:
        self._scene, self._index, self._on_click, self._on_drag = scene, index, on_click, on_drag
        self._drawn: tuple[tuple[Body, ...], str] | None = None
        self._frame: Any = None
        self._placed: tuple[Vector, Quaternion] | None = None
        self.stack: Any = None

    def show(self, component: Component, color: str, *, hidden: bool) -> None:
        """Draw the component, anew only where its bodies or colour changed; or have it there unseen."""
        wanted = bodies(component), color
        if wanted != self._drawn:
            self.remove()
            self._build(*wanted)
            self._drawn = wanted
        self.place(component.position, LEVEL)
        if self._frame.visible == hidden:
            self._frame.visible = not hidden

    @property
    def position(self) -> Vector:
        """Where the component is in the vehicle."""
        x, y, z = (float(v) for v in self._frame.position)
        return x, y, z

    def place(self, position: Vector, attitude: Quaternion) -> None:
        """Put the component somewhere else in the vehicle: a mass that slid or turned."""
        before, self._placed = self._placed or (None, None), (position, attitude)
        if position != before[0]:
            self._frame.position = position
        if attitude != before[1]:
            self._frame.wxyz = attitude

    def remove(self) -> None:
        """Take the component out of the scene."""
        if self._frame is not None:
            self._frame.remove()
        self._frame = self.stack = self._drawn = self._placed = None

    def _build(self, wanted: tuple[Body, ...], color: str) -> None:
        kind = "cell" if any(body.grows for body in wanted) else "part"
        root = f"/glider/{kind}{self._index}"
        self._frame = self._scene.add_frame(root, show_axes=False)
        for k, body in enumerate(wanted):
            name = "stack" if body.grows else f"shape{k}"
            mesh = add_mesh(self._scene, f"{root}/{name}", body.mesh, color, opacity=body.opacity)
            mesh.position, mesh.wxyz = body.offset, body.attitude
            if body.opacity is None:  # what is see-through must not catch clicks meant for what is inside
                self._listen(mesh)
            if body.grows:
                self.stack = mesh

    def _listen(self, mesh: Any) -> None:
        mesh.on_click(lambda _: self._on_click(self._index))

        async def dragged(event: Any) -> None:  # a coroutine keeps the order of a drag's phases
            self._on_drag(self._index, event)

        for modifier in MODIFIERS:
            mesh.on_drag("left", modifier=modifier)(dragged)


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

    def __init__(self, scene: viser.SceneApi, on_select: Listener, on_drag: DragListener) -> None:
        self._scene, self._on_select, self._on_drag = scene, on_select, on_drag
        self.frame = scene.add_frame("/glider", show_axes=False)
        self._parts: list[PartNodes] = []
        self._label: Any = None

    def update(self, design: Design, hidden: Container[str] = ()) -> None:
        """Draw this design's components, but for those whose names are hidden."""
        components = design.vehicle.components
        while len(self._parts) > len(components):
            self._parts.pop().remove()
        while len(self._parts) < len(components):
            self._parts.append(PartNodes(self._scene, len(self._parts), self._on_select, self._on_drag))
        for nodes, component, color in zip(self._parts, components, component_colors(components), strict=True):
            nodes.show(component, color, hidden=component.name in hidden)

    def tell(self, label: tuple[int, str] | None, length: float) -> None:
        """Write a few words above a component, or none."""
        if label is None or label[0] >= len(self._parts):
            if self._label is not None:
                self._label.remove()
                self._label = None
            return
        index, text = label
        x, y, z = self._parts[index].position
        place = (x, y, z - 0.09 * length)
        if self._label is None:
            self._label = self._scene.add_label("/glider/told", text, position=place, anchor="bottom-center")
        self._label.text, self._label.position = text, place

    def stack(self, index: int) -> Any:
        """Return the growing body of component `index`, or None."""
        return self._parts[index].stack if index < len(self._parts) else None

    def place(self, index: int, position: Vector, attitude: Quaternion) -> None:
        """Put component `index` somewhere else in the vehicle: a mass that slid or turned."""
        if index < len(self._parts):
            self._parts[index].place(position, attitude)


@remembered(most=16)
def vehicle_extent(design: Design) -> tuple[float, float]:
    """Return the smallest and largest x at which the vehicle is drawn, m."""
    reach = [(c.position[0], drawn_extent(c)) for c in design.vehicle.components]
    return min(x + e[0] for x, e in reach), max(x + e[1] for x, e in reach)


def vehicle_length(design: Design) -> float:
    """Return the length of the drawn vehicle, m; a little where nothing has a size."""
    low, high = vehicle_extent(design)
    return max(high - low, 0.05)


@remembered(most=16)
def half_width(design: Design) -> float:
    """Return how far the vehicle reaches to starboard, wings and fins apart, m."""
    reach = [
        c.position[1] + extent(body)[1][1]
        for c in design.vehicle.components
        for body in bodies(c)
        if body.kind not in ("wing", "fin")
    ]
    return max(reach, default=0.0)
