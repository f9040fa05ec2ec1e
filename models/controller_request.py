"""Owns one door to the design of controllers for whoever has plain options: from a JSON object to a result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from models.assemble import Assembly
from models.controller_design import ControllerDesign, design_controller
from models.controller_options import ControllerOptions
from models.design import Design
from models.gain_table import GainTable, design_table
from models.limits import DEFAULT_LIMITS, Limits
from models.problems import DesignError, Problem, problems_from_validation
from models.simulate import Control


def controller_options(given: Mapping[str, Any]) -> ControllerOptions:
    """Return options from a JSON object.

    Raises
    ------
    DesignError
        Where they are not what they may be, with pointers below /options.

    """
    try:
        return ControllerOptions.model_validate(given)
    except ValidationError as error:
        told = problems_from_validation(error, given)
        raise DesignError(Problem(f"/options{p.pointer}", p.message, p.limit, p.hint) for p in told) from error


def design_as_asked(
    design: Design | Assembly, options: ControllerOptions | Mapping[str, Any], *, limits: Limits = DEFAULT_LIMITS,
    control: Control | None = None,
) -> ControllerDesign | GainTable:  # fmt: skip
    """Return the state feedback about one trim, or the table of them, that the options ask for.

    Flights keep within the limits; `control` stops them, and a table between its rows.

    Both have `controller` (the document for a mission), `mission(duration=...)`, `warnings` and `as_dict()`.

    Raises
    ------
    DesignError
        Where the options are not what they may be, or there is no such controller.

    """
    asked = options if isinstance(options, ControllerOptions) else controller_options(options)
    if asked.table is not None:
        return design_table(design, asked, limits=limits, control=control)
    return design_controller(design, asked, limits=limits, control=control)
