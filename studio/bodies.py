"""Owns how a component is drawn: its shapes, or for a cell without any a body sized from its volume."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from models.components import Actuated, Bellows, Bladder, Component, Mover, Piston, Rigid
from models.shapes import BellowsShape, CylinderShape, FinShape, HullShape, WingShape
from models.volumes import volume
from studio import meshes
from studio.attitude import Quaternion, attitude_of, rotate
from studio.meshes import Mesh

Vector = tuple[float, float, float]
SMALLEST_STRETCH = 0.2
DENSITY_OF_METAL = 7800.0
"""For the size of a mass that has no shape, kg/m3."""


@dataclass(frozen=True)
class Body:
    """One drawn body of a component: `offset` from the component's position, attitude, and what to draw.

    `grows` says that it is a cell's stack: it begins at `offset` and stretches along its own x axis.
    """

    kind: str
    sizes: tuple[float, ...]
    offset: Vector
    attitude: Quaternion
    grows: bool = False
    opacity: float | None = None

    @property
    def mesh(self) -> Mesh:
        """The body's triangles in its own axes."""
        return _mesh(self.kind, self.sizes)


@lru_cache(maxsize=256)
def _mesh(kind: str, sizes: tuple[float, ...]) -> Mesh:
    match kind:
        case "hull":
            return meshes.hull(sizes[0], sizes[1], nose_length=sizes[2], tail_length=sizes[3])
        case "wing":
            return meshes.wing(sizes[0], sizes[1], tip_chord=sizes[2], sweep=sizes[3], thickness=sizes[4])
        case "fin":
            return meshes.fin(sizes[0], sizes[1], tip_chord=sizes[2], sweep=sizes[3], thickness=sizes[4])
        case "bellows":
            return meshes.bellows(sizes[0], sizes[1], sizes[2], pleats=int(sizes[3]))
        case "ellipsoid":
            return meshes.ellipsoid(sizes[0], sizes[1])
        case _:
            return meshes.cylinder(sizes[0], sizes[1])


def x_axis_to(direction: Vector) -> Quaternion:
    """Return the rotation (w, x, y, z) that takes +x to a direction by the shortest way."""
    a = np.array(direction) / np.linalg.norm(direction)
    if a[0] < -1.0 + 1e-12:
        return 0.0, 0.0, 1.0, 0.0
    q = np.array([1.0 + a[0], 0.0, -a[2], a[1]])
    w, x, y, z = (float(v) for v in q / np.linalg.norm(q))
    return w, x, y, z


def _begin(offset: Vector, direction: Vector, length: float) -> Vector:
    """Return where a body centred at `offset` begins."""
    a = np.array(direction) / np.linalg.norm(direction)
    x, y, z = (float(v) for v in np.array(offset) - a * length / 2.0)
    return x, y, z


@lru_cache(maxsize=1024)
def bodies(component: Component) -> tuple[Body, ...]:
    """Return what to draw of a component."""
    cell = not isinstance(component, Rigid | Mover)
    if not component.shapes:
        default = None if isinstance(component, Rigid) else _default_body(component)
        return () if default is None else (default,)
    stack = next((k for k, s in enumerate(component.shapes) if isinstance(s, BellowsShape | CylinderShape)), -1)
    return tuple(_shape_body(shape, component, grows=cell and k == stack) for k, shape in enumerate(component.shapes))


def _shape_body(shape: object, component: Component, *, grows: bool) -> Body:
    along = (1.0, 0.0, 0.0) if isinstance(component, Rigid) else component.axis
    level = (1.0, 0.0, 0.0, 0.0)
    match shape:
        case HullShape():
            sizes: tuple[float, ...] = (shape.length, shape.radius, shape.nose_length, shape.tail_length)
            return Body("hull", sizes, shape.offset, level, opacity=0.5)
        case WingShape() | FinShape():
            tip = shape.chord if shape.tip_chord is None else shape.tip_chord
            sizes = (shape.span, shape.chord, tip, shape.sweep, shape.thickness)
            attitude = _outwards(shape.direction) if isinstance(shape, FinShape) else level
            return Body(shape.kind, sizes, shape.offset, attitude, opacity=0.7)
        case BellowsShape():
            sizes = (shape.length, shape.inner_radius, shape.outer_radius, float(shape.pleats))
            begin = _begin(shape.offset, along, shape.length)
            return Body("bellows", sizes, begin, x_axis_to(along), grows=grows)
        case CylinderShape():
            axis = along if grows else shape.axis
            begin = _begin(shape.offset, axis, shape.length)
            return Body("cylinder", (shape.length, shape.radius), begin, x_axis_to(axis), grows=grows)
        case _:
            raise TypeError(f"no drawing for {type(shape).__name__}")


def _outwards(direction: Vector) -> Quaternion:
    """Return the turn about x that takes a fin's span (+y) outwards."""
    return attitude_of(math.atan2(direction[2], direction[1]), 0.0, 0.0)


def _default_body(component: Actuated) -> Body:
    """Return a body of the cell's own volume at neutral extension (of its mass in metal for a mass that moves)."""
    kind: str
    sizes: tuple[float, ...]
    match component:
        case Bellows():
            r, R = component.inner_radius, component.outer_radius
            length = volume(component, component.neutral) / (math.pi / 3.0 * (r * r + r * R + R * R))
            kind, sizes = "bellows", (_drawable(length, R), r, R, float(min(component.pleats, 40)))
        case Piston():
            radius = math.sqrt(component.area / math.pi)
            kind, sizes = "cylinder", (_drawable(component.volume / component.area, radius), radius)
        case Bladder():
            radius = (3.0 * max(volume(component, component.neutral), 1e-9) / (8.0 * math.pi)) ** (1.0 / 3.0)
            kind, sizes = "ellipsoid", (4.0 * radius, radius)
        case _:  # a mass that moves
            radius = (max(component.mass, 1e-3) / DENSITY_OF_METAL / (4.0 * math.pi)) ** (1.0 / 3.0)
            kind, sizes = "cylinder", (4.0 * radius, radius)
    begin = _begin((0.0, 0.0, 0.0), component.axis, sizes[0])
    return Body(kind, sizes, begin, x_axis_to(component.axis), grows=not isinstance(component, Mover))


def _drawable(length: float, radius: float) -> float:
    """Keep a length that only a made-up area gives within sight: half to twenty radii."""
    return min(max(length, 0.5 * radius), 20.0 * radius)


def drawn_length(component: Component) -> float | None:
    """Return the length at which a cell's stack is drawn when neutral, m; None for what does not stretch."""
    return next((body.sizes[0] for body in bodies(component) if body.grows), None)


@lru_cache(maxsize=1024)
def pleat(component: Component) -> tuple[float, float, float] | None:
    """Return half the length of a drawn bellows' pleat, its depth and its outer radius, m; None for what has none."""
    body = next((body for body in bodies(component) if body.grows and body.kind == "bellows"), None)
    if body is None:
        return None
    length, inner, outer, pleats = body.sizes
    return length / (2.0 * pleats), outer - inner, outer


def breath(component: Component, growth: float) -> Vector:
    """Return how much larger a cell's stack is drawn along and across its axis when it grew by a length, m.

    The sides of a bellows' pleats keep their length, so that its pleats flatten as it stretches; a bladder swells all
    round; what slides only gets longer.
    """
    length = drawn_length(component)
    if length is None:
        return 1.0, 1.0, 1.0
    stretch = max(1.0 + growth / length, SMALLEST_STRETCH)
    folded = pleat(component)
    if isinstance(component, Bladder):
        wide = stretch = stretch ** (1.0 / 3.0)
    elif folded is not None:
        half, depth, radius = folded
        left = math.sqrt(max(half**2 * (1.0 - stretch**2) + depth**2, 0.0))
        wide = max((radius - depth + left) / radius, 1.0 - depth / radius)
        wide = min(wide, 1.0 + 0.5 * depth / radius)
    else:
        wide = 1.0
    return stretch, wide, wide


@lru_cache(maxsize=1024)
def drawn_extent(component: Component) -> tuple[float, float]:
    """Return how far forward and aft of its position a component is drawn: smallest and largest x, m."""
    reach = [extent(body) for body in bodies(component)]
    return min((low[0] for low, _ in reach), default=0.0), max((high[0] for _, high in reach), default=0.0)


@lru_cache(maxsize=1024)
def extent(body: Body) -> tuple[Vector, Vector]:
    """Return the smallest and largest coordinates of a body, relative to its component's position, m."""
    points = rotate(body.mesh.vertices, body.attitude) + np.array(body.offset)
    low, high = (tuple(float(v) for v in corner) for corner in (points.min(axis=0), points.max(axis=0)))
    return (low[0], low[1], low[2]), (high[0], high[1], high[2])
