"""Generated roll-outs compiled, in memory and on disk.

The source is kept beside numba's own cache, named by its hash: numba caches functions of files
only. Where nothing can be written (a read-only installation without a home) it is compiled anew
by each process.
"""

from __future__ import annotations

import hashlib
import tempfile
import threading
from pathlib import Path
from typing import Any, Protocol

from armsyn.kernels.compiling import cache_place
from armsyn.kernels.generator import Plan, generate
from armsyn.kernels.plain import roll_out
from armsyn.kernels.types import FloatArray, IntArray

_SIGNATURE = "void(f8[:,::1], i8[::1], i8[::1], i8, i8, f8[::1], f8, f8[:,:,:,::1], f8[:,:,::1])"


class Play(Protocol):
    """A generated roll-out."""

    def __call__(
        self,
        states: FloatArray,
        frames: IntArray,
        motions: IntArray,
        first: int,
        last: int,
        factors: FloatArray,
        share: float,
        marks: FloatArray,
        out: FloatArray,
    ) -> None:
        """Play blocks of lanes.

        Parameters
        ----------
        states : array, shape (blocks, rows WIDTH)
            Each block's state (`generator.rows_of`); left as it is after the last frame.
        frames, motions : array of int, shape (blocks,)
            How many frames each block plays, and its row of `marks`.
        first, last : int
            The blocks to play; the last is not.
        factors : array, shape (frames,)
            lambda dt times the ramp of phi.
        share : float
            Of a joint's distance to its limit, which it covers at most in a step; unused where
            joints are clamped.
        marks : array, shape (motions, frames, landmarks, 3)
            Captured landmarks, m; unused by a plan for paths.
        out : array, shape (lanes, frames, values)
            Filled by a plan for paths or gaps.
        """


_played: dict[tuple[Any, ...], Play] = {}
_lock = threading.Lock()


def compiled(plan: Plan) -> Play:
    """Return the compiled roll-out of a plan.

    Parameters
    ----------
    plan : Plan

    Returns
    -------
    Play
    """
    key = (*(part.tobytes() for part in plan.chain), *plan.optimiser, *plan[2:])
    with _lock:
        if key not in _played:
            _played[key] = load(generate(plan).text)
        return _played[key]


def load(text: str) -> Play:
    """Compile the source of a generated module, or take it from the cache on disk.

    Parameters
    ----------
    text : str

    Returns
    -------
    Play
    """
    # numba looks a cached function's module up by name, so it must be one that can be imported
    module: dict[str, Any] = {"__name__": __name__}
    exec(compile(text, str(_kept(text) or "<generated>"), "exec"), module)  # noqa: S102
    play = module["play"]
    play.compile(_SIGNATURE)
    played: Play = play
    return played


def _kept(text: str) -> Path | None:
    """Return the file that holds the source, if one can be written."""
    place = cache_place(roll_out)
    if place is None:
        return None
    file = Path(place) / "generated" / f"{hashlib.sha256(text.encode()).hexdigest()[:32]}.py"
    if not file.exists():
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile("w", dir=file.parent, delete=False) as written:
                written.write(text)
            Path(written.name).replace(file)
        except OSError:
            return None
    return file
