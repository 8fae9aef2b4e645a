"""Reaches by the thousand: predicted, paced and judged in batches, written in chunks."""

from armsyn.planning.generation.judging import Verdicts, judge
from armsyn.planning.generation.pacing import Paced, pace

__all__ = ["Paced", "Verdicts", "judge", "pace"]
