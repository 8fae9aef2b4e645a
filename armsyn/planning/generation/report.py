"""What a generation of reaches came to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from armsyn.errors import ArmsynError


@dataclass
class Report:
    """What a generation came to.

    Attributes
    ----------
    asked, made : int
        Reaches.
    chunks, done : int
    frames : int
        Made.
    outside : int or None
        Reaches made to targets outside the captured workspace; None where none is known.
    slowed : float
        Mean of kappa, the times as long that reaches take than people would.
    evened, swivelled : int
        Reaches with minimum jerk mixed in, and with the elbow elsewhere at their ends.
    refused : Counter
        Refused reaches by kind.
    error : ArmsynError or None
        What it ended by, before all was done.
    found : bool
        Whether all of it was there already.
    """

    asked: int
    chunks: int
    made: int = 0
    done: int = 0
    frames: int = 0
    outside: int | None = 0
    slowed: float = 0.0
    evened: int = 0
    swivelled: int = 0
    refused: Counter[str] = field(default_factory=Counter)
    error: ArmsynError | None = None
    found: bool = False

    @property
    def complete(self) -> bool:
        """Whether every reach is made or refused."""
        return self.done == self.chunks and self.error is None

    def add(self, note: Mapping[str, Any]) -> None:
        """Count a chunk that is done."""
        self.slowed = (self.slowed * self.made + note["slowed"]) / max(
            self.made + note["reaches"], 1
        )
        self.made += note["reaches"]
        self.done += 1
        self.frames += note["frames"]
        if self.outside is not None:
            self.outside = None if note["outside"] is None else self.outside + note["outside"]
        for _index, evened, swivel, _reason in note["changed"]:
            self.evened += evened > 0.0
            self.swivelled += swivel > 0.0
        self.refused.update(refusal[2] for refusal in note["refused"])

    def as_document(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        return {
            "complete": self.complete,
            "reaches_asked": self.asked,
            "reaches_made": self.made,
            "reaches_refused": dict(sorted(self.refused.items())),
            "reaches_evened": self.evened,
            "reaches_with_another_swivel": self.swivelled,
            "outside_captured_workspace": self.outside,
            "frames": self.frames,
            "mean_time_scale": self.slowed,
        }
