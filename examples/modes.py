"""See how the quad-bellows glider answers: modes, gains, and where it turns unstable: `python examples/modes.py`."""

from __future__ import annotations

import math

import numpy as np

from models.controllability import controllability, holding_power
from models.frequency_response import frequency_response
from models.linearize import linearize
from models.modes import modes_of
from models.operating_point import point_of
from models.presets import load_preset
from models.root_locus import root_locus
from models.targeted_trim import trim_for
from models.trim import Trim

design = load_preset("quad-bellows-glide")
cells = [part.name for _, part in design.vehicle.actuated]
trim = trim_for(design, {"glide_angle": math.radians(-25.0), "speed": 0.3}, cells, depth=30.0)
assert isinstance(trim, Trim)
model = linearize(design, point_of(trim))
print(f"{len(model.states)} states, {len(model.inputs)} inputs, {len(model.outputs)} outputs about a {trim}")
for mode in modes_of(model.A, model.state_names).modes:
    leads = model.state_names[int(mode.shares.argmax())]
    period = "" if mode.period is None else f", period {mode.period:.1f} s, damping {mode.damping_ratio:.2f}"
    print(f"  {mode.name}: {mode.growth:+.4f} 1/s{period}; {leads} takes part most")
print(controllability(model))
for preset in ("canete-dual-bellows", "quad-bellows-glide", "seawing-spiral"):
    print(f"{preset}: {holding_power(load_preset(preset))}")

response = frequency_response(model, input="command of Front port cell", output="theta")
peak = response.frequencies[response.magnitude.argmax()]
print(f"pitch answers the front port cell most at {peak:.2f} rad/s, by {response.magnitude.max():.1f} {response.unit}")

fin = "/vehicle/hydrodynamics/lateral/yaw_sideslip"
built = design.vehicle.hydrodynamics.lateral.yaw_sideslip
locus = root_locus(design, fin, np.linspace(built, -built, 21).tolist(), extensions=trim.extensions, depth=30.0)
for crossing in locus.crossings:
    print(f"{crossing.name} turns unstable at a yaw moment by sideslip of {crossing.value:.1f} ({built:.1f} as built)")
