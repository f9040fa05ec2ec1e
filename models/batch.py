"""Owns the simulation of many designs at once."""

from __future__ import annotations

from collections.abc import Sequence

from models.assemble import Assembly
from models.limits import DEFAULT_LIMITS, Limits
from models.run import Run
from models.simulate import Control, run_assembly


def run_batch(
    assemblies: Sequence[Assembly], *, limits: Limits = DEFAULT_LIMITS, control: Control | None = None
) -> list[Run]:
    """Return one run for each assembly, in their order."""
    return [run_assembly(assembly, limits=limits, control=control) for assembly in assemblies]
