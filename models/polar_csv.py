"""Owns reading a table of forces from CSV: columns speed (m/s), alpha_deg, lift (N), drag (N), moment (N m)."""

from __future__ import annotations

import csv
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from models.hydrodynamics import PolarTable, Provenance
from models.problems import DesignError, Problem, problems_from_validation
from models.profile_files import plain_header

COLUMNS = ("speed", "alpha_deg", "lift", "drag", "moment")


def read_polar_csv(path: Path | Traversable, *, provenance: Provenance, **fields: Any) -> PolarTable:
    """Read a CSV with a header; further columns (deviations, residuals) are left alone. Units may follow the names.

    Lift is across the flow, drag along it, the moment nose up about `reference_point`: a field of `PolarTable`, like
    the law, the density of the measurement and whether the moment holds the Munk moment; give them in `fields`.

    Raises
    ------
    DesignError
        Where a column is missing, a cell is no number (with its line), or the table breaks a rule of `PolarTable`.

    """
    reader = csv.DictReader(path.read_text(encoding="utf-8-sig").splitlines())
    header = reader.fieldnames = plain_header(path.name, reader.fieldnames or (), COLUMNS)
    missing = [name for name in COLUMNS if name not in header]
    if missing:
        hint = f"wanted are {', '.join(COLUMNS)}; its header has {', '.join(header) or 'nothing'}"
        raise DesignError([Problem("", f"{path.name} lacks the columns {', '.join(missing)}", hint=hint)])
    columns: dict[str, list[float]] = {name: [] for name in COLUMNS}
    for row in reader:
        for name in COLUMNS:
            columns[name].append(_number(row[name], f"{path.name}, line {reader.line_num}, column {name}"))
    document = {"kind": "polar_table", "provenance": provenance, **fields}
    document |= {f"row_{name}": values for name, values in columns.items()}
    try:
        return PolarTable.model_validate(document)
    except ValidationError as error:
        raise DesignError(problems_from_validation(error, document)) from None


def _number(text: str | None, where: str) -> float:
    try:
        return float(text or "")
    except ValueError:
        raise DesignError([Problem("", f"{where}: {text!r} is not a number")]) from None
