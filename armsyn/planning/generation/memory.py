"""Memory that batches use again and again: kept, not given back in between."""

from __future__ import annotations

import ctypes
from functools import cache

_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3  # of mallopt(3)
_KEPT = 1 << 30
_LARGEST_MAPPED = 1 << 25
"""Of glibc before 2.35, which refuses to keep greater arrays."""


@cache
def keep_memory() -> None:
    """Have this process keep what it frees, up to 1 GB, for what it allocates next.

    A batch allocates some tens of megabytes; given back after each, every page of them has to be
    asked for and cleared again, which takes as long as the batch itself. Where the C library is
    not one that can be told so (`mallopt` of glibc), it stays as it is.
    """
    try:
        library = ctypes.CDLL(None)
        mallopt = library.mallopt
    except (AttributeError, OSError, TypeError):
        return
    # Either call ends the library's own adapting of what it maps: refused, it would map all arrays
    if mallopt(_MMAP_THRESHOLD, _KEPT) or mallopt(_MMAP_THRESHOLD, _LARGEST_MAPPED):
        mallopt(_TRIM_THRESHOLD, _KEPT)
