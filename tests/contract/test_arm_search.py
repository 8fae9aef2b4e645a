"""The simulator looks for an arm where armsyn does, in the same order; they share no code."""

from pathlib import Path

import pytest

from armsyn.arm import find_file
from firmware_sim.errors import RigError
from firmware_sim.rig.arm_search import find_arm

FOLDERS = ("environment", "work/calibration", "home/.config/armsyn/calibration")


@pytest.mark.parametrize("configured", ["", "relative", "absolute"])
@pytest.mark.parametrize("first", range(len(FOLDERS) + 1))
def test_both_find_the_same_description(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, first: int, configured: str
) -> None:
    folders = [tmp_path / folder for folder in FOLDERS]
    if configured == "absolute":
        folders[-1] = tmp_path / "config/armsyn/calibration"
        configured = str(tmp_path / "config")
    for folder in folders:
        folder.mkdir(parents=True)
    for folder in folders[first:]:
        (folder / "koch.toml").write_text("the search does not read it")
    (tmp_path / "work").mkdir(exist_ok=True)
    monkeypatch.chdir(tmp_path / "work")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("XDG_CONFIG_HOME", configured)
    monkeypatch.setenv("ARMSYN_CALIBRATION", str(tmp_path / "environment"))
    found = find_file("koch", ".toml").resolve()
    assert find_arm("koch", None).resolve() == found
    if first < len(folders):
        assert found == folders[first] / "koch.toml"
    with pytest.raises(RigError, match=str(folders[-1])):
        find_arm("nobody", None)
