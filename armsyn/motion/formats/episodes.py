"""Motions of an arm as other programs' files hold them: one episode after the other."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from armsyn.errors import FormatError
from armsyn.motion.motion import FloatArray, Motion

Kind = Literal["planned", "recorded", "observed", "motion"]
KINDS: dict[Kind, str] = {
    "planned": "the plan: nothing was driven or measured",
    "recorded": "the commanded posture",
    "observed": "the measured posture: the arm was only observed",
    "motion": "the motion itself: nothing was commanded",
}
"""What an episode is, each with what it gives for the action (what the arm was told)."""
TARGET = "target_m"
"""Fact of a file that is the target: x, y, z in the base frame, m."""


@dataclass(frozen=True, eq=False)
class Episode:
    """One motion with where it comes from.

    Parameters
    ----------
    motion : Motion
        Of a recording, what was measured.
    kind : {"planned", "recorded", "observed", "motion"}
        A plan; a recording of an arm that was driven; of one that was only observed; any other
        motion, such as a captured one.
    task : str
        What the motion does, in words.
    commanded : array, shape (frames, joints) or None
        What the joints were told, rad or m; for `recorded` only. NaN where they were told nothing.
    velocity : array, shape (frames, joints) or None
        As measured, rad/s or m/s.
    facts : mapping of str to str
        More of where it comes from, such as ``arm``, ``port``, ``seed``.
    rate_hz : float or None
        Frames a second that were asked for, which the ticks of a recording miss by a little.
    target : 3-tuple of float or None
        Where the hand was to end, base frame, m.

    Raises
    ------
    FormatError
        When the kind is unknown, the target is not finite, or the arrays do not fit the motion's
        angles.
    """

    motion: Motion
    kind: Kind = "motion"
    task: str = ""
    commanded: FloatArray | None = None
    velocity: FloatArray | None = None
    facts: Mapping[str, str] = field(default_factory=dict)
    rate_hz: float | None = None
    target: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        source = self.motion.source or "motion"
        if self.kind not in KINDS:
            raise FormatError(f"{source}: kind '{self.kind}': give one of {', '.join(KINDS)}")
        if (self.commanded is not None) != (self.kind == "recorded"):
            raise FormatError(
                f"{source}: what was commanded goes with kind 'recorded', and with it only"
            )
        if self.target is not None and not np.isfinite(self.target).all():
            raise FormatError(f"{source}: the target {self.target} is not finite")
        object.__setattr__(self, "task", _encodable(self.task))
        facts = {name: _encodable(value) for name, value in self.facts.items()}
        object.__setattr__(self, "facts", facts)
        shape = (self.motion.frames, len(self.motion.joint_names))
        for part in ("commanded", "velocity"):
            values = getattr(self, part)
            if values is not None and np.shape(values) != shape:
                raise FormatError(
                    f"{source}: {part} has shape {np.shape(values)}, expected {shape}"
                )

    @property
    def source(self) -> str:
        """Where the motion comes from, in words that every format can hold."""
        return _encodable(self.motion.source)

    @property
    def state(self) -> FloatArray:
        """Joint angles of the motion, shape (frames, joints), rad or m.

        Raises
        ------
        FormatError
            When it has none, or some are not known.
        """
        angles = self.motion.angles
        source = self.motion.source or "motion"
        if angles is None:
            raise FormatError(
                f"{source}: no joint angles in it, only landmarks: armsyn motion retarget --angles"
                " fits those of an arm"
            )
        if not np.isfinite(angles).all():
            joint = self.motion.joint_names[int(np.argwhere(~np.isfinite(angles))[0, 1])]
            raise FormatError(f"{source}: angles of '{joint[:40]}' are not all known")
        return angles

    @property
    def action(self) -> FloatArray:
        """What the joints were told, shape (frames, joints), rad or m; see `KINDS`.

        Where a recorded joint was told nothing, its measured angle.
        """
        if self.commanded is None:
            return self.state
        return np.where(np.isnan(self.commanded), self.state, self.commanded)

    @property
    def all_facts(self) -> dict[str, Any]:
        """The facts, and as `TARGET` the target's three numbers, as JSON has them."""
        return dict(self.facts) | ({} if self.target is None else {TARGET: list(self.target)})

    def description(self) -> dict[str, Any]:
        """Return what it is, as JSON, for a file's metadata."""
        said = {"kind": self.kind, "action": KINDS[self.kind], "source": self.source}
        return self.all_facts | said | {"task": self.task}


def _encodable(text: str) -> str:
    """Return text without the halves of characters that names of files may hold."""
    return text.encode("utf-8", "replace").decode("utf-8")


Episodes = Motion | Episode | Iterable[Motion | Episode]
"""One, or many that are taken one by one."""


def episodes_of(given: Episodes, path: Path) -> Iterator[Episode]:
    """Give episodes one by one.

    Parameters
    ----------
    given : Motion, Episode, or an iterable of them
    path : Path
        Of the file they are for, for messages.

    Yields
    ------
    Episode
        One at least; all with the same joints, in the same order.

    Raises
    ------
    FormatError
        When there is none, one has other joints than the first, or a name is not printable.
    """
    several = [given] if isinstance(given, Motion | Episode) else given
    first: tuple[str, ...] | None = None
    for number, one in enumerate(several):
        episode = Episode(one) if isinstance(one, Motion) else one
        names = episode.motion.joint_names
        if first is None:
            first = names
            for name in names:
                if not name.isprintable():
                    raise FormatError(f"{path}: cannot write the name {name!r}: rename it")
        if names != first:
            raise FormatError(
                f"{path}: episode {number} ({episode.motion.source or 'motion'}) has the joints"
                f" {', '.join(names) or 'none'}; the first has {', '.join(first) or 'none'}"
            )
        yield episode
    if first is None:
        raise FormatError(f"{path}: no motion to write")
