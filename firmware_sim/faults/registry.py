"""All kinds of faults by name."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from types import MappingProxyType

from firmware_sim.faults import (
    adapter,
    damage,
    delivery,
    handling,
    identity,
    mechanics,
    port,
    servo_events,
    servo_states,
    traffic,
)
from firmware_sim.faults.argument import COMMON, Argument, ArgumentError
from firmware_sim.faults.spec import FaultKind

_ROOMS = (
    damage,
    delivery,
    adapter,
    port,
    traffic,
    servo_events,
    servo_states,
    identity,
    mechanics,
    handling,
)

KINDS: Mapping[str, FaultKind] = MappingProxyType(
    {kind.name: kind for room in _ROOMS for kind in room.KINDS}
)
"""Every fault that can be injected, by name."""


def find_kind(name: str) -> FaultKind:
    """Return the kind of fault with a name.

    Raises
    ------
    ArgumentError
        If there is none; it names the closest.
    """
    kind = KINDS.get(name)
    if kind is None:
        shown = name if len(name) <= 40 else name[:37] + "..."
        raise ArgumentError(
            f"no fault {shown!r}{guess(name, KINDS)}; see firmware-sim --list-faults", "name"
        )
    return kind


def guess(name: str, known: Mapping[str, object]) -> str:
    """Return a few words that name what was probably meant; nothing where no name is close."""
    close = get_close_matches(name[:100], list(known), 3, 0.5)
    return f" (did you mean {' or '.join(close)}?)" if close else ""


def list_faults() -> str:
    """Return the text of ``firmware-sim --list-faults``: each fault with its arguments."""
    parts = [
        "Faults, as --fault NAME[:key=value,...]; [in brackets] the row of the table of faults.",
        "",
        "Every fault takes:",
        *(_line(argument) for argument in COMMON),
        "",
        *(_describe(kind) for kind in sorted(KINDS.values(), key=lambda kind: kind.name)),
    ]
    return "\n".join(parts)


def _describe(kind: FaultKind) -> str:
    rows = ", ".join(map(str, kind.rows))
    note = " Needs id." if kind.needs_servo else "" if kind.concerns_servo else " Takes no id."
    lines = [f"{kind.name} [{rows}]: {kind.summary}.{note}"]
    return "\n".join([*lines, *(_line(argument) for argument in kind.arguments)])


def _line(argument: Argument) -> str:
    default = "" if argument.default is None else f"; {argument.default} where not given"
    default = "; must be given" if argument.required else default
    return f"    {argument.name}: {argument.meaning} ({argument.expected}{default})"
