"""Owns the names, units and meanings of all that a run keeps over time, for either model."""

from __future__ import annotations

from collections.abc import Mapping

About = tuple[str, str]
"""Unit and meaning."""

_SHARED: dict[str, About] = {
    "x": ("m", "distance north (forward of the start) of the body origin"),
    "z": ("m", "depth of the body origin, down"),
    "theta": ("rad", "pitch angle, nose up"),
    "u": ("m/s", "surge velocity, body axes"),
    "w": ("m/s", "heave velocity, body axes"),
    "q": ("rad/s", "pitch rate, body axes"),
    "x_dot": ("m/s", "velocity north, world axes"),
    "z_dot": ("m/s", "downward velocity, world axes"),
    "alpha": ("rad", "angle of attack"),
    "flow_angle": ("rad", "flow angle: direction of motion below the horizontal"),
    "speed": ("m/s", "speed through the water"),
    "lift": ("N", "lift, across the flow"),
    "drag": ("N", "drag, along the flow"),
    "moment": ("N m", "pitching moment of the hydrodynamic source about the body origin, nose up"),
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

_KINDS = {"hydro": "of the water", "damping": "of the linear damping", "weight": "of weight", "buoyancy": "of buoyancy"}
_AXES = {"X": "force forward", "Y": "force to starboard", "Z": "force down"}
_TURNS = {"K": "roll moment", "M": "pitch moment", "N": "yaw moment"}

_SPATIAL_ONLY: dict[str, About] = {
    "y": ("m", "distance east (to the right of the start) of the body origin"),
    "phi": ("rad", "roll angle, starboard down"),
    "psi": ("rad", "yaw angle (heading), to the right"),
    **{f"q{i}": ("1", f"attitude quaternion, body to world, entry {i} (scalar first)") for i in range(4)},
    "v": ("m/s", "sway velocity, body axes"),
    "p": ("rad/s", "roll rate, body axes"),
    "r": ("rad/s", "yaw rate, body axes"),
    "y_dot": ("m/s", "velocity east, world axes"),
    "current_x": ("m/s", "velocity of the water north, at the body origin"),
    "current_y": ("m/s", "velocity of the water east, at the body origin"),
    "beta": ("rad", "sideslip"),
    "side_force": ("N", "side force, across the flow to starboard"),
    "turn_rate": ("rad/s", "turn rate about the vertical, to the right"),
    "turn_radius": ("m", "radius of the turn through the water; not a number where it goes straight"),
    "density": ("kg/m3", "density of the water at the body origin"),
    "pressure": ("Pa", "gauge pressure at the body origin"),
    "bed_work": ("J", "work of the bed on the glider since the start"),
    "battery_energy": ("J", "energy taken from the battery since the start: actuators and hotel load"),
    "com_y": ("m", "centre of mass, body y"),
    "cob_y": ("m", "centre of buoyancy, body y"),
    **{f"{kind}_{axis}": ("N", f"{what} {whose}, body axes")
       for kind, whose in _KINDS.items() for axis, what in _AXES.items()},
    **{f"{kind}_{axis}": ("N m", f"{what} {whose} about the body origin, body axes")
       for kind, whose in _KINDS.items() for axis, what in _TURNS.items()},
    "bed_force": ("N", "force of the bed, up"),
}  # fmt: skip

CONTROL_VARIABLES: dict[str, About] = {
    "phase": ("1", "phase of the glide under control: 0 dive, 1 climb"),
    "pitch_target": ("rad", "pitch that the controller holds"),
    "roll_target": ("rad", "bank that the controller holds"),
    "heading_target": ("rad", "heading that the controller holds"),
    "heave_wanted": ("N", "net buoyancy wanted of the cells, from neutral, up"),
    "pitch_moment_wanted": ("N m", "pitch moment wanted of the cells, from neutral, nose up"),
    "roll_moment_wanted": ("N m", "roll moment wanted of the cells, from neutral, starboard down"),
    "heave_missing": ("N", "net buoyancy wanted that the cells cannot make"),
    "pitch_moment_missing": ("N m", "pitch moment wanted that the cells cannot make"),
    "roll_moment_missing": ("N m", "roll moment wanted that the cells cannot make"),
    "leg": ("1", "leg of the way, from 0; their number once the last is done"),
    "set_point": ("1", "set point of state feedback, in its own unit"),
}
"""What a controller shows, in the order in which the kernel keeps it; not a number where it does not apply."""
VARIABLES: dict[str, Mapping[str, About]] = {"planar": _SHARED, "spatial": _SHARED | _SPATIAL_ONLY}
"""Unit and meaning of every variable over time, by model."""
ALL_VARIABLES = {**VARIABLES["spatial"], **CONTROL_VARIABLES}
"""Those of both models, and of control."""

_OF_CELLS: dict[str, About] = {
    "command": ("m", "commanded extension"),
    "extension": ("m", "extension"),
    "volume": ("m3", "displaced volume"),
}
_SPENT: dict[str, About] = {"energy": ("J", "energy taken from the battery since the start")}
CELL_VARIABLES: dict[str, Mapping[str, About]] = {"planar": _OF_CELLS, "spatial": _OF_CELLS | _SPENT}
"""Unit and meaning of every variable over time and cell, by model; commands and extensions of what rolls are in rad."""
ALL_CELL_VARIABLES = CELL_VARIABLES["spatial"]
IN_UNITS_OF_EXTENSION = ("command", "extension")
