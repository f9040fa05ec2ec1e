"""Owns numbers that come several at a time: `Lanes`, one float for each of `WIDTH` designs side by side.

The physics is written once, over things that add, multiply and compare; called with these it is compiled to vector
instructions for all lanes at once. They are types of the compiler (LLVM vectors), and so exist in compiled code alone.
What would be a branch must be a `select`, since lanes may differ in what they choose.
"""

from __future__ import annotations

import math
import operator

from llvmlite import ir
from numba.core import types
from numba.core.typeconv.castgraph import Conversion
from numba.extending import lower_cast, models, register_model

from models.kernel import choice
from models.kernel.choice import any_of, define_select, emit_fused, fused, real, whole

WIDTH = 8
"""Designs integrated side by side: two registers of four doubles, so that one waits while the other computes."""

REAL, WHOLE, BIT = ir.DoubleType(), ir.IntType(32), ir.IntType(1)
WORD = ir.IntType(64)


class LanesType(types.Type):
    """A float in every lane."""

    def __init__(self):
        super().__init__(name="Lanes")

    def can_convert_from(self, typingctx, other):
        """A number is the same in every lane."""
        return Conversion.safe if isinstance(other, types.Float | types.Integer | WholeLanesType) else None


class WholeLanesType(types.Type):
    """A whole number in every lane, of 32 bits: what the processor converts floats to, several at a time."""

    def __init__(self):
        super().__init__(name="WholeLanes")

    def can_convert_from(self, typingctx, other):
        """A whole number is the same in every lane."""
        return Conversion.safe if isinstance(other, types.Integer) else None


class MaskType(types.Type):
    """A truth in every lane."""

    def __init__(self):
        super().__init__(name="Mask")

    def can_convert_from(self, typingctx, other):
        """A truth is the same in every lane."""
        return Conversion.safe if isinstance(other, types.Boolean) else None


LANES, WHOLES, MASK = LanesType(), WholeLanesType(), MaskType()
ELEMENTS = {LanesType: REAL, WholeLanesType: WHOLE, MaskType: BIT}


def _register(kind):
    class LaneModel(models.PrimitiveModel):
        def __init__(self, dmm, fe_type):
            super().__init__(dmm, fe_type, ir.VectorType(ELEMENTS[kind], WIDTH))

    register_model(kind)(LaneModel)


for _kind in ELEMENTS:
    _register(_kind)


def splat(builder, value):
    """Return the vector that holds one value in every lane."""
    vector = ir.VectorType(value.type, WIDTH)
    one = builder.insert_element(ir.Constant(vector, ir.Undefined), value, WHOLE(0))
    zeros = ir.Constant(ir.VectorType(WHOLE, WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(one, ir.Constant(vector, ir.Undefined), zeros)


@lower_cast(types.Float, LanesType)
def _float_to_lanes(context, builder, fromty, toty, value):
    return splat(builder, context.cast(builder, value, fromty, types.float64))


@lower_cast(types.Integer, LanesType)
def _integer_to_lanes(context, builder, fromty, toty, value):
    return splat(builder, context.cast(builder, value, fromty, types.float64))


@lower_cast(types.Integer, WholeLanesType)
def _integer_to_wholes(context, builder, fromty, toty, value):
    return splat(builder, builder.trunc(context.cast(builder, value, fromty, types.int64), WHOLE))


@lower_cast(WholeLanesType, LanesType)
def _wholes_to_lanes(context, builder, fromty, toty, value):
    return builder.sitofp(value, ir.VectorType(REAL, WIDTH))


@lower_cast(types.Boolean, MaskType)
def _boolean_to_mask(context, builder, fromty, toty, value):
    return splat(builder, value)


def _common(args):
    """Return the type in which lanes and numbers meet; None where there are no lanes, or they do not meet."""
    if LANES in args and all(isinstance(a, LanesType | WholeLanesType | types.Float | types.Integer) for a in args):
        return LANES
    if WHOLES in args and all(a is WHOLES or isinstance(a, types.Integer) for a in args):
        return WHOLES
    if MASK in args and all(a is MASK or a == types.boolean for a in args):
        return MASK
    return None


def define(function, arguments, kinds, emit):
    """Teach the compiler a function of lanes (choice.py)."""
    choice.define(function, arguments, kinds, emit, _common)


def call_intrinsic(builder, name, *values):
    """Call the LLVM intrinsic of this name for vectors of floats."""
    vector = values[0].type
    kind = ir.FunctionType(vector, [vector] * len(values))
    function = builder.module.declare_intrinsic(f"llvm.{name}.v{WIDTH}f64", fnty=kind)
    return builder.call(function, values)


def _arithmetic(real, whole):
    return lambda builder, kind, a, b: getattr(builder, real if kind is LANES else whole)(a, b)


def _comparison(symbol):
    def emit(builder, kind, a, b):
        if kind is LANES:
            return (builder.fcmp_unordered if symbol == "!=" else builder.fcmp_ordered)(symbol, a, b)
        return builder.icmp_signed(symbol, a, b)

    return emit


def _extreme(symbol):
    return lambda builder, kind, a, b: builder.select(_comparison(symbol)(builder, kind, b, a), b, a)


BOTH = {LANES: LANES, WHOLES: WHOLES}
for _name, _real, _whole in (("add", "fadd", "add"), ("sub", "fsub", "sub"), ("mul", "fmul", "mul")):
    for _operator in (getattr(operator, _name), getattr(operator, f"i{_name}")):
        define(_operator, 2, BOTH, _arithmetic(_real, _whole))
for _operator in (operator.truediv, operator.itruediv):
    define(_operator, 2, {LANES: LANES}, _arithmetic("fdiv", ""))
for _name, _symbol in (("lt", "<"), ("le", "<="), ("gt", ">"), ("ge", ">="), ("eq", "=="), ("ne", "!=")):
    define(getattr(operator, _name), 2, {LANES: MASK, WHOLES: MASK}, _comparison(_symbol))
for _operator in (operator.and_, operator.iand):
    define(_operator, 2, {MASK: MASK, WHOLES: WHOLES}, lambda builder, kind, a, b: builder.and_(a, b))
for _operator in (operator.or_, operator.ior):
    define(_operator, 2, {MASK: MASK, WHOLES: WHOLES}, lambda builder, kind, a, b: builder.or_(a, b))
define(operator.rshift, 2, {WHOLES: WHOLES}, lambda builder, kind, a, b: builder.ashr(a, b))
define(min, 2, BOTH, _extreme("<"))
define(max, 2, BOTH, _extreme(">"))
define(abs, 1, {LANES: LANES}, lambda builder, kind, a: call_intrinsic(builder, "fabs", a))
define(math.sqrt, 1, {LANES: LANES}, lambda builder, kind, a: call_intrinsic(builder, "sqrt", a))
define(math.floor, 1, {LANES: WHOLES}, lambda builder, kind, a: builder.fptosi(
    call_intrinsic(builder, "floor", a), ir.VectorType(WHOLE, WIDTH)
))  # fmt: skip
define(whole, 1, {LANES: WHOLES}, lambda builder, kind, a: builder.fptosi(a, ir.VectorType(WHOLE, WIDTH)))
define(real, 1, {WHOLES: LANES}, lambda builder, kind, a: builder.sitofp(a, ir.VectorType(REAL, WIDTH)))
define(fused, 3, {LANES: LANES}, emit_fused)
define(operator.neg, 1, {LANES: LANES}, lambda builder, kind, a: builder.fneg(a))


def _any(builder, kind, a):
    word = ir.IntType(WIDTH)
    return builder.icmp_unsigned("!=", builder.bitcast(a, word), word(0))


define(any_of, 1, {MASK: types.boolean}, _any)


def _chosen(args):
    """Numbers that are the same in every lane before a choice by lane are not so after it."""
    if all(isinstance(a, types.Integer) for a in args):
        return WHOLES
    return LANES if all(isinstance(a, types.Integer | types.Float) for a in args) else _common(args)


define_select(lambda condition: condition is MASK, _chosen)
