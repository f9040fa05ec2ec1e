"""Simulate the paper's glide and save it: `python examples/one_glide.py`."""

from pathlib import Path

from models.presets import load_preset
from models.simulate import simulate

run = simulate(load_preset("canete-dual-bellows"))
print(run.status.name, {name: round(value, 3) for name, value in run.final.items() if name in ("t", "x", "z")})
print(run.data["theta"].sel(time=6.0, method="nearest").item(), run.data["theta"].attrs["units"])
run.to_netcdf(Path("glide.nc"))
