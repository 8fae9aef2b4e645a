"""Peak memory of one `armsyn reach`, driver and simulator together (Linux: VmHWM)."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

LIMIT_MB = 300.0
COMMAND = [sys.executable, "-m", "armsyn", "reach", "--target", "0.35", "-0.1", "-0.15"]


def peak_mb(pid: int) -> float:
    """Largest resident memory of a process so far, MB; 0 when it has ended."""
    try:
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    except (FileNotFoundError, ProcessLookupError):
        return 0.0
    found = [line for line in lines if line.startswith("VmHWM")]
    return float(found[0].split()[1]) / 1024 if found else 0.0


def children(pid: int) -> list[int]:
    """Processes that a process has started and that still run."""
    try:
        return [int(n) for n in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except (FileNotFoundError, ProcessLookupError):
        return []


def main() -> int:
    """Print both peaks; 1 when their sum is above the limit."""
    driver, simulator = 0.0, 0.0
    with subprocess.Popen(COMMAND, stdout=subprocess.DEVNULL) as process:
        while process.poll() is None:
            driver = max(driver, peak_mb(process.pid))
            simulator = max([simulator, *(peak_mb(child) for child in children(process.pid))])
            try:
                process.wait(0.02)
            except subprocess.TimeoutExpired:
                continue
    total = driver + simulator
    print("peak memory of one reach (armsyn reach --target 0.35 -0.1 -0.15)")
    print(f"driver {driver:.0f} MB + simulator {simulator:.0f} MB = {total:.0f} MB")
    print(f"goal: below {LIMIT_MB:g} MB")
    return int(process.returncode != 0 or simulator == 0.0 or total >= LIMIT_MB)


if __name__ == "__main__":
    raise SystemExit(main())
