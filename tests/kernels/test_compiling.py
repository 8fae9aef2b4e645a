"""Compiled code on disk is used again, but not after any source of the room has changed."""

import shutil
import subprocess
import sys
from pathlib import Path

import armsyn.kernels

CALL = """
import numpy as np
from armsyn.kernels.chain import ChainArrays, positions_along
one = np.eye(3)[None].repeat(2, axis=0)
chain = ChainArrays(one, np.ones((2, 3)), np.array([False]), np.array([-1.0]), np.array([1.0]))
positions_along(chain, np.zeros((1, 1)))
print(len(positions_along.stats.cache_hits))
"""


def test_a_change_of_another_file_makes_kernels_compile_anew(tmp_path: Path) -> None:
    package = tmp_path / "armsyn"
    shutil.copytree(
        Path(armsyn.kernels.__file__).parent,
        package / "kernels",
        ignore=shutil.ignore_patterns("__pycache__"),
    )
    (package / "__init__.py").touch()

    def cache_hits() -> int:
        done = subprocess.run(
            [sys.executable, "-c", CALL], cwd=tmp_path, capture_output=True, text=True, check=True
        )
        return int(done.stdout)

    assert [cache_hits(), cache_hits()] == [0, 1]
    with (package / "kernels" / "trigonometry.py").open("a") as source:
        source.write("# changed\n")
    assert [cache_hits(), cache_hits()] == [0, 1]


def test_no_kernel_asks_whether_a_number_is_finite_by_what_is_folded() -> None:
    """``x - x``, of which numba makes ``math.isfinite``, is 0 where sums may be reassociated."""
    for source in Path(armsyn.kernels.__file__).parent.glob("*.py"):
        code = source.read_text(encoding="utf-8").replace("``math.isfinite``", "")
        assert "math.isfinite" not in code, source.name
