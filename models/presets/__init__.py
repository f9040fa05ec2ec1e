"""The designs that come with the program, each with its source and what it is not; `build` writes the files."""

from __future__ import annotations

from importlib.resources import files

from models.design import Design, loads_design


def preset_ids() -> tuple[str, ...]:
    """Return the identifiers of all presets, in the order in which they are shown."""
    return (
        "canete-dual-bellows", "three-cell-glider",
        "quad-bellows-glide", "quad-bellows-spiral", "quad-bellows-s-turn", "quad-bellows-yo-yo",
        "quad-bellows-heading", "quad-bellows-waypoints", "quad-bellows-station", "movable-mass-twin",
        "seawing-spiral", "slocum-glide",
    )  # fmt: skip


def load_preset(preset_id: str) -> Design:
    """Return a preset; raises `KeyError` where there is none of this name."""
    if preset_id not in preset_ids():
        raise KeyError(preset_id)
    return loads_design(files(__package__).joinpath(f"{preset_id}.json").read_bytes())
