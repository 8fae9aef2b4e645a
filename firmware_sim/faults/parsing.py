"""Faults out of text: ``NAME[:key=value,...]``."""

from __future__ import annotations

from collections.abc import Mapping

from firmware_sim.faults.argument import ArgumentError, Value
from firmware_sim.faults.registry import find_kind, guess
from firmware_sim.faults.spec import FaultKind, FaultSpec

LONGEST_TEXT = 1000
"""Most characters of one fault's text."""


def parse_fault(text: str) -> FaultSpec:
    """Return the fault that a text asks for.

    Parameters
    ----------
    text : str
        Such as ``crc-error:id=3,probability=0.01,after=2,for=1.5``.

    Raises
    ------
    ArgumentError
        One line, for an unknown name or argument, one given twice, or an impossible value.
    """
    if len(text) > LONGEST_TEXT:
        raise ArgumentError(f"a fault's text has at most {LONGEST_TEXT} characters", "name")
    name, colon, rest = text.partition(":")
    kind = find_kind(name)
    if colon and not rest:
        raise ArgumentError(f"{name}: no argument behind the colon", "name")
    values: dict[str, Value] = {}
    for part in rest.split(",") if rest else ():
        field, equals, value = part.partition("=")
        if not equals:
            raise ArgumentError(f"{name}: {_shown(part)} is not of the form key=value", field)
        if field in values:
            raise ArgumentError(f"{name}: {field} is given twice", field)
        values[field] = _Named(kind, field).parse(value)
    return _complete(kind, values)


def check_fault(name: str, arguments: Mapping[str, object]) -> FaultSpec:
    """Return the fault with a name and arguments that were read from a file.

    Raises
    ------
    ArgumentError
        One line, for an unknown name or argument, or an impossible value.
    """
    kind = find_kind(name)
    values = {field: _Named(kind, field).check(value) for field, value in arguments.items()}
    return _complete(kind, values)


class _Named:
    """An argument of a kind, whose refusals name the kind."""

    def __init__(self, kind: FaultKind, field: str) -> None:
        self._kind = kind
        known = kind.all_arguments
        if field not in known:
            why = f"takes no argument {_shown(field)}{guess(field, known)}"
            raise ArgumentError(f"{kind.name} {why}; it takes {', '.join(known)}", field)
        self._argument = known[field]

    def parse(self, text: str) -> Value:
        try:
            return self._argument.parse(text)
        except ArgumentError as error:
            raise ArgumentError(f"{self._kind.name}: {error}", error.field) from None

    def check(self, value: object) -> Value:
        try:
            return self._argument.check(value)
        except ArgumentError as error:
            raise ArgumentError(f"{self._kind.name}: {error}", error.field) from None


def _complete(kind: FaultKind, values: Mapping[str, Value]) -> FaultSpec:
    """Return a fault whose arguments are all there and fit each other."""
    if "at" in values and "after" in values:
        raise ArgumentError(f"{kind.name}: give at or after, not both", "after")
    needed = [argument.name for argument in kind.arguments if argument.required]
    for name in [*(["id"] if kind.needs_servo else []), *needed]:
        if name not in values:
            raise ArgumentError(f"{kind.name} needs {name}=...", name)
    return FaultSpec(kind, dict(values))


def _shown(text: str) -> str:
    return repr(text if len(text) <= 40 else text[:37] + "...")
