"""Twenty seeded random targets on the simulated human7, with synergy and with the raw controller.

Every reach is one `armsyn reach --json` in a process of its own: what a user gets, measured from
the servos' positions. Targets: x .2 to .45, y -.35 to .10, z -.30 to .05 m, within 95 % of the
arm's length, from the captured rest posture.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
from typing import Any

import numpy as np

TARGETS = 20
REACH_M = 0.66
GOALS = {
    "hand error below 5 mm": lambda r: r["hand_error_m"] < 0.005,
    "one speed peak": lambda r: r["speed_peaks"] == 1,
    "time to peak 0.25 to 0.65": lambda r: 0.25 <= r["time_to_peak"] <= 0.65,
    "min_jerk_r above 0.6": lambda r: r["min_jerk_r"] > 0.6,
}
LEAST_CAPTURED_R, GREATEST_RAW_R = 0.85, 0.4


def random_targets(count: int, seed: int) -> list[tuple[float, float, float]]:
    """Draw targets in the box, within 95 % of the arm's length."""
    generator = np.random.default_rng(seed)
    targets: list[tuple[float, float, float]] = []
    while len(targets) < count:
        target = generator.uniform((0.2, -0.35, -0.30), (0.45, 0.10, 0.05)).round(3)
        if np.linalg.norm(target) <= 0.95 * REACH_M:
            x, y, z = target.tolist()
            targets.append((x, y, z))
    return targets


class StoppedError(Exception):
    """A reach that ended before its target, as on a host that stood still; the message says why."""


def reach(target: tuple[float, float, float], *options: str) -> dict[str, Any]:
    """Run the command and return its document; `StoppedError` when it fails."""
    command = [sys.executable, "-m", "armsyn", "reach", "--json", *options]
    command += ["--target", *(str(value) for value in target)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    if done.returncode:
        said = done.stderr.strip().splitlines() or [f"exit status {done.returncode}"]
        raise StoppedError(" ".join([*options, said[-1]]))
    document: dict[str, Any] = json.loads(done.stdout)
    return document


def main() -> int:
    """Print a row a target; 1 when a goal is missed."""
    print("simulated human7, measured (firmware_sim; no hardware moved)")
    print(
        f"{'target, m':>22}{'error mm':>10}{'peaks':>7}{'t peak':>8}{'mj r':>7}{'SPARC':>8}"
        f"{'slowed':>8}{'capt r':>8}{'raw r':>7}  like"
    )
    found, raw = [], []
    for target in random_targets(TARGETS, seed=int(sys.argv[1]) if len(sys.argv) > 1 else 0):
        where = "({:.3f}, {:.3f}, {:.3f})".format(*target)
        try:
            found.append(r := reach(target))
            raw.append(w := reach(target, "--raw"))
        except StoppedError as error:
            print(f"{where:>22}  {error}", flush=True)
            continue
        print(
            f"{where:>22}{r['hand_error_m'] * 1000:10.1f}{r['speed_peaks']:7d}"
            f"{r['time_to_peak']:8.2f}{r['min_jerk_r']:7.2f}{r['sparc']:8.2f}"
            f"{r['time_scale']:8.2f}{r['captured_r']:8.2f}{w['captured_r']:7.2f}  {r['captured']}",
            flush=True,
        )
    if not raw:
        return 1
    held = [sum(map(goal, found)) == TARGETS for goal in GOALS.values()]
    captured = statistics.median(r["captured_r"] for r in found)
    without = statistics.median(r["captured_r"] for r in raw)
    for (name, goal), all_hold in zip(GOALS.items(), held, strict=True):
        print(f"{name}: {sum(map(goal, found))} of {TARGETS}{'' if all_hold else '  MISSED'}")
    print(f"median captured_r {captured:.3f} (goal above {LEAST_CAPTURED_R})")
    print(f"median captured_r of the raw controller {without:.3f} (goal below {GREATEST_RAW_R})")
    complete = len(raw) == TARGETS
    return int(
        not complete or not all(held) or captured <= LEAST_CAPTURED_R or without >= GREATEST_RAW_R
    )


if __name__ == "__main__":
    raise SystemExit(main())
