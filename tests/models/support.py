"""Owns what the physics tests share: small documents to edit, and the kernel called piece by piece."""

from __future__ import annotations

import copy
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly
from models.design import Design, parse_design
from models.kernel.integrate import PROGRESS, finish, integrate
from models.kernel.model import derivative, energies
from models.kernel.params import Params, Work, make_record, make_work
from models.kernel.step import make_dense, pair_step, rk4_step

Array = NDArray[np.float64]

PISTON: dict[str, Any] = {
    "kind": "piston", "name": "Piston", "mass": 0.05, "position": [0.15, 0.0, 0.0], "volume": 5e-5,
    "volume_range": [4e-5, 6e-5], "area": 1e-3,
}  # fmt: skip
"""A cell with stops at +-10 mm, neutral at 0."""

BODY: dict[str, Any] = {
    "kind": "rigid", "name": "Body", "mass": 0.95, "volume": 0.95e-3, "position": [-0.15 * 0.05 / 0.95, 0.0, 0.0],
    "center_of_mass": [-0.15 * 0.05 / 0.95, 0.0, 0.004], "inertia": {"xx": 0.005, "yy": 0.02, "zz": 0.02},
}  # fmt: skip
"""Balances the piston: with that at neutral, both centres lie below the origin."""


def polar(**changes: Any) -> dict[str, Any]:
    """A smooth table at 1 m/s, every 10 deg."""
    alpha = np.linspace(0.0, 90.0, 10)
    a = np.deg2rad(alpha)
    columns = {
        "row_speed": np.ones(10), "row_alpha_deg": alpha, "row_lift": 8.0 * np.sin(2 * a),
        "row_drag": 2.0 + 30.0 * np.sin(a) ** 2, "row_moment": -0.5 * np.sin(2 * a),
    }  # fmt: skip
    return {
        "kind": "polar_table",
        "provenance": {"title": "Made up", "source": "Smooth curves for tests."},
        **{name: values.tolist() for name, values in columns.items()},
        **changes,
    }


def document(*parts: dict[str, Any], body: dict[str, Any] = BODY, **mission: Any) -> dict[str, Any]:
    """A glider with a body and the given parts; by default one piston, 1 kg and neutral."""
    return copy.deepcopy({
        "format": "glider-design", "version": 1, "name": "Test glider",
        "vehicle": {
            "components": [body, *(parts or (PISTON,))],
            "mass_properties": {"kind": "composite"},
            "hydrodynamics": polar(),
            "damping": {"pitch": 0.02},
        },
        "mission": {
            "initial": {"position": [0.0, 0.0, 5.0], "pitch": -0.3, "velocity": [0.3, 0.0, 0.05]},
            "duration": 5.0,
            "solver": {},
            **mission,
        },
    })  # fmt: skip


def design_of(*parts: dict[str, Any], **mission: Any) -> Design:
    return parse_design(document(*parts, **mission))


def schedule(cell: str, *points: tuple[float, float] | tuple[float, float, str]) -> dict[str, Any]:
    rows = [(*point, "step")[:3] for point in points]
    return {"schedules": [{"cell": cell, "points": [{"time": t, "extension": e, "shape": s} for t, e, s in rows]}]}


def without_water(p: Params) -> Params:
    """The same vehicle without hydrodynamic forces or damping; its lift, drag and moment are exactly zero."""
    table = p.table.copy()
    table[:, 1:] = 0.0
    body = p.body.copy()
    for name in ("d11", "d33", "d55", "munk_in_table"):
        body[name] = 0.0
    return p._replace(table=table, body=body)


def still_work(p: Params, y: Array) -> Work:
    """Scratch arrays of a run whose actuators hold their extensions."""
    return make_work(len(y), len(p.parts))


def slope_at(p: Params, y: Array) -> Array:
    """dy/dt with the extensions held."""
    dy = np.zeros_like(y)
    derivative(0.0, y, p, still_work(p, y).drive, dy)
    return dy


def total_energy(p: Params, y: Array) -> float:
    kinetic, potential = energies(0.0, y, p)
    return float(kinetic + potential)


def fixed_steps(pair: bool, p: Params, y: Array, *, h: float, steps: int) -> Array:
    """Every state of `steps` steps of one size with the extensions held, (steps + 1, n)."""
    work = still_work(p, y)
    saved = [y.copy()]
    for i in range(steps):
        derivative(i * h, saved[-1], p, work.drive, work.k[0])
        (pair_step if pair else rk4_step)(i * h, h, saved[-1], p, work)
        saved.append(work.y1.copy())
    return np.array(saved)


def one_step_with_dense(pair: bool, p: Params, y: Array, h: float) -> tuple[Array, Array]:
    """The state after one step, and the polynomial between (4, n)."""
    work = still_work(p, y)
    derivative(0.0, y, p, work.drive, work.k[0])
    (pair_step if pair else rk4_step)(0.0, h, y, p, work)
    make_dense(pair, h, y, work)
    return work.y1, work.dense


class KernelRun(NamedTuple):
    code: int
    times: Array
    states: Array
    events: Array
    counts: NDArray[np.int64]


def run_kernel(
    assembly: Assembly, y: Array | None = None, *, p: Params | None = None, duration: float | None = None,
    max_steps: int = 1_000_000,
) -> KernelRun:  # fmt: skip
    """Integrate with another initial state, other constants or another length than the design's."""
    mission = assembly.design.mission
    solver = mission.solver
    length = mission.duration if duration is None else duration
    capacity = int(np.ceil(length / solver.output_interval)) + 2
    start = (assembly.initial_state if y is None else y).copy()
    record = make_record(capacity, len(start), 100, np.zeros(2))
    work = make_work(len(start), len(assembly.cells))
    code = integrate(
        solver.method == "adaptive", 0.0, length, solver.step, solver.output_interval, max_steps, start,
        assembly.params if p is None else p, work, record,
    )  # fmt: skip
    finish(record.control[PROGRESS], start, work, record)
    n, events = record.counts[:2]
    return KernelRun(int(code), record.times[:n], record.states[:n], record.events[:events], record.counts)


def observed_orders(errors: list[float]) -> Array:
    """Orders from errors at steps that halve each time."""
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
