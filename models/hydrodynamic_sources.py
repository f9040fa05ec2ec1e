"""Owns the union of hydrodynamic sources that a design may hold, each in a file of its own."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from models.hydrodynamics import PolarTable
from models.hydrodynamics_angles import AngleTable
from models.hydrodynamics_coefficients import CoefficientForm

Hydrodynamics = Annotated[PolarTable | AngleTable | CoefficientForm, Field(discriminator="kind")]
