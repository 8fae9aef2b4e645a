"""Coming to rest from speeds and rooms as small as numbers get."""

import numpy as np
import pytest

from armsyn.driver.course import Coast


@pytest.mark.parametrize("speed", [5e-324, 1e-310, -1e-310, 1e-12])
@pytest.mark.parametrize("room", [0.0, 5e-324, 1e-310, 1.0])
def test_a_joint_that_hardly_moves_comes_to_rest(speed: float, room: float) -> None:
    one = np.ones(1)
    coast = Coast(np.zeros(1), speed * one, one, -room * one, room * one)
    for elapsed in np.linspace(0.0, coast.duration, 7):
        assert abs(coast.at(elapsed)[0]) <= 1e-12  # warnings are errors here
