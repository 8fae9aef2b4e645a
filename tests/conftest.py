"""Fixtures that every room's tests share."""

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def captures() -> Path:
    """The folder of captured motion; tests that need it are skipped where it is absent."""
    folder = Path(os.environ.get("ARMSYN_CAPTURES") or ROOT.parent / "shared" / "captures")
    if not (folder / "README.md").is_file():
        pytest.skip(f"no captures: set ARMSYN_CAPTURES, or place them in {folder}")
    return folder
