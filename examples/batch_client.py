"""Have a running studio compute a sensitivity study, and watch it: `python examples/batch_client.py ADDRESS [TOKEN]`.

ADDRESS is the studio's, http://127.0.0.1:8000 where nothing else is set; TOKEN is needed where the studio demands one.
"""

from __future__ import annotations

import sys
from pathlib import Path

from models.presets import load_preset
from server.client import Client
from server.schemas_jobs import JobRecord


def parameter(name: str, pointer: str, low: float, high: float) -> dict[str, object]:
    """Return a field of the design that varies."""
    return {"name": name, "pointer": pointer, "low": low, "high": high}


def show(job: JobRecord) -> None:
    """Print how far the job is."""
    print(f"{job.state}: {job.progress.done} of {job.progress.cases} cases, {job.progress.failed} failed", flush=True)


def main(address: str, token: str | None = None) -> None:
    """Store a design, screen three of its fields by Morris's method, rank them, and keep the table."""
    with Client(address, token) as studio:
        design = studio.create_design(load_preset("canete-dual-bellows"), name="Screened", tags=["example"])
        batch = {
            "format": "glider-batch", "version": 1, "kind": "sensitivity", "design_id": design.id,
            "metrics": ["range", "maximum_depth"], "method": {"kind": "morris", "trajectories": 4},
            "parameters": [
                parameter("front bellows", "/vehicle/components/1/position/0", 0.175, 0.185),
                parameter("centre of mass", "/vehicle/mass_properties/center_of_mass/2", 0.0008, 0.0012),
                parameter("damping", "/vehicle/damping/pitch", 0.0005, 0.0015),
            ],
        }  # fmt: skip
        job = studio.wait(studio.submit(batch).id, show)
        for metric, found in (studio.summary(job.id).indices or {}).items():
            effects = sorted(((told.value, name) for name, told in (found.mu_star or {}).items()), reverse=True)
            print(f"{metric}: " + ", ".join(f"{name} {value:.3g}" for value, name in effects))
        print("written", studio.download(job.id, Path("screened.parquet")))


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(*sys.argv[1:3])
    else:
        print(__doc__)
