"""The words of `armsyn track` for people."""

from __future__ import annotations

from typing import Any


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
            return (
                f"{event['t_s']:8.3f} s  {name}: to {where}, like {event['like']},"
                f" {event['time_scale']:.2f} times slower, about {event['expected_s']:.2f} s"
            )
        case "arrived" | "missed" as how:
            took = f"{event['error_mm']:.1f} mm from it after {event['time_s']:.2f} s"
            return f"{event['t_s']:8.3f} s  {name}: {how}, {took}"
        case "replaced":
            left = f"still {event['error_mm']:.0f} mm away"
            return f"{event['t_s']:8.3f} s  {name}: left for another, {left}"
        case "unfinished":
            return f"            {name}: the arm stopped before it arrived"
        case _:
            return f"            {name}: passed over for a newer one"


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
