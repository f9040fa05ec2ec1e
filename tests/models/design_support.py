"""Owns what the tests of designed controllers share: gliders in uniform water, and designs about a dive."""

from __future__ import annotations

from typing import Any

from models.controller_design import ControllerDesign, design_controller
from models.controller_options import ControllerOptions
from models.design import Design, parse_design
from models.presets import load_preset

DIVE = {"targets": {"glide_angle": -0.5, "speed": 0.2}, "depth": 50.0}


def uniform(preset: str = "quad-bellows-glide", **vehicle: Any) -> Design:
    """A preset in water of one density, so that a glide stays a trim as it sinks, and integrated with care.

    The hull is rigid, as compression would change the net weight with depth.
    """
    document = load_preset(preset).model_dump(mode="json")
    document["mission"]["environment"]["water"] = {"density": 999.0}
    document["mission"]["solver"] |= {"tolerance": 1e-11}
    for component in document["vehicle"]["components"]:
        if component.get("bulk_modulus") is not None:
            component["bulk_modulus"] = None
    document["vehicle"] |= vehicle
    return parse_design(document)


def designed(design: Design | None = None, **options: Any) -> ControllerDesign:
    """A design about the dive."""
    return design_controller(design or uniform(), ControllerOptions(**({"trim": DIVE} | options)))


def planar_problem(**options: Any) -> ControllerDesign:
    """A planar glider with one moving mass and no lag: one loop."""
    design = uniform("slocum-glide")
    return design_controller(design, ControllerOptions(**({"sample_time": 0.5} | options)))


def level_cells() -> Design:
    """Two cells on the centre line: nothing rolls or turns the glider."""
    document = uniform().model_dump(mode="json")
    for component in document["vehicle"]["components"]:
        x, _y, z = component["position"]
        component["position"] = [x, 0.0, z]
    return parse_design(document)
