"""Motions as commands name them: what is said about them."""

from pathlib import Path

import numpy as np
import pytest

from armsyn.cli.motion_sources import load_motion
from armsyn.motion import Motion
from armsyn.motion.formats import write_motion


def test_what_is_taken_for_the_hand_of_markers_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for names in (("LRS", "LUS"), ("elbow", "hand")):
        path = tmp_path / f"{names[1]}.trc"
        places = np.zeros((9, 2, 3))
        write_motion(path, Motion(np.arange(9.0), landmark_names=names, landmarks=places))
        load_motion(str(path))
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "LUS.trc: its last landmark, 'LUS', is taken for the hand" in said
