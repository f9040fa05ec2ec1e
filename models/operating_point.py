"""Owns operating points: where a glider is linearised, from a steady motion, an instant of a run, or plain numbers.

World z down, body axes x to the nose, y to starboard, z down; metres, radians, seconds. Velocities are through the
water, as an initial velocity is.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly
from models.attitude import quaternion_from_rpy_radians, rotation_of
from models.kernel import params, spatial_layout
from models.problems import DesignError, Problem, pointer_to
from models.run import Run

if TYPE_CHECKING:
    from models.trim import Trim

Array = NDArray[np.float64]
Triple = tuple[float, float, float]
STEEPEST = math.radians(89.9)
"""Pitch within 0.1 deg of straight up or down, from here on, has no roll and yaw of its own, rad."""
BEYOND_STOP = 1e-6
"""Share of the stroke by which an extension may lie beyond its stops, by rounding."""


@dataclass(frozen=True)
class OperatingPoint:
    """A state about which motion is linear where it is small.

    Depth in m; roll, pitch, yaw in rad; velocity u, v, w through the water in m/s and p, q, r in rad/s, body axes;
    extensions by name in m or rad, those not named being the design's initial ones; commands by name where they differ
    from the extensions; time in s, of which only a current in time asks.
    """

    depth: float = 0.0
    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0
    velocity: Triple = (0.0, 0.0, 0.0)
    angular_velocity: Triple = (0.0, 0.0, 0.0)
    extensions: Mapping[str, float] = field(default_factory=dict)
    commands: Mapping[str, float] = field(default_factory=dict)
    time: float = 0.0

    @classmethod
    def from_steady(
        cls, *, extensions: Mapping[str, float], pitch: float, velocity: Sequence[float], roll: float = 0.0,
        turn_rate: float = 0.0, depth: float = 0.0, yaw: float = 0.0,
    ) -> OperatingPoint:  # fmt: skip
        """Return the point of a straight glide, or of a turn about the vertical (rad/s, to the right)."""
        u, v, w = (float(value) for value in velocity)
        down = down_in_body(roll, pitch)
        p, q, r = (float(turn_rate * k) for k in down)
        return cls(float(depth), float(roll), float(pitch), float(yaw), (u, v, w), (p, q, r), dict(extensions))

    @classmethod
    def from_run(cls, run: Run, time: float) -> OperatingPoint:
        """Return the point of a run at a time, s: linear between the two samples about it, angles by the shorter way.

        A time before the first sample or after the last counts as that one. A command that jumps between two samples
        is found in between; roll and yaw too, where they do so as pitch passes the vertical.
        """
        at = float(np.clip(time, run.times[0], run.times[-1]))
        i = max(int(np.searchsorted(run.times, at, side="right")) - 1, 0)
        j = min(i + 1, len(run.times) - 1)
        share = (at - float(run.times[i])) / float(run.times[j] - run.times[i]) if run.times[j] > run.times[i] else 0.0
        a, b = _sample_of(run, i), _sample_of(run, j)
        b[1:4] = a[1:4] + _wrapped(b[1:4] - a[1:4])
        depth, roll, pitch, yaw, u, v, w, p, q, r = ((1.0 - share) * a + share * b).tolist()
        extensions, commands = (
            dict(zip(run.cells, ((1.0 - share) * rows[i] + share * rows[j]).tolist(), strict=True))
            for rows in (run.cell_values["extension"], run.cell_values["command"])
        )
        return cls(depth, roll, pitch, yaw, (u, v, w), (p, q, r), extensions, commands, at)

    @property
    def speed(self) -> float:
        """Speed through the water, m/s."""
        return math.hypot(*self.velocity)

    def as_dict(self) -> dict[str, Any]:
        """Return the point as a JSON object."""
        return {
            "depth": self.depth, "roll": self.roll, "pitch": self.pitch, "yaw": self.yaw,
            "velocity": list(self.velocity), "angular_velocity": list(self.angular_velocity),
            "extensions": dict(self.extensions), "commands": dict(self.commands), "time": self.time,
        }  # fmt: skip


def _sample_of(run: Run, i: int) -> Array:
    """Return depth, roll, pitch, yaw, velocity through the water and angular velocity at a sample of a run, (10,)."""
    at = {name: float(column[i]) for name, column in run.values.items()}
    angles = at.get("phi", 0.0), at["theta"], at.get("psi", 0.0)
    current = np.array([at.get("current_x", 0.0), at.get("current_y", 0.0), 0.0])
    carried = rotation_of(quaternion_from_rpy_radians(*angles)).T @ current
    velocity = np.array([at["u"], at.get("v", 0.0), at["w"]]) - carried
    return np.array([at["z"], *angles, *velocity, at.get("p", 0.0), at["q"], at.get("r", 0.0)])


def _wrapped(angles: Array) -> Array:
    """Return angles within a half turn, rad."""
    return np.array([math.remainder(angle, math.tau) for angle in angles])


def point_of(trim: Trim, *, heading: float = 0.0) -> OperatingPoint:
    """Return a trim as an operating point with a heading, rad."""
    return OperatingPoint.from_steady(
        extensions=trim.extensions, pitch=trim.pitch, velocity=tuple(trim.velocity.tolist()), roll=trim.roll,
        turn_rate=trim.turn_rate, depth=trim.depth, yaw=heading,
    )  # fmt: skip


def down_in_body(roll: float, pitch: float) -> Array:
    """Return the unit vector down in body axes, (3,)."""
    cp = math.cos(pitch)
    return np.array([-math.sin(pitch), cp * math.sin(roll), cp * math.cos(roll)])


def extensions_at(assembly: Assembly, point: OperatingPoint) -> Array:
    """Return the extensions in the order of the assembly's cells, (parts,) m or rad.

    Raises
    ------
    DesignError
        Where a name is unknown, or an extension is beyond its stops.

    """
    problems = [
        Problem(pointer_to("extensions", name), f"no component that moves is named '{name}'",
                hint=f"those are: {', '.join(assembly.cells) or 'none'}")
        for name in point.extensions if name not in assembly.cells
    ]  # fmt: skip
    first = int(assembly.params.space[0]["extensions"])
    values = assembly.initial_state[first : first + len(assembly.cells)].copy()
    for i, (cell, part) in enumerate(zip(assembly.cells, assembly.params.parts, strict=True)):
        values[i] = point.extensions.get(cell, values[i])
        low, high = float(part["stop_low"]), float(part["stop_high"])
        slack = BEYOND_STOP * (high - low)
        if not low - slack <= values[i] <= high + slack:
            problems.append(
                Problem(pointer_to("extensions", cell), f"{values[i]:.6g} is beyond the stops, {low:g} to {high:g}",
                        limit=high if values[i] > high else low, hint="stay within them")
            )  # fmt: skip
    if problems:
        raise DesignError(problems)
    return values


def minimal_state(assembly: Assembly, point: OperatingPoint) -> Array:
    """Return the kernel's minimal states and then the extensions of a point, as `models.kernel.linear` has them.

    Raises
    ------
    DesignError
        Where a spatial design's pitch is within 0.1 deg of straight up or down, or a planar one moves out of its plane.

    """
    extensions = extensions_at(assembly, point)
    (u, v, w), (p, q, r) = point.velocity, point.angular_velocity
    if assembly.params.space[0]["spatial"]:
        refuse_steep(point.pitch)
        return np.array([point.depth, point.roll, point.pitch, point.yaw, u, v, w, p, q, r, *extensions])
    out = {"roll": point.roll, "velocity/1": v, "angular_velocity/0": p, "angular_velocity/2": r}
    problems = [
        Problem(f"/{where}", f"a planar design stays in its plane: {value:.3g} is not 0", limit=0.0,
                hint="give 0, or choose the spatial model")
        for where, value in out.items() if value != 0.0
    ]  # fmt: skip
    if problems:
        raise DesignError(problems)
    return np.array([point.depth, point.pitch, u, w, q, *extensions])


def refuse_steep(pitch: float) -> None:
    """Raise `DesignError` where Euler angles fail: within 0.1 deg of straight up or down."""
    if abs(math.cos(pitch)) < math.cos(STEEPEST):
        message = f"pitch {math.degrees(pitch):.2f} deg: within 0.1 deg of straight up or down roll and yaw are one"
        limit = math.copysign(math.degrees(STEEPEST), pitch)
        raise DesignError([Problem("/pitch", message, limit=limit, hint="linearise at a shallower attitude")])


def minimal_of_state(assembly: Assembly, state: Array) -> Array:
    """Return the minimal states and the extensions of a state of the kernel (velocities over ground).

    Raises
    ------
    DesignError
        Where a spatial design's pitch is within 0.1 deg of straight up or down.

    """
    y, n = state, len(assembly.cells)
    if assembly.params.space[0]["spatial"]:
        first = spatial_layout.EXTENSIONS
        quaternion = y[spatial_layout.Q0 : spatial_layout.Q3 + 1]
        w, x, j, k = quaternion / np.linalg.norm(quaternion)
        pitch = math.asin(min(max(2.0 * (w * j - x * k), -1.0), 1.0))
        refuse_steep(pitch)
        roll = math.atan2(2.0 * (w * x + j * k), 1.0 - 2.0 * (x * x + j * j))
        yaw = math.atan2(2.0 * (w * k + x * j), 1.0 - 2.0 * (j * j + k * k))
        motion = y[spatial_layout.U : spatial_layout.R + 1]
        return np.array([y[spatial_layout.Z], roll, pitch, yaw, *motion, *y[first : first + n]])
    first = params.EXTENSIONS
    return np.array([y[j] for j in (params.Z, params.THETA, params.U, params.W, params.Q)] + [*y[first : first + n]])
