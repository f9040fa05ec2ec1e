"""Follow stability along a mission, and see where a schedule loses it: `python examples/stability.py`."""

from __future__ import annotations

from models.design import parse_design
from models.presets import load_preset
from models.simulate import simulate
from models.stability import stability_over

document = load_preset("three-cell-glider").model_dump(mode="json")
keel = next(part for part in document["vehicle"]["components"] if part["name"] == "Keel ballast")
for z in (keel["position"][2], -0.004):  # as built, and with the ballast moved up above the axis
    keel["position"][2] = z
    run = simulate(parse_design(document))
    history = stability_over(run, samples=50)
    print(f"keel ballast at z = {1e3 * z:.0f} mm: {run.status.name}")
    for extreme in history.extremes:
        print(f"  worst {extreme.name}: {extreme.value:+.4g} {extreme.unit} at {extreme.time:.1f} s")
    for warning in history.warnings[:3]:
        print(f"  {warning.message}")
