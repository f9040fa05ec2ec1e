"""Owns the design of controllers as a service: from options to an answer, or to a file. It knows no HTTP."""

from __future__ import annotations

from models.assemble import assemble
from models.controller_design import ControllerDesign, trim_of_options
from models.controller_export import to_mat, to_script
from models.controller_request import design_as_asked
from models.design import Design
from models.gain_table import GainTable
from models.limits import Limits
from models.loop_suggestion import LoopSuggestion, suggest_loops
from models.problems import DesignError, Problem, pointer_to
from models.simulate import Control
from models.warm import warm_analyses
from server.analyses import options_sent_at
from server.schemas_control import ControllerDesignOptions, DesignedController

Result = ControllerDesign | GainTable | LoopSuggestion


def design_for(
    design: Design, options: ControllerDesignOptions, limits: Limits, *, flown_within: Limits, control: Control
) -> Result:
    """Return the controller that the options ask for; waits for the compiler first.

    The design keeps within the first limits, its flights within the others; `control` stops them.

    Raises
    ------
    DesignError
        Where there is no such controller, or an option has no use for this kind, with pointers below /options.

    """
    if options.unused:
        hint = "leave it out, or design a state feedback"
        raise DesignError(
            Problem(pointer_to("options", name), f"first gains of loops have no use for {name}", hint=hint)
            for name in options.unused
        )
    warm_analyses()
    assembly = assemble(design, limits)
    with options_sent_at():
        if options.kind == "cascade":
            trim = trim_of_options(assembly, options)
            return suggest_loops(
                assembly, trim, heading=options.trim.heading, sample_time=options.sample_time, delay=options.delay
            )
        return design_as_asked(assembly, options, limits=flown_within, control=control)


def answer_of(result: Result) -> DesignedController:
    """Return a result as it goes on the wire."""
    kinds = {"feedback": ControllerDesign, "table": GainTable, "cascade": LoopSuggestion}
    told = {name: result.as_dict() if isinstance(result, kind) else None for name, kind in kinds.items()}
    return DesignedController.model_validate(told, strict=False)


def file_of(result: Result, ending: str) -> bytes:
    """Return a result as a file: `.mat` (MATLAB) or `.py` (a script).

    Raises
    ------
    DesignError
        Where it is not a design about one trim, of which alone there are files.

    """
    if not isinstance(result, ControllerDesign):
        raise DesignError(
            [Problem("/options", f"only a state feedback about one trim has a {ending} file", hint="ask for JSON")]
        )
    return to_mat(result) if ending == ".mat" else to_script(result).encode()
