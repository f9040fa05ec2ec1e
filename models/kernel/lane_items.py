"""Owns how woven arrays, woven records and tables (lane_arrays.py) are indexed, written and asked for their shape."""

from __future__ import annotations

import operator

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_getattr, infer_global, signature
from numba.extending import lower_builtin, lower_getattr, lower_getattr_generic

from models.kernel.lane_arrays import (
    ALIKE,
    LAWS,
    RECORDS,
    TableRow,
    Tables,
    Woven,
    WovenPick,
    WovenRecord,
    WovenRecords,
)
from models.kernel.lane_types import LANES, REAL, WHOLE, WHOLES, WIDTH, WORD


def _get(context, builder, kind, value):
    return cgutils.create_struct_proxy(kind)(context, builder, value=value)


def _lanes_at(builder, data, index):
    """Return the pointer to the lanes at an index of a woven array."""
    place = builder.gep(data, [builder.mul(index, WORD(WIDTH))])
    return builder.bitcast(place, ir.VectorType(REAL, WIDTH).as_pointer())


def _load(builder, data, index):
    return builder.load(_lanes_at(builder, data, index), align=8)


def _each(builder, element, load):
    """Return the vector whose lanes are `load(lane)`."""
    vector = ir.Constant(ir.VectorType(element, WIDTH), ir.Undefined)
    for lane in range(WIDTH):
        vector = builder.insert_element(vector, load(lane), WHOLE(lane))
    return vector


def _gather(builder, data, indices):
    """Return what stands at an index of `data` for every lane; indices of 32 bits."""
    wide = builder.sext(indices, ir.VectorType(WORD, WIDTH))
    return _each(builder, data.type.pointee, lambda lane: builder.load(
        builder.gep(data, [builder.extract_element(wide, WHOLE(lane))]), align=8
    ))  # fmt: skip


def _whole_splat(context, builder, value):
    return context.cast(builder, value, types.intp, WHOLES)


class GetItem(AbstractTemplate):
    """Indexing of woven arrays, records and tables."""

    key = operator.getitem

    def generic(self, args, kws):
        """An index is a number, a whole number in every lane for tables, or a tuple of them."""
        array, index = args
        result = _indexed(array, index)
        if result is None:
            return None
        if isinstance(index, types.Integer):
            index = types.intp
        elif index is not WHOLES:
            index = types.Tuple([WHOLES if kind is WHOLES else types.intp for kind in index.types])
        return signature(result, array, index)


def _all_whole(kinds):
    return all(isinstance(kind, types.Integer) for kind in kinds)


def _indexed(array, index):
    """Return the type of what stands at an index; None where there is no such index."""
    whole = isinstance(index, types.Integer)
    if isinstance(array, Woven):
        if whole:
            return LANES if array.ndim == 1 else Woven(array.ndim - 1)
        if index is WHOLES and array.ndim == 2:
            return WovenPick()
        kinds = list(getattr(index, "types", ()))
        if len(kinds) != array.ndim:
            return None
        first, *others = kinds
        by_lane = first is WHOLES and array.ndim == 2
        return LANES if (by_lane or isinstance(first, types.Integer)) and _all_whole(others) else None
    if isinstance(array, WovenRecords) and whole:
        return WovenRecord(array.kind)
    if isinstance(array, WovenPick | TableRow) and whole:
        return LANES
    if isinstance(array, Tables):
        if array.ndim == 1:
            return (WHOLES if array.dtype == types.int64 else LANES) if index is WHOLES or whole else None
        if index is WHOLES or whole:
            return TableRow()
        return LANES if isinstance(index, types.BaseTuple) and len(index) == 2 else None
    return None


infer_global(operator.getitem)(GetItem)


@lower_builtin(operator.getitem, Woven, types.Integer)
def _woven_item(context, builder, sig, args):
    array = _get(context, builder, sig.args[0], args[0])
    if sig.args[0].ndim == 1:
        return _load(builder, array.data, args[1])
    inner = cgutils.create_struct_proxy(sig.return_type)(context, builder)
    size = WORD(1)
    for k in range(1, sig.args[0].ndim):
        size = builder.mul(size, getattr(array, f"n{k}"))
        setattr(inner, f"n{k - 1}", getattr(array, f"n{k}"))
    inner.data = builder.gep(array.data, [builder.mul(builder.mul(args[1], size), WORD(WIDTH))])
    return inner._getvalue()


@lower_builtin(operator.getitem, Woven, types.BaseTuple)
def _woven_element(context, builder, sig, args):
    array = _get(context, builder, sig.args[0], args[0])
    indices = cgutils.unpack_tuple(builder, args[1])
    if sig.args[1][0] is WHOLES:
        return _own_lane(context, builder, array.data, indices[0], array.n1, indices[1])
    flat = indices[0]
    for k, index in enumerate(indices[1:], start=1):
        flat = builder.add(builder.mul(flat, getattr(array, f"n{k}")), index)
    return _load(builder, array.data, flat)


def _own_lane(context, builder, data, row, columns, column):
    """Return each lane's own number in a row that differs by lane."""
    place = builder.add(
        builder.mul(row, _whole_splat(context, builder, columns)), _whole_splat(context, builder, column)
    )
    lanes = ir.Constant(ir.VectorType(WHOLE, WIDTH), list(range(WIDTH)))
    width = ir.Constant(ir.VectorType(WHOLE, WIDTH), [WIDTH] * WIDTH)
    return _gather(builder, data, builder.add(builder.mul(place, width), lanes))


@lower_builtin(operator.getitem, Woven, type(WHOLES))
def _woven_pick(context, builder, sig, args):
    array = _get(context, builder, sig.args[0], args[0])
    pick = cgutils.create_struct_proxy(sig.return_type)(context, builder)
    pick.data, pick.row, pick.columns = array.data, args[1], array.n1
    return pick._getvalue()


@lower_builtin(operator.getitem, WovenPick, types.Integer)
def _pick_item(context, builder, sig, args):
    pick = _get(context, builder, sig.args[0], args[0])
    return _own_lane(context, builder, pick.data, pick.row, pick.columns, args[1])


@lower_builtin(operator.getitem, WovenRecords, types.Integer)
def _records_item(context, builder, sig, args):
    records = _get(context, builder, sig.args[0], args[0])
    record = cgutils.create_struct_proxy(sig.return_type)(context, builder)
    size = WIDTH * len(RECORDS[sig.args[0].kind].names)
    record.data = builder.gep(records.data, [builder.mul(args[1], WORD(size))])
    return record._getvalue()


def _table_index(context, builder, table, index_type, index):
    if index_type is not WHOLES:
        index = _whole_splat(context, builder, index)
    return builder.add(table.first, index)


@lower_builtin(operator.getitem, Tables, type(WHOLES))
@lower_builtin(operator.getitem, Tables, types.Integer)
def _table_item(context, builder, sig, args):
    table = _get(context, builder, sig.args[0], args[0])
    index = _table_index(context, builder, table, sig.args[1], args[1])
    if sig.args[0].ndim == 1:
        found = _gather(builder, table.data, index)
        return builder.trunc(found, ir.VectorType(WHOLE, WIDTH)) if sig.return_type is WHOLES else found
    row = cgutils.create_struct_proxy(sig.return_type)(context, builder)
    row.data, row.columns = table.data, table.n1
    row.start = builder.mul(index, _whole_splat(context, builder, table.n1))
    return row._getvalue()


@lower_builtin(operator.getitem, Tables, types.BaseTuple)
def _table_element(context, builder, sig, args):
    table = _get(context, builder, sig.args[0], args[0])
    row, column = cgutils.unpack_tuple(builder, args[1])
    index = _table_index(context, builder, table, sig.args[1][0], row)
    start = builder.mul(index, _whole_splat(context, builder, table.n1))
    return _row_element(builder, table.data, start, column)


@lower_builtin(operator.getitem, TableRow, types.Integer)
def _row_item(context, builder, sig, args):
    row = _get(context, builder, sig.args[0], args[0])
    return _row_element(builder, row.data, row.start, args[1])


def _row_element(builder, data, start, column):
    return _gather(builder, builder.gep(data, [column]), start)


class SetItem(AbstractTemplate):
    """Writing lanes into a woven array."""

    key = operator.setitem

    def generic(self, args, kws):
        """One index of an array of one dimension, or as many as it has."""
        array, index, _value = args
        if not isinstance(array, Woven):
            return None
        if isinstance(index, types.Integer) and array.ndim == 1:
            return signature(types.none, array, types.intp, LANES)
        if isinstance(index, types.BaseTuple) and len(index) == array.ndim == 2:
            return signature(types.none, array, types.UniTuple(types.intp, 2), LANES)
        return None


infer_global(operator.setitem)(SetItem)


@lower_builtin(operator.setitem, Woven, types.Integer, type(LANES))
def _set_item(context, builder, sig, args):
    array = _get(context, builder, sig.args[0], args[0])
    builder.store(args[2], _lanes_at(builder, array.data, args[1]), align=8)


@lower_builtin(operator.setitem, Woven, types.BaseTuple, type(LANES))
def _set_element(context, builder, sig, args):
    array = _get(context, builder, sig.args[0], args[0])
    row, column = cgutils.unpack_tuple(builder, args[1])
    index = builder.add(builder.mul(row, array.n1), column)
    builder.store(args[2], _lanes_at(builder, array.data, index), align=8)


def _is_alike(kind, name):
    return name in ALIKE or RECORDS[kind][name].kind == "i"


@infer_getattr
class RecordFields(AttributeTemplate):
    """The fields of a woven record."""

    key = WovenRecord

    def generic_resolve(self, record, name):  # type: ignore[override]  # the base has a mark in its place
        """A field is one of lanes, or a number where lanes have it in common."""
        dtype = RECORDS[record.kind]
        if name not in dtype.names or (record.kind == "parts" and dtype[name].kind == "i" and name not in LAWS):
            return None
        if not _is_alike(record.kind, name):
            return LANES
        return types.int64 if dtype[name].kind == "i" else types.float64


@lower_getattr_generic(WovenRecord)
def _field(context, builder, kind, value, name):
    record = _get(context, builder, kind, value)
    index = WORD(RECORDS[kind.kind].names.index(name))
    if not _is_alike(kind.kind, name):
        return _load(builder, record.data, index)
    place = builder.gep(record.data, [builder.mul(index, WORD(WIDTH))])
    if RECORDS[kind.kind][name].kind == "i":
        place = builder.bitcast(place, WORD.as_pointer())
    return builder.load(place, align=8)


@infer_getattr
class WovenShape(AttributeTemplate):
    """The shape of a woven array, without its lanes."""

    key = Woven

    def resolve_shape(self, array):
        """As many lengths as dimensions."""
        return types.UniTuple(types.intp, array.ndim)


@lower_getattr(Woven, "shape")
def _woven_shape(context, builder, kind, value):
    array = _get(context, builder, kind, value)
    return cgutils.pack_array(builder, [getattr(array, f"n{k}") for k in range(kind.ndim)])


@infer_getattr
class RecordsShape(AttributeTemplate):
    """How many records there are."""

    key = WovenRecords

    def resolve_shape(self, array):
        """One length."""
        return types.UniTuple(types.intp, 1)


@lower_getattr(WovenRecords, "shape")
def _records_shape(context, builder, kind, value):
    return cgutils.pack_array(builder, [_get(context, builder, kind, value).rows])


@infer_getattr
class TablesShape(AttributeTemplate):
    """The rows of each lane's table, and the columns of all."""

    key = Tables

    def resolve_shape(self, table):
        """Rows may differ by lane."""
        return types.Tuple([WHOLES, *[types.intp] * (table.ndim - 1)])


@lower_getattr(Tables, "shape")
def _tables_shape(context, builder, kind, value):
    table = _get(context, builder, kind, value)
    lengths = [table.rows, *(getattr(table, f"n{k}") for k in range(1, kind.ndim))]
    return context.make_tuple(builder, types.Tuple([WHOLES, *[types.intp] * (kind.ndim - 1)]), lengths)


@infer_getattr
class RowShape(AttributeTemplate):
    """How many columns a row has."""

    key = TableRow

    def resolve_shape(self, row):
        """One length."""
        return types.UniTuple(types.intp, 1)


@lower_getattr(TableRow, "shape")
def _row_shape(context, builder, kind, value):
    return cgutils.pack_array(builder, [_get(context, builder, kind, value).columns])
