"""Arguments of faults: their names, units and bounds, and the text they are written as."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from firmware_sim.errors import FaultError

Value = int | float | str

LONGEST = 1.0e6
"""Largest time that is taken, s; about twelve days."""

_NUMBER = re.compile(r"[+-]?\d{1,15}(\.\d{0,15})?([eE][+-]?\d{1,2})?", re.ASCII)
_WHOLE = re.compile(r"[+-]?\d{1,15}", re.ASCII)


class ArgumentError(FaultError):
    """An argument of a fault is unknown, missing or impossible.

    Parameters
    ----------
    message : str
        One line.
    field : str
        The argument, or ``"name"`` where the fault itself is unknown.
    """

    def __init__(self, message: str, field: str) -> None:
        super().__init__(message)
        self.field = field


@dataclass(frozen=True, slots=True)
class Argument:
    """One argument.

    Parameters
    ----------
    name : str
        As it is written.
    meaning : str
        In a few words.
    default : int, float, str or None
        None where it may be left out without standing for a value.
    unit : str
        Empty for counts, shares and choices.
    low, high : float
        Smallest and largest value taken.
    choices : tuple of str
        What it can be, if it is no number.
    required : bool
        Whether it must be given.
    whole : bool
        Whether it is a whole number.
    """

    name: str
    meaning: str
    default: Value | None = None
    unit: str = ""
    low: float = 0.0
    high: float = LONGEST
    choices: tuple[str, ...] = ()
    required: bool = False
    whole: bool = False

    @property
    def expected(self) -> str:
        """What it takes, in words."""
        if self.choices:
            return "one of " + ", ".join(self.choices)
        kind = "a whole number" if self.whole else "a number"
        unit = f" {self.unit}" if self.unit else ""
        return f"{kind} from {self.low:.10g} to {self.high:.10g}{unit}"

    def parse(self, text: str) -> Value:
        """Return the value that a text stands for.

        Raises
        ------
        ArgumentError
            If it stands for none.
        """
        if self.choices:
            return self.check(text)
        if self.whole and _WHOLE.fullmatch(text):
            return self.check(int(text))
        if not self.whole and _NUMBER.fullmatch(text):
            return self.check(float(text))
        raise self._refusal(text)

    def check(self, value: object) -> Value:
        """Return a value of the right type within the bounds.

        Raises
        ------
        ArgumentError
            If it is none.
        """
        if self.choices:
            if isinstance(value, str) and value in self.choices:
                return value
            raise self._refusal(value)
        if isinstance(value, bool) or not isinstance(value, int if self.whole else (int, float)):
            raise self._refusal(value)
        # Bounds first: an integer of a thousand digits has no float.
        if not self.low <= value <= self.high or not math.isfinite(value):
            raise self._refusal(value)
        return value if self.whole else float(value)

    def _refusal(self, value: object) -> ArgumentError:
        try:
            shown = repr(value)
        except ValueError:  # more digits than Python is willing to print
            shown = "a huge number"
        shown = shown if len(shown) <= 40 else shown[:37] + "..."
        return ArgumentError(f"{self.name}={shown} is not {self.expected}", self.name)


COMMON = (
    Argument("id", "the servo it strikes; any, or all, where not given", high=252, whole=True),
    Argument("at", "when it begins, counted from the simulator's start", unit="s"),
    Argument("after", "when it begins, counted from its injection", unit="s"),
    Argument("for", "how long it lasts; without end where not given", unit="s", low=1.0e-3),
    Argument("count", "how often it strikes at most", low=1, high=10**9, whole=True),
    Argument("probability", "of striking each time it can", default=1.0, high=1.0),
    Argument("every", "at least this long from one strike to the next", unit="s", low=1.0e-3),
)
"""Arguments of every fault (``id`` only of those that concern one servo)."""

TO = Argument(
    "to",
    "whether it strikes replies or requests",
    default="client",
    choices=("client", "servos"),
)
"""Argument of the faults that strike bytes either way."""
