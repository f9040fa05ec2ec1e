"""Draws the picture of docs/batch.md by the page's own commands: `python -m docs.make_batch`, about a minute's work."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
PICTURE = ROOT / "docs" / "img" / "batch-sweep.png"


def draw(document: Path, picture: Path) -> str:
    """Run a sweep, draw its table, and return what the example that draws says."""
    with tempfile.TemporaryDirectory() as folder:
        batch = ["-m", "studio", "batch", str(document), "-o", folder, "--format", "parquet"]
        subprocess.run([sys.executable, *batch], cwd=ROOT, check=True)
        plot = ["examples/batch_plot.py", f"{folder}/cases.parquet", str(picture)]
        done = subprocess.run([sys.executable, *plot], cwd=ROOT, check=True, capture_output=True, text=True)
    return done.stdout


if __name__ == "__main__":
    print(draw(ROOT / "examples" / "batch_sweep.json", PICTURE), end="")
