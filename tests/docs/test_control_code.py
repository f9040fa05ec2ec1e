"""The code printed in docs/control.md runs as it stands, section by section."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "control.md").read_text()
SECTIONS = {
    part.splitlines()[0]: "".join(re.findall(r"^```python\n(.*?)^```", part, re.S | re.M))
    for part in re.split(r"^## ", PAGE, flags=re.M)[1:]
}
CODE = {title: code for title, code in SECTIONS.items() if code}


def test_there_is_code_to_run():
    assert {"Designing a controller", "Your own controller and Gymnasium"} <= set(CODE)


@pytest.mark.parametrize("title", CODE)
def test_it_runs(title, tmp_path):
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", CODE[title]], cwd=tmp_path, capture_output=True, text=True,
        env={"PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout
