"""What is asked of one fault: its kind, and a value for each argument."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from random import Random
from typing import TYPE_CHECKING

from firmware_sim.faults.argument import COMMON, Argument, Value

if TYPE_CHECKING:
    from firmware_sim.faults.fault import Fault


@dataclass(frozen=True, slots=True)
class FaultKind:
    """A fault that can be injected.

    Parameters
    ----------
    name : str
        In lower case with dashes.
    rows : tuple of int
        The faults of a servo bus (numbers in the project's table of them) that it brings about.
    summary : str
        What it does, one line.
    make : callable
        Makes one out of what is asked of it and its own source of chance.
    arguments : tuple of Argument
        Its own, beside the common ones.
    concerns_servo : bool
        Whether it takes ``id``.
    needs_servo : bool
        Whether ``id`` must be given.
    """

    name: str
    rows: tuple[int, ...]
    summary: str
    make: Callable[[FaultSpec, Random], Fault]
    arguments: tuple[Argument, ...] = ()
    concerns_servo: bool = True
    needs_servo: bool = False

    @property
    def all_arguments(self) -> Mapping[str, Argument]:
        """Its own and the common arguments it takes, by name, its own first."""
        common = (a for a in COMMON if self.concerns_servo or a.name != "id")
        return {argument.name: argument for argument in (*self.arguments, *common)}


@dataclass(frozen=True, slots=True)
class FaultSpec:
    """One fault that is asked for, checked.

    Parameters
    ----------
    kind : FaultKind
        Which.
    given : mapping of str to int, float or str
        The arguments that were given.
    source : str
        Where they stand, for errors; empty for the command line and the control socket.
    """

    kind: FaultKind
    given: Mapping[str, Value] = field(default_factory=dict)
    source: str = field(default="", compare=False)
    _values: dict[str, Value | None] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        defaults = {name: row.default for name, row in self.kind.all_arguments.items()}
        object.__setattr__(self, "_values", defaults | dict(self.given))

    def number(self, name: str) -> float:
        """Return an argument that is a number and has a value."""
        value = self._values[name]
        if not isinstance(value, (int, float)):
            raise KeyError(name)
        return float(value)

    def whole(self, name: str) -> int:
        """Return an argument that is a whole number and has a value."""
        return int(self.number(name))

    def choice(self, name: str) -> str:
        """Return an argument that is a choice."""
        return str(self._values.get(name))

    def optional(self, name: str) -> float | None:
        """Return an argument that is a number, or None where it was left out."""
        value = self._values.get(name)
        return float(value) if isinstance(value, (int, float)) else None

    @property
    def servo_id(self) -> int | None:
        """The servo it concerns; None for any or all."""
        value = self.optional("id")
        return None if value is None else int(value)

    def begin(self, start: float, now: float) -> float:
        """Return when it begins, s.

        Parameters
        ----------
        start : float
            Of the simulation, s.
        now : float
            When it is injected, s.
        """
        at = self.optional("at")
        if at is not None:
            return max(start + at, now)
        return now + (self.optional("after") or 0.0)

    @property
    def text(self) -> str:
        """It as it is written on a command line."""
        arguments = ",".join(f"{name}={_shown(value)}" for name, value in self.given.items())
        return f"{self.kind.name}:{arguments}" if arguments else self.kind.name


def _shown(value: Value) -> str:
    """Return a value as people write it: 2, not 2.0."""
    return str(value).removesuffix(".0")
