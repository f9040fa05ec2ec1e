"""Owns the result of one run: samples on named axes with units, how it ended and where, and its files."""

from __future__ import annotations

import csv
import json
import math
import platform
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from models.components import extension_unit
from models.design import Design, loads_design
from models.variables import CELL_VARIABLES, CONTROL_VARIABLES, IN_UNITS_OF_EXTENSION, VARIABLES, About

Array = NDArray[np.float64]


class Status(Enum):
    """How a run ended; the value says what happened and what to try."""

    completed = "The mission ran to its end."
    surface = "The glider reached the surface, where the run ends; start deeper or make it heavier to go on."
    bed = "The glider reached the bed, where the run ends; make it lighter or give a deeper bed to go on."
    diverged = "The motion ran away; with RK4 use a smaller step, else look for extreme masses, forces or damping."
    step_too_small = "The step became too small for the tolerance; raise the tolerance, or look for extreme values."
    too_many_steps = (
        "The limit of steps was reached; shorten the mission, raise the tolerance (adaptive) or the step (RK4), or "
        "look for huge damping or tiny masses, which force small steps."
    )
    cancelled = "The run was cancelled; what was computed is kept."


WHAT_HAPPENED = {
    "surface": "reached the surface", "bed": "reached the bed", "end_of_stroke": "reached a stop",
    "dive": "began to dive", "climb": "began to climb", "waypoint": "reached a waypoint",
}  # fmt: skip


def variables_of(design: Design) -> Mapping[str, About]:
    """Return unit and meaning of every variable over time that a run of a design keeps."""
    variables = VARIABLES[design.mission.solver.model]
    return variables if design.mission.control.controller is None else {**variables, **CONTROL_VARIABLES}


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened at an instant; `cell` names the part, if any.

    `kind` is surface, bed, end_of_stroke, or, of a controller, dive, climb or waypoint.
    """

    time: float
    kind: str
    cell: str | None = None

    def __str__(self) -> str:
        what = WHAT_HAPPENED[self.kind]
        return f"{self.cell or 'the glider'} {what} at {self.time:.3f} s"


CELL_COLUMN = re.compile(r"command of (?P<cell>.+) \[(?P<unit>m|rad)\]")


def _cell_label(name: str, about: About, cell: str, extension_unit: str) -> str:
    unit = extension_unit if name in IN_UNITS_OF_EXTENSION else about[0]
    return f"{name} of {cell} [{unit}]"


def _attributes(unit: str, meaning: str) -> dict[str, str]:
    return {"units": unit, "long_name": meaning}


def _on_axes(times: Array, cells: Sequence[str], units: Sequence[str], variables: dict[str, Any]) -> xr.Dataset:
    coordinates = {
        "time": ("time", times, _attributes("s", "time since the start of the mission")),
        "cell": ("cell", np.array(cells, dtype=object)),
        "extension_unit": ("cell", np.array(units, dtype=object), {"long_name": "unit of command and extension"}),
    }
    return xr.Dataset(variables, coordinates)


@dataclass(frozen=True, eq=False)
class Run:
    """One simulated glide.

    `times` (samples,) s; `values` (samples,) by the names of `variables`; `cell_values` (samples, cells) by those of
    `cell_variables`, its columns in the order of `cells`. `statistics` counts steps and evaluations. `trouble` names
    the state in which a run that failed went wrong.
    """

    design: Design
    times: Array
    values: Mapping[str, Array]
    cells: tuple[str, ...]
    cell_values: Mapping[str, Array]
    status: Status
    events: tuple[Event, ...]
    statistics: dict[str, int | float]
    kernel: str
    trouble: str | None = None

    @property
    def model(self) -> str:
        """Which equations were integrated: planar or spatial."""
        return self.design.mission.solver.model

    @property
    def variables(self) -> Mapping[str, About]:
        """Unit and meaning of every variable over time."""
        return variables_of(self.design)

    @property
    def cell_variables(self) -> Mapping[str, About]:
        """Unit and meaning of every variable over time and cell."""
        return CELL_VARIABLES[self.model]

    @cached_property
    def extension_units(self) -> tuple[str, ...]:
        """Unit of each cell's command and extension: m, or rad where it rolls."""
        units = {part.name: extension_unit(part) for _, part in self.design.vehicle.actuated}
        return tuple(units[name] for name in self.cells)

    @property
    def message(self) -> str:
        """How the run ended, in words; of one that failed also where and why."""
        if self.status not in (Status.diverged, Status.step_too_small, Status.too_many_steps):
            return str(self.status.value)
        last = self.final
        blame = "" if self.trouble is None else f", with {self.trouble} changing fastest"
        return (
            f"{self.status.value} It stopped at t = {last['t']:.6g} s, at z = {last['z']:.4g} m and "
            f"{last['speed']:.4g} m/s{blame}; what was computed is kept."
        )

    @cached_property
    def data(self) -> xr.Dataset:
        """The samples on the named axes `time` (s) and `cell` (names), units in the attributes."""
        variables: dict[str, Any] = {
            name: ("time", self.values[name], _attributes(*about)) for name, about in self.variables.items()
        }
        for name, about in self.cell_variables.items():
            variables[name] = (("time", "cell"), self.cell_values[name], _attributes(*about))
        return _on_axes(self.times, self.cells, self.extension_units, variables)

    def select(self, samples: NDArray[np.intp]) -> Run:
        """Return the run with only some of its samples, by index."""
        return replace(
            self,
            times=self.times[samples],
            values={name: column[samples] for name, column in self.values.items()},
            cell_values={name: table[samples] for name, table in self.cell_values.items()},
        )

    @property
    def final(self) -> dict[str, float]:
        """The last sample of every variable over time, by name, and its time `t`."""
        return {"t": float(self.times[-1])} | {name: float(self.values[name][-1]) for name in self.variables}

    @property
    def energy_exchanged(self) -> float:
        """What the residual is compared with, J.

        The largest kinetic energy, work of the water, or work that weight and buoyancy have done: none depends on where
        depth is counted from. The actuators' work against pressure does, and is left out.
        """
        potential, actuators = self.values["potential_energy"], self.values["actuator_work"]
        released = (potential - potential[0]) - (actuators - actuators[0])
        parts = [self.values["kinetic_energy"], self.values["water_work"], released]
        if self.model == "spatial":
            parts.append(self.values["bed_work"])
        largest = [float(np.abs(part).max()) for part in parts]
        return math.nan if any(map(math.isnan, largest)) else max(largest)

    @property
    def largest_residual(self) -> float:
        """Largest magnitude of the energy residual, J."""
        return float(np.abs(self.values["energy_residual"]).max())

    @property
    def relative_residual(self) -> float:
        """Largest energy residual as a share of the energy exchanged (0 where nothing moved, NaN where one is)."""
        exchanged = self.energy_exchanged
        return 0.0 if exchanged == 0.0 else self.largest_residual / exchanged

    def to_netcdf(self, path: Path | None = None) -> bytes:
        """Return the run as NetCDF 4, and write it to `path` where one is given."""
        events = [[event.time, event.kind, event.cell] for event in self.events]
        attributes = {
            "title": self.design.name,
            "design": self.design.to_json(),
            "design_identity": self.design.identity,
            "status": self.status.name,
            "events": json.dumps(events),
            "statistics": json.dumps(self.statistics),
            "kernel": self.kernel,
            "processor": platform.machine(),
        } | ({} if self.trouble is None else {"trouble": self.trouble})
        buffer = BytesIO()
        self.data.assign_attrs(attributes).to_netcdf(buffer, engine="h5netcdf")
        content = buffer.getvalue()
        if path is not None:
            path.write_bytes(content)
        return content

    @classmethod
    def from_netcdf(cls, path: Path) -> Run:
        """Read a run that `to_netcdf` wrote; raises `ValueError` where the file is not one."""
        try:
            with xr.open_dataset(path, engine="h5netcdf") as stored:
                data = stored.load()
        except FileNotFoundError:
            raise
        except OSError as error:
            raise ValueError(f"{path} is not a NetCDF 4 file: {error}") from None
        a = data.attrs
        missing = {"design", "status", "events", "statistics", "kernel"} - set(a)
        if missing:
            raise ValueError(f"{path} is not a run of the glider studio: it lacks {', '.join(sorted(missing))}")
        events = tuple(Event(t, kind, cell) for t, kind, cell in json.loads(a["events"]))
        statistics: dict[str, int | float] = json.loads(a["statistics"])
        design = loads_design(a["design"])
        model = design.mission.solver.model
        return cls(
            design=design,
            times=data["time"].values,
            values={name: data[name].values for name in variables_of(design)},
            cells=tuple(str(name) for name in data["cell"].values),
            cell_values={name: data[name].values for name in CELL_VARIABLES[model]},
            status=Status[a["status"]],
            events=events,
            statistics=statistics,
            kernel=str(a["kernel"]),
            trouble=a.get("trouble"),
        )

    def to_csv(self, path: Path | None = None) -> str:
        """Return the run as CSV, one row a sample, units in the header; write it to `path` where one is given."""
        columns, header = self._flat_columns()
        lines = [",".join(header)]
        lines += [",".join(map(repr, row)) for row in np.column_stack(columns).tolist()]  # repr loses no digit
        content = "\n".join(lines) + "\n"
        if path is not None:
            path.write_text(content, encoding="utf-8")
        return content

    @staticmethod
    def read_csv(path: Path) -> xr.Dataset:
        """Read what `to_csv` wrote, on the axes of `data`; raises `ValueError` where the file is not one."""
        with path.open(encoding="utf-8", newline="") as lines:
            rows = list(csv.reader(lines))
        if not rows or rows[0][:1] != ["t [s]"]:
            raise ValueError(f"{path} is not a run of the glider studio: its first column is not 't [s]'")
        table = np.array(rows[1:], dtype=np.float64).reshape(-1, len(rows[0]))
        columns = dict(zip(rows[0], table.T, strict=True))
        found = [match for match in map(CELL_COLUMN.fullmatch, rows[0]) if match]
        cells, units = [m["cell"] for m in found], [m["unit"] for m in found]
        model = "spatial" if "y [m]" in columns else "planar"
        variables: dict[str, Any] = {
            name: ("time", columns[f"{name} [{about[0]}]"], _attributes(*about))
            for name, about in {**VARIABLES[model], **CONTROL_VARIABLES}.items()
            if name not in CONTROL_VARIABLES or f"{name} [{about[0]}]" in columns
        }
        for name, about in CELL_VARIABLES[model].items():
            labels = [_cell_label(name, about, cell, unit) for cell, unit in zip(cells, units, strict=True)]
            values = np.column_stack([columns[label] for label in labels]) if labels else np.zeros((len(table), 0))
            variables[name] = (("time", "cell"), values, _attributes(*about))
        return _on_axes(columns["t [s]"], cells, units, variables)

    def _flat_columns(self) -> tuple[list[Any], list[str]]:
        columns, header = [self.times], ["t [s]"]
        for name, (unit, _) in self.variables.items():
            columns.append(self.values[name])
            header.append(f"{name} [{unit}]")
        for name, about in self.cell_variables.items():
            for k, cell in enumerate(self.cells):
                columns.append(self.cell_values[name][:, k])
                label = _cell_label(name, about, cell, self.extension_units[k])
                header.append('"' + label.replace('"', '""') + '"' if any(c in label for c in ',"') else label)
        return columns, header
