"""The kernel also runs as plain Python, for a debugger or for coverage, and gives the same glide."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from models.presets import load_preset
from models.simulate import simulate

SCRIPT = """
from models.presets import load_preset
from models.simulate import simulate
design = load_preset("three-cell-glider")
mission = design.mission.model_copy(update={"duration": 4.0})
print(simulate(design.model_copy(update={"mission": mission})).final["z"])
"""


def test_without_compilation_the_glide_is_the_same():
    design = load_preset("three-cell-glider")
    short = design.model_copy(update={"mission": design.mission.model_copy(update={"duration": 4.0})})
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], cwd=Path(__file__).parents[2], capture_output=True, text=True, check=True,
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
    )  # fmt: skip
    # fused multiply-add rounds once where plain Python rounds twice
    assert float(done.stdout) == pytest.approx(simulate(short).final["z"], abs=1e-10)
