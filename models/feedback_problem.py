"""Owns the problem of designing a state feedback: a glider about a trim, which states are fed back, and to which cells.

Names of states are the controller's: those it measures, and a cell's name for its extension. SI units and radians.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from models.allocation import Effectiveness, effectiveness
from models.assemble import Assembly
from models.controllability import SCALE, USUAL_SCALE, controllability
from models.controller_options import ControllerOptions
from models.controllers import MEASURED
from models.design import Design
from models.kernel.control_layout import MOST_PENDING
from models.linear_model import STILL, LinearModel
from models.linearize import linearize
from models.modes import EXTENSION, NEUTRAL, Mode
from models.operating_point import OperatingPoint
from models.problems import DesignError, Problem, pointer_to
from models.sampled_model import SampledModel, sampled_model
from models.steady_problem import assembly_of

Array = NDArray[np.float64]
SPATIAL_CHOICES = (
    ("theta", "psi", "phi", "u", "v", "w", "p", "q", "r"), ("theta", "phi", "u", "v", "w", "p", "q", "r"),
    ("theta", "u", "w", "q"), ("psi", "phi", "v", "p", "r"), ("phi", "v", "p", "r"),
)  # fmt: skip
"""States to feed back where none are named: the first of these that the cells can move as a whole."""
PLANAR_CHOICES = (("theta", "u", "w", "q"),)
SINGULAR = 1e-7
"""Singular values below this are none: rounding of the differences leaves 1e-9."""


@dataclass(frozen=True, eq=False)
class FeedbackProblem:
    """What a design of gains works on.

    `model` is the linear model with the states fed back first and the inputs in the order of `cells`; A, B those of the
    states fed back alone, the others held in trim and unnamed lags left out. `deviations` (states,) and `commands`
    (cells,) are the largest acceptable departures; `extensions` (cells,) and `state` (states,) the trim.
    """

    assembly: Assembly
    point: OperatingPoint
    options: ControllerOptions
    cells: Effectiveness
    states: tuple[str, ...]
    model: LinearModel
    A: Array
    B: Array
    deviations: Array
    commands: Array
    extensions: Array
    state: Array
    notes: tuple[str, ...]

    @property
    def design(self) -> Design:
        """The glider."""
        return self.assembly.design

    @property
    def strokes(self) -> Array:
        """Strokes, (cells,) m or rad."""
        return self.cells.span

    @property
    def simple(self) -> SampledModel:
        """The sampled model that the gains are found on: the states fed back, without delay."""
        return sampled_model(
            self.A, self.B, states=self.states, cells=self.cells.cells, sample_time=self.options.sample_time,
            sums=self.options.integrals,
        )  # fmt: skip

    def whole(self, delay: float | None = None) -> SampledModel:
        """Return the sampled model with every state and the delay (s; that of the options if not given)."""
        return sampled_model(
            self.model.A, self.model.B, states=self.model.state_names, cells=self.cells.cells,
            sample_time=self.options.sample_time, delay=self.options.delay if delay is None else delay,
            sums=self.options.integrals,
        )  # fmt: skip

    def widened(self, gains: Array) -> Array:
        """Return gains on [states fed back, integrals] with zeros for the states that are not fed back."""
        n, others = len(self.states), len(self.model.states) - len(self.states)
        return np.hstack([gains[:, :n], np.zeros((len(gains), others)), gains[:, n:]])


def feedback_problem(design: Design | Assembly, point: OperatingPoint, options: ControllerOptions) -> FeedbackProblem:
    """Return the problem of a design about an operating point.

    Raises
    ------
    DesignError
        Where a cell or state is unknown, cannot be held in this trim, or belongs to a mode that the cells cannot move.

    """
    assembly = assembly_of(design)
    cells = effectiveness(assembly.design, options.cells, pointer="/options/cells")
    most = (MOST_PENDING - 1) * options.sample_time
    if options.delay > most:
        message = f"delay {options.delay:g} s is more than {MOST_PENDING - 1} samples of {options.sample_time:g} s"
        hint = "shorten it, or sample less often"
        raise DesignError([Problem("/options/delay", message, limit=most, hint=hint)])
    if not cells.cells:
        raise DesignError([Problem("/options/cells", "no component moves: there is nothing to control with")])
    model = _of_cells(linearize(assembly, point), cells)
    states, notes = chosen_states(model, cells, options)
    kept = [name for name in model.state_names if name not in ("z", "psi") or name in states]
    fed = [_signal_of(name, cells) for name in states]
    model = ordered(model, [*fed, *(name for name in kept if name not in fed)])
    A, B = _reduced(model, len(states))
    deviation = {name: _usual_deviation(name, cells) for name in states} | dict(options.deviations)
    share = [options.shares.get(name, options.share) for name in cells.cells]
    problems = [*_unknown(options.deviations, states, "deviations", "state fed back")]
    problems += _unknown(options.shares, cells.cells, "shares", "cell under control")
    problems += _unfit_integrals(A, B * cells.span, states, options.integrals)
    if problems:
        raise DesignError(problems)
    at = dict(zip(model.state_names, (signal.value for signal in model.states), strict=True))
    return FeedbackProblem(
        assembly=assembly, point=point, options=options, cells=cells, states=states, model=model, A=A, B=B,
        deviations=np.array([deviation[name] for name in states]), commands=np.array(share) * cells.span,
        extensions=np.array([signal.value for signal in model.inputs]), state=np.array([at[name] for name in fed]),
        notes=tuple(notes),
    )  # fmt: skip


def chosen_states(
    model: LinearModel, cells: Effectiveness, options: ControllerOptions
) -> tuple[tuple[str, ...], list[str]]:
    """Return the states to feed back, and notes in words.

    Raises
    ------
    DesignError
        Where a named state is unknown, not steady in this trim, or belongs to a mode that no cell moves; where none are
        named, only if a mode that does not decay cannot be moved by any of them.

    """
    if options.states is not None:
        problems = list(_unfit(options.states, model, cells))
        if problems:
            raise DesignError(problems)
        lost = unmoved_modes(model, options.states, cells)
        if lost:
            raise DesignError(_refusals(lost, options.states, cells))
        return options.states, []
    lags = tuple(cell for cell in cells.cells if f"{EXTENSION}{cell}" in model.state_names)
    choices = SPATIAL_CHOICES if "phi" in model.state_names else PLANAR_CHOICES
    steady = [choice for choice in choices if not any(_drift(model, name) > STILL for name in choice)]
    found = [(choice, unmoved_modes(model, choice + lags, cells)) for choice in steady]
    for choice, lost in found:
        if not lost:
            left = [name for name in choices[0] if name not in choice]
            why = f"{' and '.join(left)} not fed back: not steady in this trim, or moved by no cell"
            return choice + lags, [why] if left else []
    for choice, lost in found:
        if all(mode.growth < -NEUTRAL for mode in lost):
            return choice + lags, [f"no cell moves {mode.name}, which decays by itself" for mode in lost]
    raise DesignError(_refusals(found[0][1], found[0][0], cells))


def unmoved_modes(model: LinearModel, states: Sequence[str], cells: Effectiveness) -> tuple[Mode, ...]:
    """Return the modes of the chosen states that none of the cells moves."""
    fed = [_signal_of(name, cells) for name in states]
    part = ordered(model, [*fed, *(name for name in model.state_names if name not in fed)])
    A, B = _reduced(part, len(states))
    part = replace(part, states=part.states[: len(states)], A=A, B=B)
    return tuple(each.mode for each in controllability(part, cells.span).modes if not each.movable)


def ordered(model: LinearModel, names: Sequence[str]) -> LinearModel:
    """Return the model with only the named states, in that order; the others are held."""
    kept = [model.state_names.index(name) for name in names]
    return replace(
        model, states=tuple(model.states[i] for i in kept), A=model.A[np.ix_(kept, kept)], B=model.B[kept],
        C=model.C[:, kept], drift=model.drift[kept],
    )  # fmt: skip


def _of_cells(model: LinearModel, cells: Effectiveness) -> LinearModel:
    """Return the model with only the cells under control as inputs; the others stay where they are."""
    inputs = [model.input_names.index(f"command of {cell}") for cell in cells.cells]
    held = [n for n in model.state_names if n.startswith(EXTENSION) and n.removeprefix(EXTENSION) not in cells.cells]
    part = replace(model, inputs=tuple(model.inputs[i] for i in inputs), B=model.B[:, inputs], D=model.D[:, inputs])
    return part.without(*held)


def _reduced(model: LinearModel, count: int) -> tuple[Array, Array]:
    """Return A, B of the first states alone: other states of the motion held, lags of other extensions left out."""
    A, B = model.A[:count, :count], model.B[:count].copy()
    for j, name in enumerate(model.state_names):
        if j >= count and name.startswith(EXTENSION):
            B[:, model.input_names.index(f"command of {name.removeprefix(EXTENSION)}")] += model.A[:count, j]
    return A, B


def _signal_of(name: str, cells: Effectiveness) -> str:
    return f"{EXTENSION}{name}" if name not in MEASURED and name in cells.cells else name


def _usual_deviation(name: str, cells: Effectiveness) -> float:
    if name in cells.cells:
        return 0.5 * float(cells.span[cells.cells.index(name)])
    return SCALE.get(name, USUAL_SCALE)


def _drift(model: LinearModel, name: str) -> float:
    return abs(float(model.drift[model.state_names.index(name)]))


def _unfit(states: Sequence[str], model: LinearModel, cells: Effectiveness) -> Iterator[Problem]:
    """Yield what is wrong with named states."""
    can = [name for name in MEASURED if name in model.state_names]
    can += [cell for cell in cells.cells if f"{EXTENSION}{cell}" in model.state_names]
    for i, name in enumerate(states):
        at = pointer_to("options", "states", i)
        if name not in can:
            hint = f"use {', '.join(can)}; the extension of a cell without a lag is its command"
            yield Problem(at, f"there is no state '{name}' to feed back", hint=hint)
        elif name in states[:i]:
            yield Problem(at, f"'{name}' is named twice", hint="name it once")
        elif name in ("z", "psi") and _drift(model, name) > STILL:
            rate = model.drift[model.state_names.index(name)]
            message = f"{name} changes by {rate:.3g} a second in this trim: there is nothing to hold"
            yield Problem(at, message, hint="leave it out")


def _unknown(given: Sequence[str] | dict[str, float], known: Sequence[str], field: str, what: str) -> list[Problem]:
    return [
        Problem(pointer_to("options", field, name), f"'{name}' is no {what}", hint=f"those are: {', '.join(known)}")
        for name in given if name not in known
    ]  # fmt: skip


def _unfit_integrals(A: Array, B: Array, states: Sequence[str], count: int) -> list[Problem]:
    """Say where the first states cannot all be held at set points: [A, B; C, 0] loses rank (Davison, 1976)."""
    if count > len(states):
        message = f"{count} integrals exceed the {len(states)} states"
        return [Problem("/options/integrals", message, limit=len(states))]
    n, m = B.shape
    whole = np.zeros((n + count, n + m))
    whole[:n, :n], whole[:n, n:] = A, B
    whole[n:, :count] = np.eye(count)
    held = count
    while held and np.linalg.svd(whole[: n + held], compute_uv=False)[n + held - 1 : n + held].sum() < SINGULAR:
        held -= 1
    if held == count:
        return []
    names = " and ".join([", ".join(states[: count - 1]), states[count - 1]]) if count > 1 else states[0]
    message = f"the cells cannot hold {names} at set points at once: one follows from the others, or cells are too few"
    hint = "name the states so that those to integrate come first"
    return [Problem("/options/integrals", message, limit=held, hint=hint)]


def _refusals(lost: Sequence[Mode], states: Sequence[str], cells: Effectiveness) -> list[Problem]:
    """Say which modes which cells cannot move."""
    names = " and ".join(f"'{cell}'" for cell in cells.cells)
    problems = []
    for mode in lost:
        most = [states[k] for k in np.argsort(-mode.shares)[:2] if mode.shares[k] > 0.2]
        how = "decays by itself" if mode.growth < -NEUTRAL else "does not decay by itself"
        message = f"{names} cannot move the {mode.name} (mostly {' and '.join(most)}), which {how}"
        hint = f"leave out {' and '.join(most)}, or give a cell that moves it"
        problems.append(Problem("/options/states", message, hint=hint))
    return problems
