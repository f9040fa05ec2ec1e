"""Owns what numbers and lanes (lane_types.py) do alike: choose without a branch, ask whether any is so, round alike."""

from __future__ import annotations

from llvmlite import ir
from numba.core import types
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin


def select(condition, a, b):
    """Return a where the condition holds, else b; both have been worked out."""
    return a if condition else b


def any_of(condition):
    """Whether a condition holds at all: in a single run, or in any lane."""
    return condition


def whole(x):
    """Return a float's whole part, as an integer."""
    return int(x)


def real(n):
    """Return an integer as a float."""
    return float(n)


def fused(a, b, c):
    """Return a b + c, which lanes round as numbers do: once, where the processor can."""
    return a * b + c


def define(function, arguments, kinds, emit, common):
    """Teach the compiler a function of `arguments` values; `emit(builder, kind, *values)` writes the code.

    `common(args)` returns the type in which the arguments meet, and `kinds` maps that to the type of the result.
    """

    class Template(AbstractTemplate):
        key = function

        def generic(self, args, kws):
            kind = common(args) if len(args) == arguments else None
            return signature(kinds[kind], *[kind] * arguments) if kind in kinds else None

    infer_global(function)(Template)
    for kind in kinds:
        lower_builtin(function, *[kind] * arguments)(
            lambda context, builder, sig, values, kind=kind: emit(builder, kind, *values)
        )


def define_select(is_condition, common):
    """Teach the compiler `select` for conditions of one kind and choices that meet in one type."""

    class Template(AbstractTemplate):
        key = select

        def generic(self, args, kws):
            kind = common(args[1:]) if is_condition(args[0]) else None
            return signature(kind, args[0], kind, kind) if kind is not None else None

    infer_global(select)(Template)


@lower_builtin(select, types.Any, types.Any, types.Any)
def _select(context, builder, sig, values):
    return builder.select(*values)


def _number(args):
    if all(isinstance(a, types.Integer) for a in args):
        return types.int64
    return types.float64 if all(isinstance(a, types.Integer | types.Float) for a in args) else None


def _truth(args):
    return types.boolean if args[0] == types.boolean else None


define_select(lambda condition: condition == types.boolean, _number)
define(any_of, 1, {types.boolean: types.boolean}, lambda builder, kind, a: a, _truth)
define(whole, 1, {types.float64: types.int64}, lambda builder, kind, a: builder.fptosi(a, ir.IntType(64)), _number)
define(real, 1, {types.int64: types.float64}, lambda builder, kind, a: builder.sitofp(a, ir.DoubleType()), _number)


def emit_fused(builder, kind, a, b, c):
    """Write a b + c for the compiler to contract, as jit.py allows it to everywhere in code for numbers."""
    return builder.fadd(builder.fmul(a, b, flags=("contract",)), c, flags=("contract",))


define(fused, 3, {types.float64: types.float64}, emit_fused, _number)
