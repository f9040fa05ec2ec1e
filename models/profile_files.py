"""Owns reading water and currents from CSV and NetCDF, each number with the place it comes from.

Columns of a CSV, and variables of a NetCDF: depth (m), temperature (degC, in situ) and salinity; density (kg/m3); or
north and east (m/s), and optionally time (s). A NetCDF may use CF standard names instead, and z upward for depth. A
column of a CSV may carry its unit: "depth (m)", "depth [m]". docs/data_files.md has an example of each.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.resources.abc import Traversable
from itertools import islice
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from pydantic import ValidationError

from models.environment import DensityProfile, TabulatedCurrent, Teos10Water
from models.fields import Description
from models.problems import DesignError, Problem, problems_from_validation

Array = NDArray[np.float64]
Model = TypeVar("Model", bound=Description)

NETCDF_SUFFIXES = {".nc", ".nc4", ".cdf", ".netcdf", ".h5"}
PRACTICAL, ABSOLUTE = "sea_water_practical_salinity", "sea_water_absolute_salinity"
STANDARD_NAMES = {
    "depth": ("depth", "height", "altitude"),
    "time": ("time",),
    "temperature": ("sea_water_temperature",),
    "salinity": (PRACTICAL, ABSOLUTE, "sea_water_salinity"),
    "density": ("sea_water_density",),
    "north": ("northward_sea_water_velocity",),
    "east": ("eastward_sea_water_velocity",),
}
_METRE = {"m", "meter", "meters", "metre", "metres"}
_SPEED = {"m/s", "m s-1", "m s^-1", "m.s-1", "m*s-1", "m s**-1", "meter second-1", "metre second-1", "meters/second"}
_DENSITY = {"kg/m3", "kg/m^3", "kg m-3", "kg m^-3", "kg.m-3", "kg m**-3"}
_CELSIUS = {"degc", "deg_c", "c", "°c", "celsius"} | {f"degree{s}_{c}" for s in ("", "s") for c in ("c", "celsius")}
_DEGREES = {"deg", "degree", "degrees", "°"}
_NEWTON = {"n", "newton", "newtons"}
_NEWTON_METRE = {"n m", "nm", "n*m", "n.m", "n·m", "n-m"}
Units = Mapping[str, tuple[str, set[str]]]
UNITS: Units = {
    "depth": ("m", _METRE),
    "time": ("s", {"s", "sec", "second", "seconds"}),
    "temperature": ("degC", _CELSIUS),
    "density": ("kg/m3", _DENSITY),
    "north": ("m/s", _SPEED),
    "east": ("m/s", _SPEED),
    "speed": ("m/s", _SPEED),
    **dict.fromkeys(("alpha_deg", "beta_deg"), ("deg", _DEGREES)),
    **dict.fromkeys(("lift", "drag", "X", "Y", "Z"), ("N", _NEWTON)),
    **dict.fromkeys(("moment", "K", "M", "N"), ("N m", _NEWTON_METRE)),
}
"""Unit of each quantity, and how files write it (compared in lower case)."""
SALINITY_UNITS = {
    "practical": ("1", {"1", "-", "psu", "pss", "pss-78"}),
    "absolute": ("g/kg", {"g/kg", "g kg-1", "g kg^-1", "g kg**-1"}),
}
_WITH_UNIT = re.compile(r"(?P<name>.*?)\s*(?:\((?P<round>[^()]*)\)|\[(?P<square>[^\[\]]*)\])")
WATER_COLUMNS = ("depth", "temperature", "salinity")
DENSITY_COLUMNS = ("depth", "density")
CURRENT_COLUMNS = ("depth", "north", "east", "time")
LATITUDE_HINT = "give latitude: pressure and gravity follow from it"
MOST_NAMED = 5
"""How many bad places a message names; it counts the others."""


@dataclass(frozen=True, slots=True)
class Samples:
    """Rows of numbers of a file: `columns` of one length, and for each row the place it stands."""

    file: str
    places: tuple[str, ...]
    columns: dict[str, Array]

    def refuse(self, message: str, hint: str | None = None) -> DesignError:
        """Make the error that says what is wrong with the file."""
        return DesignError([Problem("", f"{self.file}: {message}", hint=hint)])


def read_water_profile(
    path: Path,
    *,
    latitude: float | None = None,
    longitude: float | None = None,
    salinity_kind: Literal["practical", "absolute"] = "practical",
    source: str = "",
) -> Teos10Water:
    """Read temperature, and salinity where there is any, against depth; rows in any order.

    A NetCDF may hold latitude and longitude (degrees) as scalars or attributes: taken where they are not given. The
    standard name of its salinity goes before `salinity_kind`.

    Raises
    ------
    DesignError
        With file, line and column, where something is missing, is no number, or stands twice.

    """
    units = {**UNITS, "salinity": SALINITY_UNITS[salinity_kind]}
    samples, told = _read(path, WATER_COLUMNS[:2], WATER_COLUMNS[2:], units)
    (depths,), grids = on_grid(samples, ("depth",))
    latitude = told.get("latitude") if latitude is None else latitude
    if latitude is None:
        raise samples.refuse("no latitude", hint=LATITUDE_HINT)
    document = {
        "kind": "teos10", "depths": depths.tolist(), "temperatures": grids["temperature"].tolist(),
        "salinities": grids["salinity"].tolist() if "salinity" in grids else None,
        "salinity_kind": told.get("salinity_kind", salinity_kind), "latitude": latitude,
        "longitude": told.get("longitude") if longitude is None else longitude, "source": source,
    }  # fmt: skip
    return validated(Teos10Water, document, samples)


def read_density_profile(path: Path, *, source: str = "") -> DensityProfile:
    """Read in-situ density against depth; rows in any order. Raises as `read_water_profile` does."""
    samples, _ = _read(path, DENSITY_COLUMNS, ())
    (depths,), grids = on_grid(samples, ("depth",))
    document = {
        "kind": "density_profile", "depths": depths.tolist(), "densities": grids["density"].tolist(), "source": source,
    }  # fmt: skip
    return validated(DensityProfile, document, samples)


def read_current_profile(path: Path, *, source: str = "") -> TabulatedCurrent:
    """Read a current against depth, and against time where there is one: all depths at every time, in any order.

    Times that are dates count from the first of them. Raises as `read_water_profile` does.
    """
    samples, _ = _read(path, CURRENT_COLUMNS[:3], CURRENT_COLUMNS[3:])
    timed = "time" in samples.columns
    axes, grids = on_grid(samples, ("time", "depth") if timed else ("depth",))
    document = {
        "kind": "tabulated", "depths": axes[-1].tolist(), "times": axes[0].tolist() if timed else [0.0],
        "north": np.atleast_2d(grids["north"]).tolist(), "east": np.atleast_2d(grids["east"]).tolist(),
        "source": source,
    }  # fmt: skip
    return validated(TabulatedCurrent, document, samples)


def validated(model: type[Model], document: dict[str, Any], samples: Samples) -> Model:
    """Make a description of what was read; its problems name the file."""
    try:
        return model.model_validate(document)
    except ValidationError as error:
        problems = problems_from_validation(error, document)
        raise DesignError(replace(p, message=f"{samples.file}: {p.message}") for p in problems) from None


def on_grid(samples: Samples, axes: tuple[str, ...]) -> tuple[list[Array], dict[str, Array]]:
    """Sort samples on the grid of their axes: the values of each axis, and the other columns in that shape.

    Raises
    ------
    DesignError
        Where a point of the grid is there twice, or not at all.

    """
    found = [np.unique(samples.columns[axis], return_inverse=True) for axis in axes]
    values, shape = [axis for axis, _ in found], tuple(len(axis) for axis, _ in found)
    flat = np.ravel_multi_index(tuple(index for _, index in found), shape)

    def named(point: int) -> str:
        index = np.unravel_index(point, shape)
        return ", ".join(f"{axis} {float(v[i]):g}" for axis, v, i in zip(axes, values, index, strict=True))

    places: dict[int, list[str]] = {}
    for point, place in zip(flat.tolist(), samples.places, strict=True):
        places.setdefault(point, []).append(place)
    doubled = [f"{named(point)} ({' and '.join(at)})" for point, at in places.items() if len(at) > 1]
    if doubled:
        raise samples.refuse(f"given more than once: {_some(doubled, len(doubled))}", hint="keep one row for each")
    size = math.prod(shape)
    if len(places) < size:
        holes = (named(point) for point in range(size) if point not in places)
        raise samples.refuse(f"missing: {_some(holes, size - len(places))}", hint="every combination must be given")
    order = np.argsort(flat)
    return values, {name: c[order].reshape(shape) for name, c in samples.columns.items() if name not in axes}


def _some(names: Iterable[str], count: int) -> str:
    return f"{'; '.join(islice(names, MOST_NAMED))}{'; ...' if count > MOST_NAMED else ''} ({count} in all)"


def _read(
    path: Path, required: Sequence[str], optional: Sequence[str], units: Units = UNITS
) -> tuple[Samples, dict[str, Any]]:
    """Return the samples, and what a NetCDF says of itself: latitude, longitude, kind of salinity."""
    if path.suffix.lower() in NETCDF_SUFFIXES:
        return _read_netcdf(path, required, optional)
    return read_csv(path, required, optional=optional, axes=("depth", "time"), units=units), {}


def read_csv(
    path: Path | Traversable,
    required: Sequence[str],
    *,
    optional: Sequence[str] = (),
    axes: Sequence[str] = (),
    units: Units = UNITS,
) -> Samples:
    """Read columns of numbers under a header, in UTF-8; further columns are left alone.

    A row that has nothing but its axes is left out.

    Raises
    ------
    DesignError
        Where a column is missing, stands twice or is in another unit, or a cell is empty or no number; with its line.

    """
    try:
        reader = csv.reader(path.read_text(encoding="utf-8-sig").splitlines())
        rows = [(reader.line_num, cells) for cells in reader if any(cell.strip() for cell in cells)]
    except (UnicodeDecodeError, csv.Error) as error:
        raise DesignError([Problem("", f"{path.name} is not a CSV in UTF-8: {error}")]) from None
    header = plain_header(path.name, rows[0][1], (*required, *optional), units) if rows else []
    wanted = [*required, *(name for name in optional if name in header)]
    _check_header(path.name, header, required, wanted)
    for line, cells in rows[1:]:
        if len(cells) > len(header):
            message = f"{path.name}, line {line}: {len(cells)} cells under a header of {len(header)}"
            raise DesignError([Problem("", message, hint="separate cells by commas, write decimals with a point")])
    columns = {name: header.index(name) for name in wanted}
    numbers = {
        name: np.array([_number(cells, k, f"{path.name}, line {line}, column {name}") for line, cells in rows[1:]])
        for name, k in columns.items()
    }
    return _without_gaps(Samples(path.name, tuple(f"line {line}" for line, _ in rows[1:]), numbers), axes)


def plain_header(file: str, cells: Sequence[str], names: Sequence[str], units: Units = UNITS) -> list[str]:
    """Return a header without the units that its columns `names` carry, as in "depth (m)" or "depth [m]".

    Raises
    ------
    DesignError
        Where a column is there only in another unit than the one that is read.

    """
    header, others = [cell.strip() for cell in cells], {}
    for k, cell in enumerate(header):
        found = _WITH_UNIT.fullmatch(cell)
        if found is None or found["name"] not in names or found["name"] not in units:
            continue
        said = (found["round"] or found["square"] or "").strip()
        if said.lower() in units[found["name"]][1]:
            header[k] = found["name"]
        else:
            others[found["name"]] = said
    for name, said in others.items():
        if name not in header:
            message = f"{file}: column {name} is in {said!r}, wanted is {units[name][0]}"
            raise DesignError([Problem("", message, hint="convert it and correct its header")])
    return header


def _check_header(file: str, header: list[str], required: Sequence[str], wanted: Sequence[str]) -> None:
    if not header:
        message = f"{file} is empty"
        raise DesignError([Problem("", message, hint=f"give a header with {', '.join(required)}, and rows below it")])
    missing = [name for name in required if name not in header]
    if missing:
        hint = f"wanted are {', '.join(required)}; its header has {', '.join(header)}"
        raise DesignError([Problem("", f"{file} lacks the columns {', '.join(missing)}", hint=hint)])
    doubled = [name for name in wanted if header.count(name) > 1]
    if doubled:
        message = f"{file} has the columns {', '.join(doubled)} more than once"
        raise DesignError([Problem("", message, hint="rename those that are not meant")])


def _number(cells: Sequence[str], index: int, where: str) -> float:
    """Return the number of a cell, not a number where it is empty."""
    cell = cells[index].strip() if index < len(cells) else ""
    try:
        number = float(cell or "nan")
    except ValueError:
        raise DesignError([Problem("", f"{where}: {cell!r} is not a number")]) from None
    if math.isinf(number):
        raise DesignError([Problem("", f"{where}: {cell!r} is not finite")])
    return number


def _without_gaps(samples: Samples, axes: Sequence[str]) -> Samples:
    """Leave out rows without any value, and refuse those that have some."""
    values = np.array([column for name, column in samples.columns.items() if name not in axes])
    kept = ~np.isnan(values).all(axis=0)
    if not kept.any():
        raise samples.refuse("no row has a number", hint="give one row a level")
    for name, column in samples.columns.items():
        gaps = np.flatnonzero(np.isnan(column) & kept)
        if gaps.size:
            message = f"{samples.places[gaps[0]]}, column {name}: no number ({gaps.size} such rows)"
            raise samples.refuse(message, hint="fill in the number or delete the row")
    columns = {name: column[kept] for name, column in samples.columns.items()}
    places = tuple(place for place, keep in zip(samples.places, kept, strict=True) if keep)
    return Samples(samples.file, places, columns)


def _read_netcdf(path: Path, required: Sequence[str], optional: Sequence[str]) -> tuple[Samples, dict[str, Any]]:
    try:
        data = xr.open_dataset(path, engine="h5netcdf", decode_timedelta=False)
    except FileNotFoundError:
        raise
    except (OSError, ValueError) as error:
        hint = "convert older NetCDF with nccopy -k nc4"
        raise DesignError([Problem("", f"{path.name} cannot be read as NetCDF-4: {error}", hint=hint)]) from None
    with data:
        found = {name: _variable(path.name, data, name) for name in (*required, *optional)}
        arrays = {name: array for name, array in found.items() if array is not None}
        missing = [name for name in required if name not in arrays]
        if missing:
            hint = f"it has {', '.join(map(str, data.variables))}; CF standard names are read too"
            raise DesignError([Problem("", f"{path.name} lacks the variables {', '.join(missing)}", hint=hint)])
        return _samples(path.name, arrays), _told(data, arrays)


def _variable(file: str, data: xr.Dataset, name: str) -> xr.DataArray | None:
    """Find a variable by its name or, where there is none, by its standard name; depth also as z."""
    standard = STANDARD_NAMES[name]
    plain: list[Any] = [n for n in ((name, "z") if name == "depth" else (name,)) if n in data.variables]
    names: list[Any] = plain or [n for n in data.variables if data[n].attrs.get("standard_name") in standard]
    if not names:
        return None
    if len(names) > 1 and not plain:
        message = f"{file}: {name} may be any of {', '.join(map(str, names))}"
        raise DesignError([Problem("", message, hint=f"rename the one that is meant to {name}")])
    array: xr.DataArray = data[names[0]]
    said = array.attrs.get("standard_name", standard[0])
    if said not in standard:
        message = f"{file}: {names[0]} is {said}, wanted is {standard[0]}"
        raise DesignError([Problem("", message, hint="convert it and correct its standard name")])
    if name in UNITS and "units" in array.attrs and str(array.attrs["units"]).strip().lower() not in UNITS[name][1]:
        message = f"{file}: {names[0]} is in {array.attrs['units']!r}, wanted is {UNITS[name][0]}"
        raise DesignError([Problem("", message, hint="convert it and correct its units")])
    return array


def _samples(file: str, arrays: dict[str, xr.DataArray]) -> Samples:
    """Spread the variables over their common dimensions, one row for each point."""
    axes = [arrays[name].squeeze() for name in ("time", "depth") if name in arrays]
    order = list(dict.fromkeys(str(axis.dims[0]) for axis in axes if axis.ndim == 1))
    for name, array in arrays.items():
        loose = [f"{d} ({n})" for d, n in array.sizes.items() if n > 1 and d not in order]
        if loose:
            hint = "pick one profile first: dataset.isel(...).to_netcdf(...)"
            raise DesignError([Problem("", f"{file}: {name} varies along {', '.join(loose)}", hint=hint)])
    spread = xr.broadcast(*(array.squeeze().reset_coords(drop=True) for array in arrays.values()))
    flat = {
        name: _seconds(array.transpose(*order).values.ravel(), f"{file}, variable {name}")
        for name, array in zip(arrays, spread, strict=True)
    }
    if _upward(arrays["depth"]):
        flat["depth"] = 0.0 - flat["depth"]
    points = np.ndindex(*(spread[0].sizes[d] for d in order))
    places = tuple(", ".join(f"{d}[{i}]" for d, i in zip(order, point, strict=True)) or "value" for point in points)
    return _without_gaps(Samples(file, places, flat), ("depth", "time"))


def _upward(depth: xr.DataArray) -> bool:
    usual = "down" if depth.attrs.get("standard_name", depth.name) == "depth" else "up"
    return str(depth.attrs.get("positive", usual)).lower() == "up"


def _seconds(values: NDArray[Any], where: str) -> Array:
    """Return numbers as they are, dates as seconds from the first."""
    if values.dtype.kind == "M":
        values = (values - np.nanmin(values)) / np.timedelta64(1, "s")
    if values.dtype.kind not in "iuf":
        raise DesignError([Problem("", f"{where}: {values.dtype} values are not numbers")])
    return values.astype(np.float64)


def _told(data: xr.Dataset, arrays: dict[str, xr.DataArray]) -> dict[str, Any]:
    told: dict[str, Any] = {}
    for name, short in (("latitude", "lat"), ("longitude", "lon")):
        for key in (name, short):
            value = data[key].values if key in data.variables else np.asarray(data.attrs.get(key, np.nan))
            if value.size == 1 and value.dtype.kind in "iuf" and np.isfinite(value).all():
                told.setdefault(name, float(value.item()))
    said = arrays["salinity"].attrs.get("standard_name") if "salinity" in arrays else None
    kinds: dict[Any, str] = {PRACTICAL: "practical", ABSOLUTE: "absolute"}
    return told | ({"salinity_kind": kinds[said]} if said in kinds else {})
