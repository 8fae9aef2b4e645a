"""Peak memory of one `armsyn reach`, driver and simulator together.

Memory that both share (the code of the same libraries) is counted once: Linux's PSS, looked at
fifty times a second.
"""

from __future__ import annotations

import subprocess
import sys
from contextlib import suppress
from pathlib import Path

LIMIT_MB = 300.0
COMMAND = [sys.executable, "-m", "armsyn", "reach", "--target", "0.35", "-0.1", "-0.15"]


def memory_mb(pid: int) -> float:
    """Memory of a process, its part of what it shares, MB; 0 when it has ended."""
    try:
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    except (FileNotFoundError, ProcessLookupError):
        return 0.0
    found = [line for line in lines if line.startswith("Pss:")]
    return float(found[0].split()[1]) / 1024 if found else 0.0


def children(pid: int) -> list[int]:
    """Processes that a process has started and that still run."""
    try:
        return [int(n) for n in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except (FileNotFoundError, ProcessLookupError):
        return []


def main() -> int:
    """Print both at the moment of the largest sum; 1 when that is above the limit."""
    driver, simulator = 0.0, 0.0
    with subprocess.Popen(COMMAND, stdout=subprocess.DEVNULL) as process:
        while process.poll() is None:
            one = memory_mb(process.pid)
            other = sum(memory_mb(child) for child in children(process.pid))
            if one + other > driver + simulator:
                driver, simulator = one, other
            with suppress(subprocess.TimeoutExpired):
                process.wait(0.02)
    total = driver + simulator
    print("peak memory of one reach (armsyn reach --target 0.35 -0.1 -0.15)")
    print(f"driver {driver:.0f} MB + simulator {simulator:.0f} MB = {total:.0f} MB")
    print(f"goal: below {LIMIT_MB:g} MB")
    return int(process.returncode != 0 or simulator == 0.0 or total >= LIMIT_MB)


if __name__ == "__main__":
    raise SystemExit(main())
