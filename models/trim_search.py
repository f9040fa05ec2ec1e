"""Owns the search for all steady motions at given extensions: straight glides from a scan, turns from banked starts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.kernel.steady import EXTENSIONS, HEAVE, PITCH, ROLL, SURGE, SWAY, TURN
from models.operating_point import down_in_body
from models.problems import DesignError, Problem
from models.steady_problem import (
    ALL_LOADS,
    IN_PLANE,
    IN_PLANE_LOADS,
    IN_SPACE,
    SteadyProblem,
    upright,
)

Array = NDArray[np.float64]
SAME = 1e-6
"""Motions nearer than this are one: of the vector down, the velocity as a share of the speed, and turns per second."""
FINEST, COARSEST = math.radians(0.05), math.radians(30.0)
DEGREES = 180.0 / math.pi


@dataclass(frozen=True, slots=True)
class Search:
    """What is searched, rad: every `angle_step` of angle of attack all around; turns from every bank, to either side.

    Two straight glides within one step of angle, and turns that no banked start leads to, are not found.
    """

    angle_step: float = math.radians(2.0)
    banks: tuple[float, ...] = tuple(math.radians(bank) for bank in (10.0, 30.0, 60.0))

    def __post_init__(self) -> None:
        problems = []
        if not FINEST <= self.angle_step <= COARSEST:
            problems.append(
                Problem(
                    "/options/search/angle_step", f"a step of {self.angle_step * DEGREES:g} deg is not within "
                    f"{FINEST * DEGREES:g} to {COARSEST * DEGREES:g} deg",
                    limit=FINEST if not self.angle_step >= FINEST else COARSEST, hint="2 deg suit most gliders",
                )
            )  # fmt: skip
        for i, bank in enumerate(self.banks):
            if not 0.0 < bank < 0.5 * math.pi:
                problems.append(
                    Problem(
                        f"/options/search/banks/{i}", f"a bank of {bank * DEGREES:g} deg is not between 0 and 90 deg",
                        limit=0.0 if not bank > 0.0 else 0.5 * math.pi, hint="each is tried to either side",
                    )
                )  # fmt: skip
        if problems:
            raise DesignError(problems)


@dataclass(frozen=True)
class Found:
    """Steady motions (m, unknowns), and how many starts of how many led to one, by kind of start."""

    motions: Array
    straight: tuple[int, int]
    turning: tuple[int, int]


def search_motions(problem: SteadyProblem, search: Search) -> Found:
    """Return every steady motion that the search finds at the problem's extensions, the straight ones first."""
    seeds, met = straight_motions(problem, search.angle_step)
    straight = seeds[met]
    if not problem.spatial:
        return Found(_distinct(problem, straight), (len(straight), len(seeds)), (0, 0))
    whole = straight[problem.lateral_balance(straight)]
    starts = banked_starts(problem, straight, search.banks)
    if len(whole) < len(straight):
        starts = np.concatenate([straight, starts])
    ended = problem.newton(starts, IN_SPACE, ALL_LOADS)
    motions = np.concatenate([whole, starts[ended]])
    kept = _distinct(problem, motions)
    return Found(kept, (len(straight), len(seeds)), (int(ended.sum()), len(starts)))


def straight_motions(problem: SteadyProblem, step: float) -> tuple[Array, NDArray[np.bool_]]:
    """Return the straight glides in the plane of symmetry: starts where the moment changes sign, and which hold."""
    count = math.ceil(2.0 * math.pi / step)
    alphas = np.linspace(-math.pi, math.pi, count + 1) + math.pi / count
    moment = problem.balanced_along(alphas, problem.extensions)[:, 2]
    changes = np.flatnonzero((moment[:-1] * moment[1:] < 0.0) | ((moment[:-1] == 0.0) & (moment[1:] != 0.0)))
    share = moment[changes] / (moment[changes] - moment[changes + 1])
    angles = np.asarray(alphas[changes] + share * (alphas[changes + 1] - alphas[changes]), dtype=np.float64)
    seeds = motions_at(problem, angles, problem.extensions)
    return seeds, problem.newton(seeds, IN_PLANE, IN_PLANE_LOADS)


def motions_at(problem: SteadyProblem, alphas: Array, extensions: Array) -> Array:
    """Return the straight glides at angles of attack (m,) in which the forces balance, and maybe not the moment."""
    motions = np.zeros((len(alphas), EXTENSIONS + len(extensions)))
    motions[:, EXTENSIONS:] = extensions
    if len(alphas):
        found = problem.balanced_along(alphas, extensions)
        motions[:, PITCH] = found[:, 1]
        motions[:, SURGE], motions[:, HEAVE] = found[:, 0] * np.cos(alphas), found[:, 0] * np.sin(alphas)
    return motions


def banked_starts(problem: SteadyProblem, straight: Array, banks: tuple[float, ...]) -> Array:
    """Return starts of turns: each straight glide, banked to either side, turning as its lift would make it.

    m V cos(gamma) Omega = L sin(phi) with L = W cos(gamma): Omega = W tan(phi) / (m V), W the net weight and m with the
    water that moves along.
    """
    if not len(straight) or not banks:
        return np.zeros((0, straight.shape[1]))
    tilts = np.array([sign * bank for bank in banks for sign in (1.0, -1.0)])
    starts = np.repeat(straight, len(tilts), axis=0)
    roll = np.tile(tilts, len(straight))
    mass = float(problem.params.space[0]["mass"]) + float(problem.params.added[1, 1])
    speed = np.maximum(np.linalg.norm(starts[:, SURGE : HEAVE + 1], axis=1), 1e-3)
    starts[:, TURN] = np.clip(problem.net_weight * np.tan(roll) / (mass * speed), -0.5, 0.5)
    starts[:, ROLL] += roll
    return starts


def _distinct(problem: SteadyProblem, motions: Array) -> Array:
    """Return the motions upright and without repetitions."""
    if not len(motions):
        return motions
    raised = np.array([upright(s) if problem.spatial else s for s in motions])
    speed = np.linalg.norm(raised[:, SURGE : HEAVE + 1], axis=1)
    velocity = raised[:, [SURGE, SWAY, HEAVE]]
    marks = np.column_stack([np.array([down_in_body(s[ROLL], s[PITCH]) for s in raised]), raised[:, TURN]])
    kept: list[int] = []
    for i in range(len(raised)):
        near = [
            k for k in kept
            if np.abs(marks[i] - marks[k]).max() < SAME and np.abs(velocity[i] - velocity[k]).max() < SAME * speed[i]
        ]  # fmt: skip
        if not near:
            kept.append(i)
    return np.asarray(raised[kept], dtype=np.float64)
