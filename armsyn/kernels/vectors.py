"""Eight doubles side by side, for kernels: written as numbers, compiled to vector instructions.

A compiler leaves loops over seven joints scalar, for it cannot tell that what they write is not
what they read next. Here a row of joints is loaded, reckoned with and stored as one value. Arrays
are contiguous; places in them count elements from their first, and up to `WIDTH` - 1 elements
beyond a row are read, or written, along with it: callers leave room and do not look there.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any, ClassVar, cast

from llvmlite import ir
from numba import types
from numba.core import typing
from numba.core.errors import TypingError
from numba.core.typing.templates import ConcreteTemplate, infer_global
from numba.extending import intrinsic, lower_builtin, models, register_model

from armsyn.kernels.types import FloatArray

WIDTH = 8
"""Two vectors of AVX2, or one of AVX-512."""

Eight = Any
"""A value of `WIDTH` doubles; it has +, - and *, with others and with numbers."""

_VECTOR = ir.VectorType(ir.DoubleType(), WIDTH)
_BITS = ir.VectorType(ir.IntType(64), WIDTH)
_MAGNITUDE = ir.Constant(_BITS, [(1 << 63) - 1] * WIDTH)


class _EightType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Eight")


_EIGHT = _EightType()
_signature_of = cast("Any", typing).signature


@register_model(_EightType)
class _EightModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _VECTOR)  # type: ignore[no-untyped-call]


def _spread(builder: Any, value: Any) -> Any:
    """Give a number in all lanes, or a vector as it is."""
    if value.type == _VECTOR:
        return value
    nothing = ir.Constant(_VECTOR, ir.Undefined)
    first = builder.insert_element(nothing, value, ir.Constant(ir.IntType(32), 0))
    everywhere = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(first, nothing, everywhere)


def _operator(function: Callable[[Any, Any], Any], instruction: str) -> None:
    """Let an operator take vectors, on either side."""
    pairs = [(_EIGHT, _EIGHT), (_EIGHT, types.float64), (types.float64, _EIGHT)]

    @infer_global(function)  # type: ignore[no-untyped-call]
    class _Template(ConcreteTemplate):
        cases: ClassVar = [_signature_of(_EIGHT, *pair) for pair in pairs]

    def lower(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        return getattr(builder, instruction)(*(_spread(builder, value) for value in args))

    for pair in pairs:
        lower_builtin(function, *pair)(lower)  # type: ignore[no-untyped-call]


for _function, _instruction in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
):
    _operator(_function, _instruction)


def _address(context: Any, builder: Any, kind: Any, array: Any, place: Any) -> Any:
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [place]), _VECTOR.as_pointer())


def _check_contiguous(array: Any) -> None:
    if getattr(array, "layout", None) != "C":
        raise TypingError(f"lanes are loaded from contiguous arrays, not {array}")


def _load(_typing: Any, array: Any, _place: Any) -> Any:
    _check_contiguous(array)

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.load(_address(context, builder, sig.args[0], *args), align=8)

    return _signature_of(_EIGHT, array, types.intp), code


def _store(_typing: Any, array: Any, _place: Any, value: Any) -> Any:
    _check_contiguous(array)

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        address = _address(context, builder, sig.args[0], args[0], args[1])
        builder.store(args[2], address, align=8)
        return context.get_dummy_value()

    return _signature_of(types.void, array, types.intp, value), code


def _eight(_typing: Any, _value: Any) -> Any:
    def code(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        return _spread(builder, args[0])

    return _signature_of(_EIGHT, types.float64), code


def _magnitude(_typing: Any, value: Any) -> Any:
    def code(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        bits = builder.and_(builder.bitcast(args[0], _BITS), _MAGNITUDE)
        return builder.bitcast(bits, _VECTOR)

    return _signature_of(_EIGHT, value), code


def _greater(_typing: Any, one: Any, other: Any) -> Any:
    def code(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        return builder.select(builder.fcmp_ordered(">", *args), *args)

    return _signature_of(_EIGHT, one, other), code


def _less(_typing: Any, one: Any, other: Any) -> Any:
    def code(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        return builder.select(builder.fcmp_ordered("<", *args), *args)

    return _signature_of(_EIGHT, one, other), code


load = cast("Callable[[FloatArray, int], Eight]", intrinsic(_load))
"""The elements of an array from a place on."""
store = cast("Callable[[FloatArray, int, Eight], None]", intrinsic(_store))
"""Write to an array from a place on."""
eight = cast("Callable[[float], Eight]", intrinsic(_eight))
"""A number in all lanes."""
magnitude = cast("Callable[[Eight], Eight]", intrinsic(_magnitude))
"""What is left without signs."""
greater = cast("Callable[[Eight, Eight], Eight]", intrinsic(_greater))
"""The greater in each lane; the second where either is not a number."""
less = cast("Callable[[Eight, Eight], Eight]", intrinsic(_less))
"""The less in each lane; the second where either is not a number."""
