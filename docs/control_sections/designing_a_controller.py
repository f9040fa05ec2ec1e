"""Owns the section of docs/control.md that says how state feedback is designed; a test runs its code."""

from __future__ import annotations


def section() -> str:
    """Return the section."""
    return """## Designing a controller

State feedback, e = e₀ − K (x − x₀) − K_i ∫(x − x₀), is designed on the sampled linear model about a trim. One
call finds the trim, the gains and what they promise, and flies a step on the non-linear model:

```python
from models.controller_request import design_as_asked
from models.presets import load_preset

glider = load_preset("quad-bellows-glide")
dive = {"targets": {"glide_angle": -0.5, "speed": 0.2}, "depth": 30.0}
options = {
    "trim": dive, "sample_time": 1.0, "delay": 0.5, "integrals": 1,
    "deviations": {"theta": 0.05}, "share": 0.1, "step": {"state": "theta", "amount": 0.01, "duration": 120.0},
}
result = design_as_asked(glider, options)
print(result.margins, result.response.predicted, result.response.flown, *result.warnings, sep="\\n")
```

From a shell, with files to go on with (`--help` lists the rest); over HTTP `POST /api/v1/controllers:design`, as
JSON, as a MATLAB file or as a script by Accept:

```
glider-studio design-controller glider.json --target glide_angle=-0.5 --target speed=0.2 --step theta=0.01 \\
    --plot step.png -o controlled.json -o design.mat -o design.py
```

**Gains.** `"method": "lqr"` (the default) takes Bryson's weights: `deviations` are the largest acceptable
departures by state, in its unit, `share` (or `shares` by cell) those of the commands as a share of the stroke.
The cost counts what happens between samples, so weights mean the same at any `sample_time`. Where there is a
delay, or states or lags are not fed back, the gains are those of least cost that the law allows, found step by
step. `"method": "poles"` places as many `poles` (1/s, pairs of real and imaginary part) as there are states and
integrals, on the model without the delay.

**States.** Without `states`, all of the motion that the cells can move is fed back, and the extensions of cells
that lag; a state that drifts in the trim (depth; heading in a turn) is left out. What no cell moves is refused by
name.

**Figures.** `result.closed_loop` (modes as if continuous, s = log z / T) and `result.margins` are of all states
with the delay: gain, phase and delay margins at each cell, the others closed; factors on all gains and a delay of
all commands that the sampled loop bears, exactly; and a disk margin against all cells changing at once. Rate
limits and stops are not in the linear model: the response warns where it asks for more, and the flight shows what
that does.

```python
from models.controller_options import StepOptions
from models.simulate import simulate

turn = result.step(StepOptions(state="psi", amount=0.2, duration=300.0))  # linear, and flown
print(turn.flown, turn.flown.rate)
back = result.departure({"theta": 0.05, "q": 0.01})                       # disturbed at the start
run = simulate(result.mission(duration=300.0))                            # from the trim, controller installed
```

A **table of gains** holds a design at each value of a target and goes from one to the other as `set_points` ask:

```python
points = [{"time": 0.0, "value": -0.5}, {"time": 50.0, "value": -0.5}, {"time": 150.0, "value": -0.4}]
table = {"target": "glide_angle", "values": [-0.5, -0.45, -0.4], "set_points": points}
scheduled = design_as_asked(glider, {"trim": {"targets": {"speed": 0.2}, "depth": 30.0}, "table": table})
run = simulate(scheduled.mission(duration=300.0))
```

**First gains for a cascade** (guidance, loops, allocation) come from the same model; the rule is in
`models/loop_suggestion.py`:

```python
from models.loop_suggestion import suggest_loops

suggested = suggest_loops(glider, result.problem.point, heading=0.5)
print(suggested.cascade.pitch.loop, suggested.settling_time)
```

**Export**: `models.controller_export.to_mat(result, path)` for MATLAB, `to_control(result, "plant" | "sampled" |
"closed")` for python-control, `to_script(result, path)` for a script of NumPy and SciPy alone that rebuilds the
loop and prints the response (`--json`, `--plot`; `--fly` flies the non-linear model where glider-studio is
installed).
"""
