"""Owns the mission: environment, initial state, control, duration and solver."""

from __future__ import annotations

import math
from typing import Literal

from models.components import Extension
from models.controllers import Controller
from models.environment import Environment
from models.fields import Description, Name, Rate3, Vector3, quantity, text, vector
from models.schedule import Schedule


class Initial(Description):
    """State at time zero."""

    position: Vector3 = vector(
        "Position of the body origin in the world (x forward, y right, z down; depth = z).",
        unit="m", symbol="p", default=(0.0, 0.0, 0.0),
    )  # fmt: skip
    roll: float = quantity("Roll angle.", unit="rad", symbol="phi", ge=-math.pi, le=math.pi, default=0.0)
    pitch: float = quantity("Pitch angle, nose up.", unit="rad", symbol="theta", ge=-math.pi, le=math.pi, default=0.0)
    yaw: float = quantity("Yaw angle.", unit="rad", symbol="psi", ge=-math.pi, le=math.pi, default=0.0)
    velocity: Rate3 = vector(
        "Velocity of the body origin in body axes, through the water.",
        unit="m/s", symbol="v", default=(0.0, 0.0, 0.0),
    )  # fmt: skip
    angular_velocity: Rate3 = vector(
        "Angular velocity in body axes.", unit="rad/s", symbol="omega", default=(0.0, 0.0, 0.0)
    )
    extensions: dict[Name, Extension] = vector(
        "Extensions by component name (angles in rad of a rolling mass); those not named start at neutral.",
        unit="m",
        symbol="e",
        default={},
    )


class Control(Description):
    """What the cells are told."""

    schedules: tuple[Schedule, ...] = text("Open-loop schedules, at most one a component.", default=())
    controller: Controller | None = text(
        "Closed loop over the cells that it names; those follow no schedule.", default=None
    )


class Solver(Description):
    """How the equations are integrated."""

    model: Literal["planar", "spatial"] = text(
        "Which equations: the paper's, in the vertical plane, or those of six degrees of freedom.", default="planar"
    )
    method: Literal["adaptive", "rk4"] = text(
        "Adaptive Dormand-Prince 5(4), or the classical Runge-Kutta method at a fixed step.", default="adaptive"
    )
    tolerance: float = quantity(
        "Error allowed in one step of the adaptive method, in m, rad, m/s and rad/s.",
        unit="1", symbol="tol", ge=1e-13, le=1e-1, default=1e-8,
    )  # fmt: skip
    step: float = quantity("Step of the fixed-step method.", unit="s", symbol="h", ge=1e-6, le=1e3, default=1e-3)
    output_interval: float = quantity(
        "Time between samples of the result.", unit="s", symbol="dt", ge=1e-5, le=1e6, default=0.05
    )


class Mission(Description):
    """One glide: where, from which state, with which commands, for how long."""

    environment: Environment = text("The water, its currents, gravity, surface and bed.", default=Environment())
    initial: Initial = text("State at time zero.", default=Initial())
    control: Control = text("Commands to the cells.", default=Control())
    duration: float = quantity("Length of the mission.", unit="s", symbol="t_end", gt=0.0, le=1e8)
    solver: Solver = text("How the equations are integrated.", default=Solver())
