"""Owns the result of one run: samples on named axes with units, how it ended, and its files."""

from __future__ import annotations

import json
import platform
from dataclasses import dataclass
from enum import Enum
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from models.design import Design, loads_design


class Status(Enum):
    """How a run ended; the value says what happened and what to try."""

    completed = "The mission ran to its end."
    surface = "The glider reached the surface, where the run ends; start deeper or make it heavier to go on."
    bed = "The glider reached the bed, where the run ends; make it lighter or give a deeper bed to go on."
    diverged = "The state stopped being finite; use a smaller step, or the adaptive method."
    step_too_small = "The step became too small for the tolerance; raise the tolerance, or look for extreme values."
    too_many_steps = "The limit of steps was reached; shorten the mission, raise the tolerance, or use a larger step."
    cancelled = "The run was cancelled; what was computed is kept."


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened at an instant: `kind` is surface, bed or end_of_stroke; `cell` names the part, if any."""

    time: float
    kind: str
    cell: str | None = None

    def __str__(self) -> str:
        what = {"surface": "reached the surface", "bed": "reached the bed", "end_of_stroke": "reached a stop"}[
            self.kind
        ]
        return f"{self.cell or 'the glider'} {what} at {self.time:.3f} s"


VARIABLES: dict[str, tuple[str, str]] = {
    "x": ("m", "distance forward of the body origin"),
    "z": ("m", "depth of the body origin, down"),
    "theta": ("rad", "pitch angle, nose up"),
    "u": ("m/s", "surge velocity, body axes"),
    "w": ("m/s", "heave velocity, body axes"),
    "q": ("rad/s", "pitch rate"),
    "x_dot": ("m/s", "forward velocity, world axes"),
    "z_dot": ("m/s", "downward velocity, world axes"),
    "alpha": ("rad", "angle of attack"),
    "flow_angle": ("rad", "flow angle, atan2(z_dot, x_dot)"),
    "speed": ("m/s", "speed through the water"),
    "lift": ("N", "lift, across the flow"),
    "drag": ("N", "drag, along the flow"),
    "moment": ("N m", "hydrodynamic pitching moment about the body origin, nose up"),
    "net_buoyancy": ("N", "buoyancy minus weight, positive up"),
    "kinetic_energy": ("J", "kinetic energy, with the added mass where it is on"),
    "potential_energy": ("J", "potential energy of weight and buoyancy"),
    "actuator_work": ("J", "work of the actuators on the glider since the start"),
    "water_work": ("J", "work of the water's forces on the glider since the start"),
    "energy_residual": ("J", "energy that the balance of works does not explain"),
    "com_x": ("m", "centre of mass, body x"),
    "com_z": ("m", "centre of mass, body z"),
    "cob_x": ("m", "centre of buoyancy, body x"),
    "cob_z": ("m", "centre of buoyancy, body z"),
}
"""Unit and meaning of every variable over time."""

CELL_VARIABLES: dict[str, tuple[str, str]] = {
    "command": ("m", "commanded extension"),
    "extension": ("m", "extension"),
    "volume": ("m3", "displaced volume"),
}
"""Unit and meaning of every variable over time and cell."""


@dataclass(frozen=True)
class Run:
    """One simulated glide.

    `data` has the dimensions `time` (s) and `cell` (names), the variables of `VARIABLES` and `CELL_VARIABLES`, units in
    their attributes. `statistics` counts steps and evaluations.
    """

    design: Design
    data: xr.Dataset
    status: Status
    events: tuple[Event, ...]
    statistics: dict[str, int | float]
    kernel: str

    @property
    def final(self) -> dict[str, float]:
        """The last sample of every variable over time, by name, and its time `t`."""
        return {"t": float(self.data["time"].values[-1])} | {n: float(self.data[n].values[-1]) for n in VARIABLES}

    @property
    def energy_exchanged(self) -> float:
        """Largest magnitude of any energy or work in the balance, J: what the residual is compared with."""
        potential = self.data["potential_energy"].values
        parts = [self.data[name].values for name in ("kinetic_energy", "actuator_work", "water_work")]
        return max(float(np.abs(part).max()) for part in (*parts, potential - potential[0]))

    @property
    def relative_residual(self) -> float:
        """Largest energy residual as a share of the energy exchanged (0 where nothing moved)."""
        exchanged = self.energy_exchanged
        return float(np.abs(self.data["energy_residual"].values).max()) / exchanged if exchanged > 0.0 else 0.0

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
        }
        buffer = BytesIO()
        self.data.assign_attrs(attributes).to_netcdf(buffer, engine="h5netcdf")
        content = buffer.getvalue()
        if path is not None:
            path.write_bytes(content)
        return content

    @classmethod
    def from_netcdf(cls, path: Path) -> Run:
        """Read a run that `to_netcdf` wrote; raises `ValueError` where the file is not one."""
        with xr.open_dataset(path, engine="h5netcdf") as stored:
            data = stored.load()
        a = data.attrs
        missing = {"design", "status", "events", "statistics", "kernel"} - set(a)
        if missing:
            raise ValueError(f"{path} is not a run of the glider studio: it lacks {', '.join(sorted(missing))}")
        events = tuple(Event(t, kind, cell) for t, kind, cell in json.loads(a["events"]))
        statistics: dict[str, int | float] = json.loads(a["statistics"])
        design, kernel = loads_design(a["design"]), str(a["kernel"])
        return cls(design, data.drop_attrs(), Status[a["status"]], events, statistics, kernel)

    def to_csv(self, path: Path | None = None) -> str:
        """Return the run as CSV, one row a sample, units in the header; write it to `path` where one is given."""
        columns, header = self._flat_columns()
        lines = [",".join(header)]
        lines += [",".join(map(repr, row)) for row in np.column_stack(columns).tolist()]  # repr loses no digit
        content = "\n".join(lines) + "\n"
        if path is not None:
            path.write_text(content)
        return content

    def _flat_columns(self) -> tuple[list[Any], list[str]]:
        d = self.data
        columns, header = [d["time"].values], ["t [s]"]
        for name, (unit, _) in VARIABLES.items():
            columns.append(d[name].values)
            header.append(f"{name} [{unit}]")
        for name, (unit, _) in CELL_VARIABLES.items():
            for cell in d["cell"].values:
                columns.append(d[name].sel(cell=cell).values)
                label = f"{name} of {cell} [{unit}]"
                header.append('"' + label.replace('"', '""') + '"' if any(c in label for c in ',"') else label)
        return columns, header
