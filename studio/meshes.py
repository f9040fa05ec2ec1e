"""Owns the triangle meshes of what is drawn: vertices (n, 3) in metres and faces (m, 3), normals outwards.

Bodies of revolution lie along +x. A profile point given twice makes a sharp edge: the two rings share no face.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SECTIONS = 48
ARC = np.deg2rad(250.0)
"""How far a moment's arrow goes round."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles of one closed surface."""

    vertices: Array
    faces: NDArray[np.int32]


def revolve(x: Array, radius: Array, *, sections: int = SECTIONS) -> Mesh:
    """Turn a profile with rising x (n,) and its radii (n,) about the x axis; ends of radius 0 close the surface."""
    angle = np.linspace(0.0, 2.0 * np.pi, sections, endpoint=False)
    ring = np.stack([np.zeros(sections), np.cos(angle), np.sin(angle)], axis=1)
    vertices = np.concatenate([np.array([xi, 0.0, 0.0]) + ri * ring for xi, ri in zip(x, radius, strict=True)])
    here = np.arange(sections)
    following = (here + 1) % sections
    faces = []
    for k in range(len(x) - 1):
        if x[k] == x[k + 1] and radius[k] == radius[k + 1]:
            continue
        a, b = k * sections, (k + 1) * sections
        if radius[k] > 0.0:
            faces.append(np.stack([a + here, a + following, b + here], axis=1))
        if radius[k + 1] > 0.0:
            faces.append(np.stack([b + here, a + following, b + following], axis=1))
    return Mesh(vertices, np.concatenate(faces).astype(np.int32))


def _sharp(*points: tuple[float, float]) -> tuple[Array, Array]:
    """Return a profile whose inner corners are all sharp."""
    first, *inner, last = points
    doubled = np.array([first, *(p for corner in inner for p in (corner, corner)), last])
    return doubled[:, 0], doubled[:, 1]


def hull(length: float, radius: float, *, nose_length: float, tail_length: float) -> Mesh:
    """Return a hull of revolution about the origin, nose to +x: elliptic nose, cylinder, elliptic tail."""
    ends = nose_length + tail_length
    squeeze = min(1.0, length / ends) if ends > 0.0 else 1.0
    nose, tail = nose_length * squeeze, tail_length * squeeze
    turn = np.linspace(0.0, np.pi / 2.0, 20)
    aft, fore = -length / 2.0, length / 2.0
    tail_x, tail_r = aft + tail * (1.0 - np.cos(turn)), radius * np.sin(turn)
    nose_x, nose_r = fore - nose * (1.0 - np.cos(turn[::-1])), radius * np.sin(turn[::-1])
    middle = np.linspace(aft + tail, fore - nose, 12)[1:-1] if fore - nose > aft + tail else np.zeros(0)
    x = np.concatenate([tail_x, middle, nose_x])
    r = np.concatenate([tail_r, np.full(len(middle), radius), nose_r])
    return revolve(x, r)


def cylinder(length: float, radius: float) -> Mesh:
    """Return a cylinder from x = 0 to x = length."""
    return revolve(*_sharp((0.0, 0.0), (0.0, radius), (length, radius), (length, 0.0)))


def bellows(length: float, inner_radius: float, outer_radius: float, *, pleats: int) -> Mesh:
    """Return a pleated body from x = 0 to x = length: each pleat is two frustums, valley to crest to valley."""
    stations = np.linspace(0.0, length, 2 * pleats + 1)
    pleated = [(float(x), inner_radius if k % 2 == 0 else outer_radius) for k, x in enumerate(stations)]
    return revolve(*_sharp((0.0, 0.0), *pleated, (length, 0.0)))


def ellipsoid(length: float, radius: float) -> Mesh:
    """Return an ellipsoid of revolution from x = 0 to x = length."""
    turn = np.linspace(0.0, np.pi, 33)
    r = radius * np.sin(turn)
    r[[0, -1]] = 0.0
    return revolve(length / 2.0 * (1.0 - np.cos(turn)), r)


def wing(span: float, chord: float, *, tip_chord: float, sweep: float, thickness: float) -> Mesh:
    """Return a flat wing about the middle of its root chord: a plate port and starboard, leading edge to +x."""
    tip_lead = chord / 2.0 - sweep
    outline = [(tip_lead, -span / 2.0), (chord / 2.0, 0.0), (tip_lead, span / 2.0)]
    outline += [(tip_lead - tip_chord, span / 2.0), (-chord / 2.0, 0.0), (tip_lead - tip_chord, -span / 2.0)]
    return _plate(outline, [(0, 5, 4), (0, 4, 1), (1, 4, 3), (1, 3, 2)], thickness)


def fin(span: float, chord: float, *, tip_chord: float, sweep: float, thickness: float) -> Mesh:
    """Return a flat panel from the middle of its root chord outwards along +y, leading edge to +x."""
    tip_lead = chord / 2.0 - sweep
    outline = [(chord / 2.0, 0.0), (tip_lead, span), (tip_lead - tip_chord, span), (-chord / 2.0, 0.0)]
    return _plate(outline, [(0, 3, 2), (0, 2, 1)], thickness)


def _plate(outline: list[tuple[float, float]], triangles: list[tuple[int, int, int]], thickness: float) -> Mesh:
    """Return a plate: an outline in x and y, seen from above (-z) in the sense that its triangles have."""
    flat, count = np.array(outline), len(outline)
    upper = np.column_stack([flat, np.full(count, -thickness / 2.0)])
    lower = np.column_stack([flat, np.full(count, thickness / 2.0)])
    plate = np.array(triangles)
    k = np.arange(count)
    n = (k + 1) % count
    # the edges have vertices of their own, so that they stay sharp
    a, b = 2 * count, 3 * count
    edge = np.concatenate([np.stack([a + k, a + n, b + k], 1), np.stack([b + k, a + n, b + n], 1)])
    faces = np.concatenate([plate, plate[:, ::-1] + count, edge])
    return Mesh(np.concatenate([upper, lower, upper, lower]), faces.astype(np.int32))


def arrow() -> Mesh:
    """Return an arrow of unit length from the origin along +x."""
    return revolve(*_sharp((0.0, 0.0), (0.0, 0.03), (0.74, 0.03), (0.74, 0.075), (1.0, 0.0)), sections=20)


def rod(radius: float) -> Mesh:
    """Return a rod of unit length from the origin along +x."""
    return revolve(*_sharp((0.0, 0.0), (0.0, radius), (1.0, radius), (1.0, 0.0)), sections=12)


def arc() -> Mesh:
    """Return an arrow bent about the x axis at radius 1, in the sense of a right-handed turn."""
    shaft, head = np.linspace(0.0, 0.86, 29), np.linspace(0.86, 1.0, 9)
    begin = [(0.0, 0.0), *((float(x), 0.055) for x in shaft)]
    profile = [begin[0], *(p for p in begin[1:2] for _ in (0, 1)), *begin[2:-1]]
    profile += [begin[-1], begin[-1], (0.86, 0.15), (0.86, 0.15)]
    profile += [(float(x), 0.15 * float(1.0 - (x - 0.86) / 0.14)) for x in head[1:]]
    straight = revolve(*np.array(profile).T, sections=14)
    along, out, aside = straight.vertices.T
    angle = ARC * (along - 0.5) - np.pi / 2.0  # its gap below: z points down
    bent = np.column_stack([-aside, (1.0 + out) * np.cos(angle), (1.0 + out) * np.sin(angle)])
    return Mesh(bent, straight.faces)


def sphere(radius: float) -> Mesh:
    """Return a sphere about the origin."""
    ball = ellipsoid(2.0 * radius, radius)
    return Mesh(ball.vertices - np.array([radius, 0.0, 0.0]), ball.faces)


def ring(radius: float, tube: float) -> Mesh:
    """Return a torus about the origin whose axis is y: seen from the side it is a circle."""
    around = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    across = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    u, v = np.meshgrid(around, across, indexing="ij")
    distance = radius + tube * np.cos(v)
    vertices = np.stack([distance * np.cos(u), tube * np.sin(v), distance * np.sin(u)], axis=-1).reshape(-1, 3)
    i, j = (index.ravel() for index in np.meshgrid(np.arange(40), np.arange(12), indexing="ij"))
    corner = [(i + di) % 40 * 12 + (j + dj) % 12 for di, dj in ((0, 0), (1, 0), (0, 1), (1, 1))]
    faces = np.concatenate(
        [np.stack([corner[0], corner[2], corner[1]], 1), np.stack([corner[1], corner[2], corner[3]], 1)]
    )
    return Mesh(vertices, faces.astype(np.int32))


def both_sides(mesh: Mesh, distance: float) -> Mesh:
    """Return a mesh twice, at a distance to port and to starboard."""
    aside = np.array([0.0, distance, 0.0])
    vertices = np.concatenate([mesh.vertices - aside, mesh.vertices + aside])
    return Mesh(vertices, np.concatenate([mesh.faces, mesh.faces + len(mesh.vertices)]).astype(np.int32))


def joined(meshes: Sequence[Mesh]) -> Mesh:
    """Return several meshes as one."""
    first = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, first, strict=False)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces).astype(np.int32))


def sheet(x: tuple[float, float], y: tuple[float, float]) -> Mesh:
    """Return a horizontal rectangle at z = 0."""
    vertices = np.array([(x[0], y[0], 0.0), (x[1], y[0], 0.0), (x[1], y[1], 0.0), (x[0], y[1], 0.0)])
    return Mesh(vertices, np.array([(0, 1, 2), (0, 2, 3)], dtype=np.int32))
