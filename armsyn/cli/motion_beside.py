"""What motion files hold beside a motion, and what of it another file has no place for."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from armsyn.motion.formats import Episode

_VELOCITY = "velocity_rad_s"
_WORDS = {
    "commanded_rad": "what was commanded",
    "sent_rad": "what the servos were sent",
    _VELOCITY: "velocities",
    "current_a": "currents",
    "temperature_c": "temperatures",
    "voltage_v": "voltages",
    "stale": "marks of lost replies",
    "hardware_error": "hardware errors",
    "event_text": "events",
    "target_m": "the target",
    "arm": "the arm's name",
    "port": "the port",
    "ending": "how it ended",
    "task": "the task",
}
"""Keys of recordings and episodes, in words."""
_OF_EPISODES = frozenset({"commanded_rad", "target_m", "arm", "port", "ending", "task"})
_HELD = {
    ".mcap": _OF_EPISODES | {_VELOCITY},
    ".parquet": _OF_EPISODES | {_VELOCITY},
    ".lerobot": _OF_EPISODES,
}
"""What formats hold of these; any other only the motion."""


def beside(path: Path) -> frozenset[str]:
    """Return the keys of what a recording in .npz or .csv holds beside its motion.

    Parameters
    ----------
    path : Path
        Of a file that has been read; of any other kind there are none.
    """
    if not path.is_file():
        return frozenset()
    if path.suffix.lower() == ".npz":
        from armsyn.motion.formats.archive import opened

        with opened(path) as archive:
            return archive.keys & _WORDS.keys() if "schema" in archive.keys else frozenset()
    if path.suffix.lower() == ".csv":
        with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
            header = next(csv.reader(line for line in file if not line.startswith("#")), [])
        named = [cell.rpartition(":") for cell in header]
        return frozenset(quantity for name, _, quantity in named if name) & _WORDS.keys()
    return frozenset()


def beside_in(episode: Episode | None) -> frozenset[str]:
    """Return the keys of what an episode holds beside its motion; none of None."""
    if episode is None:
        return frozenset()
    held = {
        "commanded_rad": episode.commanded is not None,
        _VELOCITY: episode.velocity is not None,
        "task": bool(episode.task),
    }
    return frozenset({*episode.all_facts, *(key for key in held if held[key])}) & _WORDS.keys()


def not_held(found: frozenset[str], path: Path, suffix: str) -> frozenset[str]:
    """Return the keys that get lost on the way from a file to a format.

    Parameters
    ----------
    found : frozenset of str
        Keys of what the file holds.
    path : Path
        The file: of one in .csv, velocities are not read.
    suffix : str
        Of the file to write, lower case.
    """
    held = _HELD.get(suffix, frozenset())
    return found - (held - {_VELOCITY} if path.suffix.lower() == ".csv" else held)


def in_words(keys: frozenset[str]) -> list[str]:
    """Name what is left out: one line, or none."""
    words = [words for key, words in _WORDS.items() if key in keys]
    return [", ".join(words)] if words else []
