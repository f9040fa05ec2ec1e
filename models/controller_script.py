"""Owns the text of the script that rebuilds a designed loop with NumPy and SciPy alone."""

from __future__ import annotations

import base64
import json
import re
import textwrap
import zlib
from typing import Any

import numpy as np

TEMPLATE = '''"""@TITLE@

Made by Glider Studio. Run it: it rebuilds the sampled closed loop from A, B and the gains, and prints its response to
@STEP@. Options: --json for numbers, --plot for a figure (matplotlib), --fly to fly the
non-linear model too (glider-studio). Imported, plant(), sampled() and closed_loop() return control.StateSpace.

The law is e = e0 - K [x - x0; T sum of the first errors], every T = SAMPLE_TIME; commands are held and come late by
DELAY. SI units and radians.
"""

import argparse
import base64
import json
import zlib

import numpy as np
from scipy.linalg import expm

STATES = @STATES@
FED_BACK = @FED_BACK@
CELLS = @CELLS@
STATE_UNITS = @STATE_UNITS@
INTEGRALS = @INTEGRALS@
SAMPLE_TIME = @SAMPLE_TIME@
DELAY = @DELAY@
WATCHED = @WATCHED@
START = np.array(@START@)
GOAL = np.array(@GOAL@)
E_START = np.array(@E_START@)
E_GOAL = np.array(@E_GOAL@)
SAMPLES = @SAMPLES@
A = np.array(@A@)
B = np.array(@B@)
K = np.array(@K@)
DESIGN = """
@DESIGN@
"""


def held_over(time):
    """Return exp(A t) and its integral times B."""
    n, m = B.shape
    whole = np.zeros((n + m, n + m))
    whole[:n, :n], whole[:n, n:] = A * time, B * time
    moved = expm(whole)
    return moved[:n, :n], moved[:n, n:]


def sampled_matrices():
    """Return F, G of X+ = F X + G u with X = [x, sums of errors, commands under way]."""
    n, m = B.shape
    whole = int(np.floor(DELAY / SAMPLE_TIME + 1e-9))
    rest = DELAY - whole * SAMPLE_TIME
    rest = 0.0 if rest <= 1e-9 * SAMPLE_TIME else rest
    late = whole + (rest > 0.0)
    first = n + INTEGRALS
    size = first + m * late
    F, G = np.zeros((size, size)), np.zeros((size, m))
    F[:n, :n] = held_over(SAMPLE_TIME)[0]
    after, new = held_over(SAMPLE_TIME - rest)
    sums = range(n, first)
    F[sums, sums] = 1.0
    F[sums, range(INTEGRALS)] = SAMPLE_TIME
    for target, age in ((new, whole), (after @ held_over(rest)[1], whole + 1)):
        if age == 0:
            G[:n] += target
        elif age <= late:
            F[:n, first + (age - 1) * m : first + age * m] += target
    if late:
        G[first : first + m] = np.eye(m)
        F[first + m :, first : size - m] = np.eye(size - first - m)
    return F, G


def feedback(size):
    """Return the gains on X: those of the states fed back, zeros, those of the sums, zeros."""
    fed, n = len(FED_BACK), len(STATES)
    wide = np.zeros((len(CELLS), size))
    wide[:, :fed] = K[:, :fed]
    wide[:, n : n + INTEGRALS] = K[:, fed:]
    return wide


def response():
    """Return times, states (samples, states) and commands (samples, cells) of the linear loop."""
    F, G = sampled_matrices()
    gains, n = feedback(len(F)), len(STATES)
    X = np.zeros(len(F))
    X[:n] = START - GOAL
    X[n + INTEGRALS :] = np.tile(E_START - E_GOAL, (len(F) - n - INTEGRALS) // len(CELLS))
    states, commands = [], []
    for _ in range(SAMPLES):
        states.append(GOAL + X[:n])
        commands.append(E_GOAL - gains @ X)
        X = F @ X - G @ (gains @ X)
    return SAMPLE_TIME * np.arange(SAMPLES), np.array(states), np.array(commands)


def plant():
    """Return the glider about its trim, in continuous time, as python-control's StateSpace."""
    import control

    inputs = ["command of " + cell for cell in CELLS]
    eye = np.eye(len(STATES))
    return control.ss(A, B, eye, 0.0, states=STATES, inputs=inputs, outputs=["y: " + name for name in STATES])


def sampled():
    """Return X+ = F X + G u with the controller's sums and the delay, as python-control's StateSpace."""
    import control

    F, G = sampled_matrices()
    return control.ss(F, G, np.eye(len(F)), 0.0, SAMPLE_TIME)


def closed_loop():
    """Return the closed loop from disturbances added to the commands, as python-control's StateSpace."""
    import control

    F, G = sampled_matrices()
    return control.ss(F - G @ feedback(len(F)), G, np.eye(len(F)), 0.0, SAMPLE_TIME)


def fly():
    """Fly the non-linear model (needs glider-studio); return times and the watched state."""
    from models.design import loads_design
    from models.simulate import simulate

    run = simulate(loads_design(zlib.decompress(base64.b64decode(DESIGN))))
    values = run.values[WATCHED]
    times = SAMPLE_TIME * np.arange(SAMPLES)
    times = times[times <= run.times[-1]]
    return times, np.interp(times, run.times, np.unwrap(values) if WATCHED in ("phi", "psi") else values)


def main():
    """Print the response."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name in ("json", "plot", "fly"):
        parser.add_argument("--" + name, action="store_true")
    chosen = parser.parse_args()
    times, states, commands = response()
    F, G = sampled_matrices()
    z = np.linalg.eigvals(F - G @ feedback(len(F)))
    watched = states[:, STATES.index(WATCHED)]
    flown = fly() if chosen.fly else None
    if chosen.json:
        told = {"times": times.tolist(), "linear": watched.tolist(), "commands": commands.tolist()}
        told["eigenvalues"] = [[value.real, value.imag] for value in z]
        told["flown"] = None if flown is None else flown[1].tolist()
        print(json.dumps(told))
        return
    print("largest eigenvalue of the sampled loop:", float(np.abs(z).max()))
    print("time [s]   " + WATCHED + " linear" + ("" if flown is None else "   flown"))
    for k in range(0, SAMPLES, max(1, SAMPLES // 30)):
        beside = "" if flown is None or k >= len(flown[0]) else f"   {flown[1][k]:.6f}"
        print(f"{times[k]:8.2f}   {watched[k]:.6f}{beside}")
    if chosen.plot:
        import matplotlib.pyplot as plt

        plt.plot(times, watched, label="linear")
        if flown is not None:
            plt.plot(*flown, label="flown")
        plt.xlabel("time [s]")
        plt.ylabel(WATCHED)
        plt.legend()
        plt.show()


if __name__ == "__main__":
    main()
'''


PLAIN = ("TITLE", "STEP", "DESIGN")
"""Values that stand inside quotes of the template."""


def rows_of(matrix: Any) -> str:
    """Return an array as a literal that reads back to the same numbers, a row a line."""
    array = np.asarray(matrix)
    if array.ndim < 2:
        return repr(array.tolist())
    return "[\n" + "".join(f"    {row!r},\n" for row in array.tolist()) + "]"


def packed(text: bytes) -> str:
    """Return bytes compressed, in lines of base64."""
    return "\n".join(textwrap.wrap(base64.b64encode(zlib.compress(text, 9)).decode("ascii"), 116))


def script_of(values: dict[str, Any]) -> str:
    """Return the script with its values put in: arrays, names and numbers by the template's names."""

    def shown(match: re.Match[str]) -> str:
        name = match[1]
        value = values[name]
        if isinstance(value, np.ndarray):
            return rows_of(value)
        return str(value) if name in PLAIN else json.dumps(value)

    return re.sub("@([A-Z_]+)@", shown, TEMPLATE)
