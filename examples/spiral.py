"""Bank and turn the quad-bellows glider to either side: `python examples/spiral.py`."""

from __future__ import annotations

import math

from models.design import Design
from models.energy import energy_bill
from models.presets import load_preset
from models.simulate import simulate
from server.editing import apply_patch


def sides_exchanged(design: Design) -> Design:
    """Give each port cell the schedule of its starboard twin, and the other way round."""
    swap = {"port": "starboard", "starboard": "port"}
    cells = [schedule.cell.split() for schedule in design.mission.control.schedules]
    others = [" ".join(swap.get(word, word) for word in words) for words in cells]
    pointers = [f"/mission/control/schedules/{i}/cell" for i in range(len(cells))]
    return apply_patch(
        design, [{"op": "replace", "path": p, "value": name} for p, name in zip(pointers, others, strict=True)]
    )


spiral = load_preset("quad-bellows-spiral")
for name, design in (("as designed", spiral), ("sides exchanged", sides_exchanged(spiral))):
    run = simulate(design)
    end, bill = run.final, energy_bill(run)
    assert bill is not None
    print(
        f"{name:<16} roll {math.degrees(end['phi']):6.1f} deg, turning {math.degrees(end['turn_rate']):6.2f} deg/s, "
        f"radius {end['turn_radius']:.1f} m, depth {end['z']:.1f} m, battery {bill.whole.total:.0f} J"
    )
