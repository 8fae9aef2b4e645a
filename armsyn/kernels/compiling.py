"""How kernels are compiled: cached on disk where that is possible, strict floating point off.

``error_model="numpy"`` drops Python's divide-by-zero exits, which block vectorisation, and
``fastmath`` lets sums be reassociated and multiplications and additions fused, but keeps the
meaning of infinities and NaN (phi_A is a sigmoid with an infinite offset) in comparisons. Not in
``x - x``, which becomes 0, and ``math.isfinite`` is made of that: kernels ask ``abs(x) < inf``.

A kernel carries the code of the kernels that it calls, but numba compares only the file that it
stands in with its cache: after a change of ``chain.py`` it would go on running old roll-outs.
So the cache is stamped with all the sources of this room.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core.caching import IndexDataCacheFile

Function = TypeVar("Function", bound=Callable[..., Any])

_FASTMATH = {"contract", "reassoc", "arcp", "nsz"}
_WRITTEN_OUT = {"contract"}
"""Of generated code, whose sums stand as they are best done: in another order it is slower."""


def _sources_stamp(folder: Path) -> str:
    digest = hashlib.sha256()
    for source in sorted(folder.glob("*.py")):
        digest.update(source.read_bytes())
    return digest.hexdigest()


_STAMP = _sources_stamp(Path(__file__).parent)


def kernel(function: Function) -> Function:
    """Compile `function` for one core."""
    return _compiled(function, {})


def generated_kernel(function: Function) -> Function:
    """Compile generated `function`, which may run in several threads of Python at once."""
    return _compiled(function, {"nogil": True, "fastmath": _WRITTEN_OUT})


def cache_place(compiled: Any) -> Path | None:
    """Return the directory where a compiled function's cache lies; None where there is none."""
    place = compiled._cache.cache_path
    return None if place is None else Path(place)


def _compiled(function: Function, options: dict[str, Any]) -> Function:
    settings = {"error_model": "numpy", "fastmath": _FASTMATH, **options}
    try:
        compiled = numba.njit(cache=True, **settings)(function)
        _stamp_cache(compiled, _STAMP)
    except RuntimeError:
        # No directory for the cache can be written (an installation without a home): numba
        # refuses to decorate at all then. Compiling anew at each start is slower, not wrong.
        compiled = numba.njit(cache=False, **settings)(function)
    return cast(Function, compiled)


def _stamp_cache(compiled: Any, stamp: str) -> None:
    """Make a compiled function's cache depend on `stamp`; numba has no public way to."""
    cache = compiled._cache
    index = cache._cache_file
    cache._cache_file = IndexDataCacheFile(  # type: ignore[no-untyped-call]
        cache_path=index._cache_path,
        filename_base=index._index_name.removesuffix(".nbi"),
        source_stamp=(index._source_stamp, stamp),
    )
