"""Reaches by the thousand: predicted, paced and judged in batches, written in chunks."""

from armsyn.planning.generation.judging import Verdicts
from armsyn.planning.generation.pacing import Paced

__all__ = ["Paced", "Verdicts"]
