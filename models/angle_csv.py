"""Owns reading a table over angle of attack and sideslip from CSV: forces in N, moments in N m, body axes."""

from __future__ import annotations

import csv
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, Literal

import numpy as np

from models.hydrodynamics import Provenance
from models.hydrodynamics_angles import QUANTITIES, AngleTable
from models.profile_files import Samples, on_grid, plain_header, read_csv, validated

AXES = ("speed", "alpha_deg", "beta_deg")
COLUMNS = ("X", "Y", "Z", "K", "M", "N")
DECIMALS = 6
"""Angles and speeds that agree to these decimals are one."""
SPEED_HINT = 'pick one by speed=, or speed="mean"'


def holds_sideslip(path: Path | Traversable) -> bool:
    """Return whether the header of a CSV names a sideslip, so that its table is one over both angles."""
    with path.open(encoding="utf-8-sig") as lines:
        return "beta_deg" in plain_header(path.name, next(csv.reader(lines), []), ("beta_deg",))


def read_angle_table_csv(
    path: Path | Traversable, *, provenance: Provenance, speed: float | Literal["mean"] | None = None, **fields: Any
) -> AngleTable:
    """Read columns speed (m/s), alpha_deg, beta_deg, X, Y, Z (N), K, M, N (N m); rows in any order.

    Forces and moments are divided by the square of the speed. Of several speeds, `speed` picks one, or "mean" averages
    all; the moments' `reference_point`, density and other fields of `AngleTable` go into `fields`.

    Raises
    ------
    DesignError
        With line and column where something is missing or no number; by its angles where a point of the grid is there
        twice or not at all; with the speeds where none is picked; where the table breaks a rule of `AngleTable`.

    """
    samples = read_csv(path, (*AXES, *COLUMNS), axes=AXES)
    samples = Samples(
        samples.file,
        samples.places,
        {name: np.round(c, DECIMALS) if name in AXES else c for name, c in samples.columns.items()},
    )
    (_, alpha, beta), grids = on_grid(_at_speed(samples, speed), AXES)
    document = {"kind": "angle_table", "provenance": provenance, **fields}
    document |= {"alpha_deg": alpha.tolist(), "beta_deg": beta.tolist()}
    for name, column in zip(QUANTITIES, COLUMNS, strict=True):
        document[name] = grids[column].mean(axis=0).tolist()
    return validated(AngleTable, document, samples)


def _at_speed(samples: Samples, speed: float | Literal["mean"] | None) -> Samples:
    """Pick the rows of one speed, or of all; forces and moments per squared speed."""
    measured = samples.columns["speed"]
    if measured.min() <= 0:
        place = samples.places[int(np.argmin(measured))]
        raise samples.refuse(f"{place}, column speed: {measured.min():g} m/s", hint="speeds must be above 0")
    speeds = np.unique(measured)
    listed = ", ".join(f"{v:g}" for v in speeds)
    if speed is None and len(speeds) > 1:
        raise samples.refuse(f"{len(speeds)} speeds ({listed} m/s)", hint=SPEED_HINT)
    kept = np.ones(len(measured), dtype=bool)
    if speed is not None and speed != "mean":
        kept = measured == np.round(speed, DECIMALS)
    if not kept.any():
        raise samples.refuse(f"no row at {speed:g} m/s", hint=f"its speeds are {listed} m/s")
    columns = {
        name: (column / measured**2 if name in COLUMNS else column)[kept] for name, column in samples.columns.items()
    }
    return Samples(samples.file, tuple(p for p, keep in zip(samples.places, kept, strict=True) if keep), columns)
