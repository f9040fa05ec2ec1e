"""Owns how derived equations are printed: plain text of limited width, a LaTeX document, LaTeX blocks for a page."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from typing import Any, Literal

import sympy as sp
from sympy.printing.latex import LatexPrinter
from sympy.printing.str import StrPrinter

from models.equation_sections import Display, Written
from models.equation_symbols import latex_name, text_name
from models.equations import DesignEquations

Form = Literal["text", "latex"]
WIDTH = 118
"""Widest line of text, characters."""
TERMS = 4
"""Terms of a long sum that share a line of LaTeX."""
HEAD = r"""\documentclass{article}
\usepackage[T1]{fontenc}
\usepackage[utf8]{inputenc}
\usepackage[margin=2cm]{geometry}
\usepackage{amsmath,longtable}
\allowdisplaybreaks
\begin{document}
"""
ESCAPES = {
    "\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "$": r"\$", "&": r"\&", "#": r"\#", "_": r"\_", "%": r"\%",
    "^": r"\textasciicircum{}", "~": r"\textasciitilde{}",
}  # fmt: skip


def _natural(expression: Any) -> list[Any]:
    """Return the key by which terms stand in the order of their components: m_2 before m_10."""
    text = text_name(str(expression)).lstrip("-")
    return [(1, int(piece), "") if piece.isdigit() else (0, 0, piece) for piece in re.split(r"(\d+)", text)]


class _Ordered:
    """Gives a printer terms in their natural order."""

    def _as_ordered_terms(self, expression: Any, order: Any = None) -> list[Any]:
        return sorted(sp.Add.make_args(expression), key=_natural)


class _Text(_Ordered, StrPrinter):  # type: ignore[misc]
    def _print_Symbol(self, expression: Any) -> str:
        return text_name(expression.name)

    def _print_Abs(self, expression: Any) -> str:
        return f"|{self._print(expression.args[0])}|"


class _Latex(_Ordered, LatexPrinter):  # type: ignore[misc]
    def _print_Symbol(self, expression: Any, style: str = "plain") -> str:
        return latex_name(expression.name)

    def _print_Function(self, expression: Any, exp: Any = None) -> str:
        if not isinstance(expression, sp.core.function.AppliedUndef):
            return str(super()._print_Function(expression, exp))
        name = rf"{latex_name(type(expression).__name__)}({', '.join(map(self._print, expression.args))})"
        return name if exp is None else f"{{{name}}}^{{{exp}}}"


def to_text(expression: Any) -> str:
    """Return an expression as plain text."""
    if isinstance(expression, Written):
        return expression.text
    return str(_Text({"full_prec": False}).doprint(sp.sympify(expression))).replace("**", "^")


def to_latex(expression: Any) -> str:
    """Return an expression as LaTeX, a matrix as a `bmatrix`."""
    if isinstance(expression, Written):
        return expression.latex
    settings = {"mat_str": "bmatrix", "mat_delim": "", "ln_notation": False}
    return str(_Latex(settings).doprint(sp.sympify(expression)))


def number(value: float, digits: int = 5) -> str:
    """Return a value to so many significant digits."""
    return f"{value + 0.0:.{digits}g}"


def latex_number(value: float, digits: int = 5) -> str:
    """Return a value as LaTeX sets it."""
    mantissa, _, exponent = number(value, digits).partition("e")
    return rf"{mantissa} \cdot 10^{{{int(exponent)}}}" if exponent else mantissa


def latex_unit(unit: str) -> str:
    """Return a unit upright, its powers raised; without one, nothing."""
    if unit in ("1", ""):
        return ""
    raised = re.sub(r"([a-z])([23])", r"\1^{\2}", unit).replace(" ", r"\,")
    return rf"\,\mathrm{{{raised}}}"


def escaped(words: str) -> str:
    """Return words in which LaTeX sees no command."""
    return "".join(ESCAPES.get(letter, letter) for letter in words)


def render(equations: DesignEquations, form: Form = "text") -> str:
    """Return the whole: legend and every equation, as text or as a LaTeX document that compiles as it is."""
    return _text(equations) if form == "text" else _latex(equations)


def _text(equations: DesignEquations) -> str:
    name, model = equations.design.name, equations.design.mission.solver.model
    blocks = [f"Equations of motion of '{name}', {model}", _legend_text(equations)]
    for section in equations.sections:
        words = textwrap.fill(section.words, WIDTH)
        blocks.append("\n".join([section.title, "-" * len(section.title), words]))
        blocks += [_display_text(display) for display in section.displays]
    return "\n\n".join(blocks) + "\n"


def _legend_text(equations: DesignEquations) -> str:
    lines = ["Symbols", "-------"]
    for group in equations.legend:
        lines.append(group.title + ("" if group.entries else ": does not enter"))
        for entry in group.entries:
            unit = "" if entry.unit == "1" else f" {entry.unit}"
            value = f"{number(equations.values[entry.symbol])}{unit}"
            lines.append(f"  {to_text(entry.symbol):<10} {value:<22} {entry.words}")
    return "\n".join(lines)


def _display_text(display: Display) -> str:
    left = to_text(display.left)
    if display.right is None:
        return _wrapped(left)
    if isinstance(display.right, sp.MatrixBase):
        return _matrix_text(left, display.right)
    tail = "" if display.value is None else f" = {number(display.value)} {display.unit}"
    return _wrapped(f"{left} = {to_text(display.right)}{tail}")


def _wrapped(line: str) -> str:
    wrapper = textwrap.TextWrapper(WIDTH, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False)
    return wrapper.fill(f"  {line}")


def _matrix_text(left: str, matrix: sp.Matrix) -> str:
    """Return a matrix drawn in brackets; where that is too wide, its entries one by one."""
    cells = [[to_text(matrix[i, j]) for j in range(matrix.cols)] for i in range(matrix.rows)]
    widths = [max(len(row[j]) for row in cells) for j in range(matrix.cols)]
    margin, middle = len(left) + 5, (matrix.rows - 1) // 2
    if margin + sum(widths) + 2 * len(widths) > WIDTH:
        return _entries_text(left, cells)
    lines = []
    for i, row in enumerate(cells):
        head = f"  {left} = " if i == middle else " " * margin
        lines.append(f"{head}[{'  '.join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))}]")
    return "\n".join(lines)


def _entries_text(left: str, cells: Sequence[Sequence[str]]) -> str:
    vector = all(len(row) == 1 for row in cells)
    lines = [
        _wrapped(f"{left}[{i + 1}]{'' if vector else f'[{j + 1}]'} = {cell}")
        for i, row in enumerate(cells)
        for j, cell in enumerate(row)
        if vector or cell != "0"
    ]
    return "\n".join(lines if vector else [*lines, f"  the other entries of {left} are 0"])


def _latex(equations: DesignEquations) -> str:
    title = f"Equations of motion of {escaped(equations.design.name)}, {equations.design.mission.solver.model}"
    blocks = [HEAD + rf"\section*{{{title}}}", _legend_latex(equations)]
    for section in equations.sections:
        blocks.append(rf"\subsection*{{{escaped(section.title)}}}" + "\n" + escaped(section.words))
        blocks += [
            "\\begin{align}\n" + row + "\n\\end{align}" for display in section.displays for row in latex_rows(display)
        ]
    return "\n".join(blocks) + "\n\\end{document}\n"


def _legend_latex(equations: DesignEquations) -> str:
    rows = []
    for group in equations.legend:
        enters = "" if group.entries else ": does not enter"
        rows.append(rf"\multicolumn{{3}}{{l}}{{\textbf{{{escaped(group.title)}}}{enters}}} \\")
        for entry in group.entries:
            value = f"{latex_number(equations.values[entry.symbol])}{latex_unit(entry.unit)}"
            rows.append(rf"${to_latex(entry.symbol)}$ & {escaped(entry.words)} & ${value}$ \\")
    return "\\begin{longtable}{lll}\n" + "\n".join(rows) + "\n\\end{longtable}"


def latex_rows(display: Display) -> list[str]:
    """Return the body of each `align` that a display needs: one, or one an entry of a vector of long sums."""
    right = display.right
    if isinstance(right, sp.MatrixBase) and right.cols == 1 and max(len(str(entry)) for entry in right) > WIDTH // 2:
        left = to_latex(display.left)
        return [_sum_latex(f"{left}_{{{i + 1}}}" if "_" not in left else f"{left[:-1]},{i + 1}}}", entry, "")
                for i, entry in enumerate(right)]  # fmt: skip
    if right is None:
        return [to_latex(display.left)]
    if isinstance(right, sp.MatrixBase):
        return [f"{to_latex(display.left)} &= {to_latex(right)}"]
    tail = "" if display.value is None else f" = {latex_number(display.value)}{latex_unit(display.unit)}"
    return [_sum_latex(to_latex(display.left), right, tail)]


def _sum_latex(left: str, right: Any, tail: str) -> str:
    """Return a sum, broken into lines where it is long."""
    terms = sorted(sp.Add.make_args(sp.sympify(right)), key=_natural)
    if len(terms) <= TERMS + 1:
        return f"{left} &= {to_latex(right)}{tail}"
    lines = []
    for start in range(0, len(terms), TERMS):
        line = to_latex(sp.Add(*terms[start : start + TERMS]))
        lines.append(line if start == 0 or line.startswith("-") else f"+ {line}")
    return f"{left} &= " + " \\notag \\\\\n&\\quad ".join(lines) + tail


def latex_blocks(displays: Sequence[Display]) -> list[str]:
    """Return equations as display blocks of GitHub-flavoured Markdown: matrices alone, others together."""
    blocks: list[list[str]] = []
    together = False
    for display in displays:
        alone = isinstance(display.right, sp.MatrixBase)
        rows = [row.replace(r" \notag", "") for row in latex_rows(display)]
        if alone or not together:
            blocks.append([])
        blocks[-1] += rows
        together = not alone
    joined = (" \\\\\n".join(rows) for rows in blocks)
    return [f"```math\n\\begin{{aligned}}\n{body}\n\\end{{aligned}}\n```" for body in joined]
