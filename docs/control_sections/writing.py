"""Owns the section of docs/control.md on writing a controller in a design, and on what a run gains by it."""

from __future__ import annotations

import json
from typing import Any

from docs.formatting import markdown_table
from models.presets.quad_control import TASKS
from models.run import WHAT_HAPPENED
from models.variables import CONTROL_VARIABLES

EXAMPLE: dict[str, Any] = {
    "kind": "cascade",
    "sample_time": 2.0,
    "deadband": 0.005,
    "vertical": {"kind": "depth_band", "top": 10.0, "bottom": 90.0, "dive_heave": -4.7, "climb_heave": 4.7},
    "pitch": {
        "dive": -0.53, "climb": 0.57, "dive_moment": -0.79, "climb_moment": 0.79,
        "loop": {"proportional": 1.0, "derivative": 4.0, "limit": 2.5},
    },
    "lateral": {
        "guidance": {"kind": "heading", "heading": 0.8},
        "roll_loop": {"proportional": 2.0, "derivative": 20.0, "limit": 0.8},
        "heading_loop": {"proportional": 1.0, "derivative": 6.0, "limit": 0.35},
    },
}  # fmt: skip
"""A complete controller, for `mission.control.controller` of the quad glider."""
OTHERS: tuple[dict[str, Any], ...] = (
    {"kind": "roll", "roll": 0.2},
    {"kind": "waypoints", "points": [[800.0, 0.0], [800.0, 600.0]], "radius": 30.0, "lookahead": 100.0},
    {"kind": "station", "center": [0.0, 0.0], "radius": 80.0, "bank": 0.35},
)
"""Guidance that may take the place of the heading."""
EVENTS = ("dive", "climb", "waypoint")


def section() -> str:
    """Return the section."""
    rows = [(f"`{name}`", unit, meaning) for name, (unit, meaning) in CONTROL_VARIABLES.items()]
    events = ", ".join(f"`{kind}` (the glider {WHAT_HAPPENED[kind]})" for kind in EVENTS)
    presets = ", ".join(f"`quad-bellows-{name}`" for name in TASKS)
    return f"""## Writing one in a design

This is complete; it stands at `mission.control.controller`, with no schedule for the cells that it moves:

```json
{json.dumps(EXAMPLE, indent=2)}
```

Other guidance:

{chr(10).join(f"- `{json.dumps(other)}`" for other in OTHERS)}

Without `lateral` bank and heading are left alone; a planar design has neither. All fields with units and limits are in
the JSON Schema of the design. Presets under control: {presets}; `examples/hold_heading.py` flies one.

A run under control keeps these besides:

{markdown_table(("Variable", "Unit", "Meaning"), rows, left=3)}

They are shown as last worked out, so between two samples they stand still. Events: {events}.
"""
