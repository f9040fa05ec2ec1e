"""Flies one preset of each model in a fresh process and prints the seconds spent, as JSON; `startup` runs it."""

from __future__ import annotations

import json
import time


def main() -> None:
    began = time.perf_counter()
    from models.presets import load_preset
    from models.simulate import simulate

    designs = {"planar": load_preset("canete-dual-bellows"), "spatial": load_preset("seawing-spiral")}
    seconds = {"imports": time.perf_counter() - began}
    for name, design in designs.items():
        began = time.perf_counter()
        simulate(design)
        seconds[name] = time.perf_counter() - began
    print(json.dumps(seconds), flush=True)


if __name__ == "__main__":
    main()
