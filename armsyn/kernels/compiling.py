"""How kernels are compiled: cached on disk where that is possible, strict floating point off.

``error_model="numpy"`` drops Python's divide-by-zero exits, which block vectorisation, and
``fastmath`` lets sums be reassociated and multiplications and additions fused, but keeps the
meaning of infinities and NaN (phi_A is a sigmoid with an infinite offset).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., Any])

_FASTMATH = {"contract", "reassoc", "arcp", "nsz"}


def kernel(function: Function) -> Function:
    """Compile `function` for one core."""
    return _compiled(function, {})


def parallel_kernel(function: Function) -> Function:
    """Compile `function` with its ``prange`` loops spread over all cores."""
    return _compiled(function, {"parallel": True})


def _compiled(function: Function, options: dict[str, Any]) -> Function:
    settings = {"error_model": "numpy", "fastmath": _FASTMATH, **options}
    try:
        compiled = numba.njit(cache=True, **settings)(function)
    except RuntimeError:
        # No directory for the cache can be written (an installation without a home): numba
        # refuses to decorate at all then. Compiling anew at each start is slower, not wrong.
        compiled = numba.njit(cache=False, **settings)(function)
    return cast(Function, compiled)
