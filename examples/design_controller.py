"""Design state feedback for a dive, fly it, and export it: `python examples/design_controller.py`."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from models.controller_design import ControllerDesign
from models.controller_export import to_mat, to_script
from models.controller_request import design_as_asked
from models.loop_suggestion import suggest_loops
from models.presets import load_preset
from models.simulate import simulate

glider = load_preset("quad-bellows-glide")
dive = {"targets": {"glide_angle": -0.45, "speed": 0.3}, "depth": 30.0}
result = design_as_asked(
    glider,
    {
        "trim": dive, "sample_time": 1.0, "delay": 0.3, "deviations": {"psi": 0.2}, "share": 0.1,
        "step": {"state": "psi", "amount": 0.1, "duration": 300.0},
    },
)  # fmt: skip
assert isinstance(result, ControllerDesign) and result.response is not None
print(f"open loop:   {', '.join(f'{mode.name} {mode.growth:+.3f}' for mode in result.open_loop.modes[:4])} 1/s")
print(f"closed loop: {', '.join(f'{mode.name} {mode.growth:+.3f}' for mode in result.closed_loop.modes[:4])} 1/s")
print(result.margins)
print(f"a heading step of 0.1 rad, linear: {result.response.predicted}")
print(f"flown: {result.response.flown}")
run = simulate(result.mission(duration=120.0))  # the design under the controller, from its trim
print(f"after 120 s in its trim: pitch {run.final['theta']:.4f} rad, was {run.values['theta'][0]:.4f}")
with TemporaryDirectory() as folder:
    for write, name in ((to_mat, "design.mat"), (to_script, "design.py")):
        write(result, Path(folder) / name)
        print(f"{name}: {(Path(folder) / name).stat().st_size} bytes")
loops = suggest_loops(glider, result.problem.point)
print(f"first gains for guidance and loops: pitch {loops.cascade.pitch.loop}, settling in {loops.settling_time:.0f} s")
