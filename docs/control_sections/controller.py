"""Owns the section of docs/control.md that says what the controller is: laws, signs, sources, sampling, allocation."""

from __future__ import annotations

from docs.formatting import num
from models.allocation import LEAST_EFFORT
from models.kernel.allocate import ITERATIONS
from models.kernel.control_layout import MOST_PENDING
from models.kernel.guidance import BACK_SHARE

DIAGRAM = """```
 mission       guidance            loops                   allocation      actuators     glider
 depth band -> phase ------------> heave F --------------+
               pitch wanted -----> pitch loop: moment M -+-> bounded    -> rate, lag, -> 6 DOF
 heading,      heading wanted ---> heading loop: bank    |   least         stops         (or planar)
 waypoints, -> or bank wanted ---> roll loop: moment K --+   squares                       |
 station         ^                   ^        ^               |                            |
                 |                   |        +- what is missing (anti-windup)             |
                 +-------------------+---------- instruments: sampled, noisy <-------------+
                        every T_s; commands reach the actuators after T_d, held in between
```"""

LAWS = """```
pitch     M = sat(M_phase + k_p (theta* - theta) + I - k_d q)
bank      K = sat(k_p (phi* - phi) + I - k_d p)
heading   phi* = s sat(k_p wrap(psi* - psi) + I - k_d r)         s = 1 on dives, -1 on climbs ("opposite")
integral  I <- sat(I + T_s (k_i (error) - (missing) / T_t))
line      psi* = chi - atan((e + sigma E) / Delta)               chi: course of the leg, e: off it to starboard
          E <- E + T_s Delta e / ((e + sigma E)^2 + Delta^2)
cells     minimize |A x - b|^2 / 2 + sum r_i x_i^2 / 2   with low <= x <= high      b = [F, M, K], scaled
feedback  e = e_0(s) - K(s) (x - x_0(s)) - K_i(s) (integral of the first of x - x_0)
```"""


def section() -> str:
    """Return the section."""
    return f"""## What the controller is

{DIAGRAM}

A controller is part of a design (`mission.control.controller`) and runs inside the simulation. One kind is the cascade
above. The other is state feedback from a table of trims and gains over a set point. Cells that it does not name may
follow schedules.

### Laws

{LAWS}

- **Phase.** With a depth band the glider is heavy until it sees the bottom of the band, and light until it sees the
  top. Phase sets heave F, pitch wanted and the moment M_phase to which the loop adds. Each loop keeps one integral for
  dives and one for climbs, since their trims differ.
- **Heading.** A glider turns by banking: the heading loop asks for a bank, never for a yaw moment. On climbs lift
  points down in body axes, so the bank that turns to starboard is to port: `climb_bank: opposite`. For the quad glider
  and its twin that is right; with `same` the heading runs away on climbs (`tests/models/test_guidance.py`).
- **Line of sight.** Fossen (2011, chapter 10), with the integral of Børhaug, Pavlov and Pettersen (2008). It begins
  anew on each leg. Without a lookahead the glider heads straight for the waypoint. A waypoint is done within its
  radius, or once passed abeam.
- **Station.** Within the radius it spirals with a bank; beyond, it heads for the centre until it is within
  {num(BACK_SHARE, 1)} of the radius.
- **Anti-windup.** By back-calculation (Åström and Hägglund, 2006, section 3.5): an integral gives back, in the time
  T_t, what the loop's limit cut off and what the allocation could not make. The integral itself stays within the
  loop's limit. State feedback holds its integrals while a cell is at a stop.

### Signs and units

Heave F is a change of net buoyancy, N, up. Pitch M is a moment, N m, nose up; roll K, starboard down. All are changes
from those with every cell at neutral, level, by the density at the surface. Pitch, bank and heading are those of
[spatial.md](spatial.md), rad; heading 0 is north, π/2 east.

### What is measured

Depth, roll, pitch, heading, velocity through the water, angular velocity, place; each with normal noise of a stated
deviation, none by default. The same seed gives the same noise (SplitMix64 and Box-Muller, a function of seed and
sample alone). **Place under water is idealised**: a real glider has fixes at the surface and dead reckoning between.
There is no bias, no drift and no filter.

### Sampling and delay

Every T_s from time 0 the glider is measured and commands are worked out; they reach the actuators after T_d (at most
{MOST_PENDING - 1} samples) and are held. A command that differs from the last by less than the deadband (a share of
the stroke) is not passed on. Samples and arrivals are breakpoints of the integration, so a run under control is, to
the integrator's tolerance, the glide of its own commands as a schedule (`test_closed_loop`).

### Allocation

A (3 × cells) holds what a stroke of each cell does to heave, pitch and roll, each axis divided by the authority of all
cells on it; x is the extension from neutral in strokes. Weights say which axis counts more when the stops allow not
all; efforts r_i, times {num(1e6 * LEAST_EFFORT, 0)} × 10⁻⁶, decide what the wish leaves open: four cells have one
freedom more than axes. Moving masses fit in the same matrix, so the movable-mass twin flies by the same laws.
A cell that is not under control counts as at neutral, wherever its schedule has it: leave out a failed cell, and the
others know nothing of what it does.

It is solved by its dual. With the misfit l = b − A x, each cell is x_i = clip(a_i · l / r_i): three unknowns, however
many cells. The gradient of the dual is piecewise linear, so Newton's method with an exact line search ends after
finitely many steps (Sun, 1997; at most {ITERATIONS} here). That is why: no matrix whose size hangs on the number of
cells, no active-set bookkeeping, no allocation of memory, and the exact optimum at the stops, which a clipped
pseudo-inverse misses. Surveyed by Johansen and Fossen (2013). What cannot be made is told in `heave_missing`,
`pitch_moment_missing` and `roll_moment_missing`.
"""
