"""Owns the section of docs/control.md that says how to bring a controller of one's own; a test runs its code."""

from __future__ import annotations


def section() -> str:
    """Return the section."""
    return """## Your own controller and Gymnasium

`simulate_with` calls a function of yours at a fixed sample time; in between the kernel integrates, so the run keeps
its events, error control and energy balance. The function gets a `Measurement` (depth, attitude, velocity through the
water, rates, place, extensions by name; SI, radians) and returns commanded extensions by name. A cell that it leaves
out keeps its last command; one never named follows its schedule. A command beyond a stop is held at the stop; an
unknown name or a number that is not finite raises an error that says which and when.

```python
import math

from models.allocation import allocate, effectiveness
from models.controllers import Noise
from models.mission import Control
from models.own_controller import simulate_with
from models.presets import load_preset

design = load_preset("quad-bellows-glide")
mission = design.mission.model_copy(update={"control": Control(), "duration": 200.0})
design = design.model_copy(update={"mission": mission})
cells = effectiveness(design)

def level_dive(seen):
    roll_rate, pitch_rate, yaw_rate = seen.angular_velocity
    pitch_moment = 2.0 * (math.radians(-30.0) - seen.pitch) - 4.0 * pitch_rate  # N m, nose up
    return allocate(cells, [-3.0, pitch_moment, -seen.roll - roll_rate]).extensions  # N, N m, N m

run = simulate_with(design, level_dive, sample_time=1.0, delay=0.2, noise=Noise(attitude=0.005, seed=1))
print(run.status.name, f"pitch {math.degrees(run.final['theta']):.1f} deg at {run.final['z']:.1f} m")
```

The same law in Python and in the kernel gives the same run (to 1e-9, in a test). A sample costs the call of your
function and some 40 us more. Examples: `examples/own_controller.py`, `examples/train_policy.py`.

### Environments for learning
Importing `models.gym_environment` registers `GliderStudio/Glide-v0`:

```python
import gymnasium

env = gymnasium.make("models.gym_environment:GliderStudio/Glide-v0", design="quad-bellows-glide", task="heading")
print(env.unwrapped.entries)  # what an observation holds, with units

envs = gymnasium.make_vec(  # all gliders in one call of the kernel
    "GliderStudio/Glide-v0", num_envs=1024, vectorization_mode="vector_entry_point", task="waypoint",
    initial={"depth": (5.0, 30.0), "heading": (-3.14, 3.14)}, threads=2,
)
observed, infos = envs.reset(seed=0)  # glider k has the seed 0 + k, and moves as it would alone
observed, rewards, terminated, truncated, infos = envs.step(envs.action_space.sample())
```

| argument | meaning |
|---|---|
| `design` | a `Design` or a preset's name; its schedules and its controller play no part |
| `task` | `"heading"`, `"depth_band"`, `"waypoint"`, or an object such as `HoldHeading(heading=1.0)`, or of your own |
| `reward` | a function from `Motion` to the rewards (m,) in place of the task's |
| `action` | `"cells"`: extensions, -1 and 1 the stops; `"forces"`: heave, pitch, roll by allocation, 1 the authority |
| `initial` | value or range of depth (m), roll, pitch, heading (rad); a reset's `options` take the same |
| `step_time`, `step` | time between actions (0.25 s); the RK4 step, the longest that is accurate where none is given |
| `duration` | of an episode; the mission's where none is given |

*Heading* earns 1 - 2 |error| / pi a second; *depth band* the way made forward (m) less 0.2 for each second and metre
outside; *waypoint* the metres by which it comes nearer, and ends within 5 m of it. An episode is terminated where the
surface or the bed ends a run, the motion diverges or the task is done, and truncated at its duration; the info's
`status` says which. In the vector environment it begins anew with the next step (`AutoresetMode.NEXT_STEP`).

**Accuracy.** The step is halved until it and its half agree within 1e-3 (m/s, rad, rad/s) over 30 s of random commands
to eight gliders. The quad-bellows glider takes 0.25 s: after 300 s of random commands it is typically 0.3 mm and 3e-5
rad from the adaptive kernel (tolerance 1e-10); where full strokes tumble it through stall, up to 6 cm and 0.02 rad.
**Limits.** Instruments are ideal (add noise with a wrapper); all gliders of a vector environment have one design.
"""
