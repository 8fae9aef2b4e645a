"""Which armsyn makes the reaches: another may make others from the same inputs."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import armsyn

VERSION, SOURCES = "armsyn", "sources_sha256"
"""What a manifest calls them among its inputs."""

ROOMS = ("kernels", "kinematics", "planning", "safety")
"""Whose code decides what a reach is."""


def version() -> dict[str, str]:
    """Return the version of armsyn and the digest of its sources that make reaches."""
    root = Path(armsyn.__file__).parent
    digest = hashlib.sha256()
    for source in sorted(path for room in ROOMS for path in _sources(root / room)):
        content = source.read_bytes()
        digest.update(f"{source.relative_to(root).as_posix()} {len(content)}\n".encode())
        digest.update(content)
    return {VERSION: armsyn.__version__, SOURCES: digest.hexdigest()}


def _sources(room: Path) -> Iterator[Path]:
    """Give a room's sources, without the code that was generated for the chains of arms in use."""
    return (
        path for path in room.rglob("*.py") if "__pycache__" not in path.relative_to(room).parts
    )


def differing(before: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    """Say by what the inputs of a generation differ, as its manifest calls them."""
    names = sorted(name for name in {*before, *now} if before.get(name) != now.get(name))
    if names and set(names) <= {VERSION, SOURCES}:
        made = before.get(VERSION, "an older one")
        other = " with other sources" if names == [SOURCES] else ""
        return f"another armsyn ({made}{other}; this is {now.get(VERSION)})"
    return f"something else ({', '.join(names)})" if names else "something else"
