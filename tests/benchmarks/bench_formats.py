"""How long motion files take to read, beside what reading their bare numbers takes, and to write.

Reading: real captures (skipped where they are absent), best of five, with the joints' positions;
time of the processor, which other programs on the machine do not lengthen. The BVH of 2,752 frames
is held to half a second: exit status 1 when it takes longer. Writing: planned reaches of seven
joints, 300 frames each, as the episodes of one file for other programs.
"""

from __future__ import annotations

import io
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from armsyn.errors import CaptureError
from armsyn.motion import Motion
from armsyn.motion.captures import captures_folder
from armsyn.motion.formats import EXPORTS, Episode, read_motion, write_episodes

LONGEST = 0.5
"""Seconds for the BVH."""
REACHES = 200
BVH = "jump/cmu/01_01.bvh"


def main() -> int:
    """Print the tables; return the exit status."""
    print_writing()
    try:
        folder = captures_folder()
    except CaptureError as error:
        print(f"formats: {error}")
        return 0
    print("reading motion files, processor time, best of 5")
    print(f"{'':34}{'frames':>8}{'points':>8}{'ms':>9}{'other':>9}  what the other is")
    of_bvh = shown(folder / BVH, "its numbers by np.loadtxt", lambda: bare_numbers(folder / BVH))
    shown(folder / "jump/cmu/01_01.amc")
    c3d = folder / "reach/ulema/RF1.c3d"
    shown(c3d, "ezc3d", lambda: by_ezc3d(c3d))
    shown(folder / "reach/hug_mp/S01_trajs.mat#1.1.1")
    shown(f"{folder / 'jump/garza/jump.npz'}#ChrGarza@IdleStand01_JumpUpHigh01")
    verdict = "under" if of_bvh < LONGEST else "NOT under"
    print(f"the BVH of 2,752 frames in {of_bvh * 1000:.0f} ms: {verdict} {LONGEST} s")
    return 0 if of_bvh < LONGEST else 1


def print_writing() -> None:
    """Print how many reaches a second each format takes in, and what they weigh."""
    time_s = np.arange(300) / 200
    angles = np.sin(time_s[:, None] + np.arange(7))
    joints = tuple(f"joint{number}" for number in range(7))

    def reaches(count: int) -> Iterator[Episode]:
        for number in range(count):
            motion = Motion(time_s, joints, angles + 1e-3 * number, source=f"reach {number}")
            yield Episode(motion, "planned", "reach")

    print(f"writing {REACHES} reaches of 7 joints and 300 frames, processor time, best of 3")
    for suffix in sorted(EXPORTS):
        with tempfile.TemporaryDirectory() as folder:
            outs = iter(Path(folder) / f"{number}{suffix}" for number in range(4))
            write_episodes(next(outs), reaches(1))  # what is imported and made once
            seconds = best(lambda outs=outs: write_episodes(next(outs), reaches(REACHES)), 3)
            out = Path(folder) / f"3{suffix}"
            files = [out] if out.is_file() else [path for path in out.rglob("*") if path.is_file()]
            weight = sum(path.stat().st_size for path in files) / REACHES
        print(f"{suffix:10}{REACHES / seconds:8.0f} reaches/s{weight / 1000:8.1f} kB a reach")


def shown(path: Path | str, name: str = "", other: Callable[[], object] | None = None) -> float:
    """Print a row; return the seconds."""
    motion = read_motion(path)
    seconds = best(lambda: read_motion(path))
    beside = "" if other is None else f"{best(other) * 1000:.0f}"
    file = Path(path).name
    file = file if len(file) < 33 else f"{file[:30]}..."
    points = len(motion.landmark_names)
    print(f"{file:34}{motion.frames:8}{points:8}{seconds * 1000:9.0f}{beside:>9}  {name}".rstrip())
    return seconds


def best(call: Callable[[], object], times: int = 5) -> float:
    """Shortest processor time of several, s."""
    found = []
    for _ in range(times):
        began = time.process_time()
        call()
        found.append(time.process_time() - began)
    return min(found)


def bare_numbers(path: Path) -> object:
    """Read the channels of a BVH file alone: no skeleton, no rotations, no positions."""
    text = path.read_text()
    return np.loadtxt(io.StringIO(text[text.index("Frame Time:") :]), skiprows=1)


def by_ezc3d(path: Path) -> object:
    """Read the points of a C3D file with ezc3d."""
    import ezc3d

    return ezc3d.c3d(str(path))["data"]["points"]


if __name__ == "__main__":
    sys.exit(main())
