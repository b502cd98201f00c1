"""Arrays of zeros in kernels: `numpy.zeros`, of which Numba compiles three functions for each number of axes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba.core import cgutils, types
from numba.core.imputils import impl_ret_new_ref
from numba.extending import lower_builtin, type_callable
from numba.np.arrayobj import _empty_nd_impl


def zeros(shape: Any) -> np.ndarray:
    """Zeros of type float64; ``shape`` is a whole number or a tuple of them."""
    return np.zeros(shape)


def flags(count: int) -> np.ndarray:
    """So many booleans, all False."""
    return np.zeros(count, np.bool_)


def counts(count: int) -> np.ndarray:
    """So many whole numbers, all 0."""
    return np.zeros(count, np.int64)


def _type_of(content: Any) -> Any:
    def typer(context: Any) -> Any:
        return lambda shape: types.Array(content, shape.count if isinstance(shape, types.UniTuple) else 1, "C")

    return typer


def _allocate(context: Any, builder: Any, call: Any, values: Any) -> Any:
    """LLVM code that allocates the array and fills it."""
    shape = call.args[0]
    sizes = cgutils.unpack_tuple(builder, values[0]) if isinstance(shape, types.UniTuple) else [values[0]]
    kind = shape.dtype if isinstance(shape, types.UniTuple) else shape
    sizes = [context.cast(builder, size, kind, types.intp) for size in sizes]
    array = _empty_nd_impl(context, builder, call.return_type, sizes)
    cgutils.memset(builder, array.data, builder.mul(array.itemsize, array.nitems), 0)
    return impl_ret_new_ref(context, builder, call.return_type, array._getvalue())


for function, content in ((zeros, types.float64), (flags, types.boolean), (counts, types.int64)):
    type_callable(function)(_type_of(content))
    lower_builtin(function, types.Any)(_allocate)
