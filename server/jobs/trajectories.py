"""Owns the kept trajectories of a chunk as NetCDF 4: a contiguous ragged array of the CF conventions (H.4.3).

The samples of all kept cases lie one after another along `obs`; `row_size` counts those of each case.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from models.run import Run
from models.variables import ALL_CELL_VARIABLES, ALL_VARIABLES

Array = NDArray[np.float64]
CONVENTIONS = "CF-1.11"
STANDARD_NAMES = {
    "z": "depth", "theta": "platform_pitch", "phi": "platform_roll", "psi": "platform_yaw",
    "density": "sea_water_density", "current_x": "northward_sea_water_velocity",
    "current_y": "eastward_sea_water_velocity",
}  # fmt: skip
"""CF standard names of what has one."""


def write_trajectories(kept: Sequence[tuple[int, Run]]) -> bytes:
    """Return the trajectories of some cases as one NetCDF file."""
    buffer = BytesIO()
    trajectory_data(kept).to_netcdf(buffer, engine="h5netcdf")
    return buffer.getvalue()


def trajectory_data(kept: Sequence[tuple[int, Run]]) -> xr.Dataset:
    """Return the trajectories on the dimensions case, obs and cell; NaN where a case lacks a variable or a cell."""
    runs = [run for _, run in kept]
    sizes = np.array([len(run.times) for run in runs], dtype=np.int64)
    cells = list(dict.fromkeys(name for run in runs for name in run.cells))
    variables: dict[str, Any] = {
        "row_size": ("case", sizes, {"long_name": "number of samples of the case", "sample_dimension": "obs"}),
        "status": ("case", np.array([run.status.name for run in runs], dtype=object), {"long_name": "how it ended"}),
        "time": ("obs", np.concatenate([run.times for run in runs]), _about("time", "s", "time since the start")),
    }
    for name, about in _first_of(runs, "variables").items():
        columns = [run.values.get(name, np.full(len(run.times), np.nan)) for run in runs]
        variables[name] = ("obs", np.concatenate(columns), _about(name, *about))
    for name, about in _first_of(runs, "cell_variables").items():
        tables = [_on_cells(run, name, cells) for run in runs]
        variables[name] = (("obs", "cell"), np.concatenate(tables), _about(name, *about))
    cases = np.array([case for case, _ in kept], dtype=np.int64)
    coordinates = {
        "case": ("case", cases, {"long_name": "number of the case", "cf_role": "trajectory_id"}),
        "cell": ("cell", np.array(cells, dtype=object), {"long_name": "buoyancy cell or moving part"}),
    }
    attributes = {"Conventions": CONVENTIONS, "featureType": "trajectory", "kernel": runs[0].kernel}
    return xr.Dataset(variables, coordinates, attributes)


def read_trajectory(path: Path, case: int) -> tuple[Array, dict[str, Array], dict[str, Array], list[str]] | None:
    """Return times, variables, variables by cell and the cells of one case, or None where the file has it not."""
    with xr.open_dataset(path, engine="h5netcdf", decode_times=False) as stored:
        places = np.flatnonzero(stored["case"].values == case)
        if not len(places):
            return None
        ends = np.cumsum(stored["row_size"].values)
        end = int(ends[places[0]])
        part = stored.isel(obs=slice(end - int(stored["row_size"].values[places[0]]), end)).load()
    values = {name: part[name].values for name in ALL_VARIABLES if name in part}
    tables = {name: part[name].values for name in ALL_CELL_VARIABLES if name in part}
    return part["time"].values, values, tables, [str(name) for name in part["cell"].values]


def _about(name: str, unit: str, meaning: str) -> dict[str, str]:
    standard = {"standard_name": STANDARD_NAMES[name]} if name in STANDARD_NAMES else {}
    return {"units": unit, "long_name": meaning} | standard | ({"positive": "down"} if name == "z" else {})


def _first_of(runs: Sequence[Run], which: str) -> dict[str, tuple[str, str]]:
    """Return what is known of all variables that any of the runs has."""
    merged: dict[str, tuple[str, str]] = {}
    for run in {(run.model, len(run.variables)): run for run in runs}.values():
        about: Mapping[str, tuple[str, str]] = getattr(run, which)
        merged |= about
    return merged


def _on_cells(run: Run, name: str, cells: Sequence[str]) -> Array:
    table = np.full((len(run.times), len(cells)), np.nan)
    given = run.cell_values.get(name)
    if given is not None:
        table[:, [cells.index(cell) for cell in run.cells]] = given
    return table
