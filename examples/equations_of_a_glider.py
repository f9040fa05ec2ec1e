"""Print the paper's equations for one's own components: `python examples/equations_of_a_glider.py`."""

from __future__ import annotations

from models.equation_text import render
from models.equations import derive_equations
from models.presets import load_preset

equations = derive_equations(load_preset("three-cell-glider"))
print(render(equations, "text"))
print(render(equations.with_numbers(), "latex")[:600], "...", sep="\n")
