"""The words of `armsyn track` for people."""

from __future__ import annotations

import math
from typing import Any

OUTSIDE_M = 1e-3
"""A target that is this far outside what was captured is told to be."""


def event_text(event: dict[str, Any]) -> str:
    """Put what happened to a target into a line for people.

    Parameters
    ----------
    event : dict
        As `armsyn.cli.track_feed` tells it; not a refusal.

    Returns
    -------
    str
    """
    if event["event"] == "ready":
        return "ready: waiting for targets"
    name = f"line {event['line']}" + ("" if event["id"] is None else f" ({event['id']})")
    match event["event"]:
        case "accepted":
            where = "({:.3f}, {:.3f}, {:.3f}) m".format(*event["target_m"])
            like = event["captured"]
            manner = "with the synergy of the place" if like is None else f"like {like}"
            return (
                f"{event['t_s']:8.3f} s  {name}: to {where}, {manner}, {_paced(event)}, about"
                f" {event['planned_time_s']:.2f} s{_outside(event)}"
            )
        case "arrived" | "missed" as how:
            took = f"{_left(event, 1)} from it after {event['elapsed_s']:.2f} s"
            return f"{event['t_s']:8.3f} s  {name}: {how}, {took}"
        case "replaced":
            left = f"still {_left(event, 0)} away"
            return f"{event['t_s']:8.3f} s  {name}: left for another, {left}"
        case "unfinished":
            return f"            {name}: the arm stopped before it arrived"
        case _:
            return f"            {name}: passed over for a newer one"


def _paced(event: dict[str, Any]) -> str:
    """How fast it is, beside what it is taken from."""
    kappa = event["time_scale"]
    return f"{kappa:.2f} times slower" if kappa > 1.0 else "as fast as people"


def _outside(event: dict[str, Any]) -> str:
    outside = event["outside_m"]
    if outside is None or outside < OUTSIDE_M:
        return ""
    return f"; {outside * 100:.1f} cm outside what was captured"


def _left(event: dict[str, Any], digits: int) -> str:
    """What was left to the target, and to how the hand was to be turned."""
    turn = event["orientation_error_rad"]
    turned = "" if turn is None else f" and {math.degrees(turn):.1f} degrees"
    return f"{1e3 * event['hand_error_m']:.{digits}f} mm{turned}"


def printable(text: str, encoding: str | None) -> str:
    """Escape what a sender could trick a terminal with, or what an encoding does not have.

    Parameters
    ----------
    text : str
    encoding : str or None

    Returns
    -------
    str
        One line.
    """
    shown = "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
    code = encoding or "ascii"
    return shown.encode(code, "backslashreplace").decode(code)
