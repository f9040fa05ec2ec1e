"""Owns arrays and records of lanes: their types, and how they are made of arrays; lane_items.py reads and writes them.

`Woven` arrays hold the lanes' numbers side by side: their last axis, of `WIDTH`, is not seen by who reads them. Woven
records are records every field of which is one of lanes. `Tables` are left as they are: each lane reads its own rows of
one array in which tables follow one another, equal ones shared.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import extending
from numba.core import cgutils, types
from numba.extending import models, register_model
from numba.np.arrayobj import populate_array

from models.kernel.lane_types import WHOLE, WHOLES, WIDTH, WORD
from models.kernel.params import BODY, PART
from models.kernel.spatial_layout import MEMBER, SPACE

intrinsic: Any = extending.intrinsic
ALIKE = ("moves", "rolls")
"""Fields that lanes have in common though they are floats; so are integers. They are read in the first lane."""
LAWS = ("law_start", "law_count")
"""The integers of a part that lanes have in common; its others are each design's own, and lanes cannot read them."""


class Woven(types.Type):
    """An array of lanes; `ndim` without that of the lanes."""

    def __init__(self, ndim):
        self.ndim = ndim
        super().__init__(name=f"Woven({ndim})")


class WovenPick(types.Type):
    """A row of a woven array of two dimensions, another in every lane."""

    def __init__(self):
        super().__init__(name="WovenPick")


class WovenRecords(types.Type):
    """Records of lanes."""

    def __init__(self, kind):
        self.kind = kind
        super().__init__(name=f"WovenRecords({kind})")


class WovenRecord(types.Type):
    """One of them."""

    def __init__(self, kind):
        self.kind = kind
        super().__init__(name=f"WovenRecord({kind})")


class Tables(types.Type):
    """A table for every lane."""

    def __init__(self, dtype, ndim):
        self.dtype, self.ndim = dtype, ndim
        super().__init__(name=f"Tables({dtype}, {ndim})")


class TableRow(types.Type):
    """A row of each lane's table."""

    def __init__(self):
        super().__init__(name="TableRow")


RECORDS: dict[str, Any] = {"body": BODY, "parts": PART, "space": SPACE, "members": MEMBER}
POINTER = types.CPointer(types.float64)


def _struct(kind, fields):
    class LaneModel(models.StructModel):
        def __init__(self, dmm, fe_type):
            super().__init__(dmm, fe_type, fields(fe_type))

    register_model(kind)(LaneModel)


_struct(Woven, lambda t: [("data", POINTER), *((f"n{k}", types.intp) for k in range(t.ndim))])
_struct(WovenPick, lambda t: [("data", POINTER), ("row", WHOLES), ("columns", types.intp)])
_struct(WovenRecords, lambda t: [("data", POINTER), ("rows", types.intp)])
_struct(WovenRecord, lambda t: [("data", POINTER)])
_struct(Tables, lambda t: [
    ("data", types.CPointer(t.dtype)), ("first", WHOLES), ("rows", WHOLES),
    *((f"n{k}", types.intp) for k in range(1, t.ndim)),
])  # fmt: skip
_struct(TableRow, lambda t: [("data", POINTER), ("start", WHOLES), ("columns", types.intp)])


@intrinsic
def woven(typingctx, words, start, lengths):
    """Return the woven array of these lengths (a tuple) that begins at a row of `words` (rows, WIDTH)."""
    kind = Woven(len(lengths))

    def emit(context, builder, sig, args):
        made = cgutils.create_struct_proxy(kind)(context, builder)
        made.data = _row_of(context, builder, sig, args)
        for k, length in enumerate(cgutils.unpack_tuple(builder, args[2])):
            setattr(made, f"n{k}", length)
        return made._getvalue()

    return kind(words, types.intp, types.UniTuple(types.intp, len(lengths))), emit


def _row_of(context, builder, sig, args):
    source = context.make_array(sig.args[0])(context, builder, args[0])
    return builder.gep(source.data, [builder.mul(args[1], WORD(WIDTH))])


def _maker(name):
    kind = WovenRecords(name)

    @intrinsic
    def make(typingctx, words, start, rows):
        """Return the woven records that begin at a row of `words`."""

        def emit(context, builder, sig, args):
            made = cgutils.create_struct_proxy(kind)(context, builder)
            made.data, made.rows = _row_of(context, builder, sig, args), args[2]
            return made._getvalue()

        return kind(words, types.intp, types.intp), emit

    return make


woven_body, woven_parts, woven_space, woven_members = (_maker(name) for name in RECORDS)


@intrinsic
def tables(typingctx, array, spans):
    """Return the tables that follow one another in `array`; `spans` (2, WIDTH) int32: first row and rows by lane."""
    kind = Tables(array.dtype, array.ndim)

    def emit(context, builder, sig, args):
        source, rows = (context.make_array(t)(context, builder, v) for t, v in zip(sig.args, args, strict=True))
        made = cgutils.create_struct_proxy(kind)(context, builder)
        made.data = source.data
        vector = ir.VectorType(WHOLE, WIDTH).as_pointer()
        made.first = builder.load(builder.bitcast(rows.data, vector), align=4)
        made.rows = builder.load(builder.bitcast(builder.gep(rows.data, [WORD(WIDTH)]), vector), align=4)
        for k, length in enumerate(cgutils.unpack_tuple(builder, source.shape)[1:], start=1):
            setattr(made, f"n{k}", length)
        return made._getvalue()

    return kind(array, spans), emit


@intrinsic
def rows_of(typingctx, array, first, end):
    """Return the rows of an array from `first` to `end`, which is left out, as an array of the same type."""

    def emit(context, builder, sig, args):
        whole = context.make_array(sig.args[0])(context, builder, args[0])
        made = context.make_array(sig.args[0])(context, builder)
        shape, strides = (cgutils.unpack_tuple(builder, values) for values in (whole.shape, whole.strides))
        start = builder.mul(args[1], strides[0])
        data = builder.bitcast(cgutils.pointer_add(builder, whole.data, start), whole.data.type)
        shape = [builder.sub(args[2], args[1]), *shape[1:]]
        populate_array(made, data=data, shape=shape, strides=strides, itemsize=whole.itemsize, meminfo=None)
        return made._getvalue()

    return array(array, types.intp, types.intp), emit
