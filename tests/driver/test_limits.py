"""What a motion is refused for before it is streamed, and what is said to help."""

import numpy as np
import pytest
from msgspec.structs import replace

from armsyn.arm import ArmDescription
from armsyn.driver.limits import check_streamed
from armsyn.driver.path import Path
from armsyn.errors import LimitError, StopRequestedError
from armsyn.motion import Motion
from armsyn.safety import CommandLimits, check_commands
from tests.driver.stepped import SteppedArm

PERIOD = 0.005
MINUTE = 12_001


def elbow(arm: ArmDescription, moved: np.ndarray, step: float) -> Motion:
    angles = np.tile(arm.rest, (len(moved), 1))
    angles[:, 3] += moved
    return Motion(time=np.arange(len(moved)) * step, joint_names=arm.joint_names, angles=angles)


def swinging(arm: ArmDescription, rows: int, jump_at: int = MINUTE) -> Motion:
    row = np.arange(rows)
    moved = 0.3 * (1.0 - np.cos(row * 2 * np.pi / 6000)) + np.where(row < jump_at, 0.0, 0.01)
    return elbow(arm, moved, PERIOD)


def refused(arm: ArmDescription, motion: Motion, off: float = 0.0) -> str:
    start = arm.rest.copy()
    start[3] += off
    limits = CommandLimits.of(arm, PERIOD, start)
    with pytest.raises(LimitError) as caught:
        check_streamed(motion, start, limits, lambda: None)
    assert caught.value.joint == arm.joint_names[3]
    return str(caught.value)


def at_speed(arm: ArmDescription) -> np.ndarray:
    """Straight from the first sample at a speed that its samples may just have at once."""
    speed = 0.9 * arm.max_acceleration[3] * 0.05
    return speed * 0.05 * np.concatenate([np.arange(6), 5 + np.cumsum([0.8, 0.5, 0.2, 0.0, 0.0])])


def test_a_motion_that_starts_at_speed_is_told_so(human7: ArmDescription) -> None:
    said = refused(human7, elbow(human7, at_speed(human7), 0.05))
    assert said.endswith("(row 1 of 11): the motion starts at speed; let it start from rest")


def test_a_motion_that_ends_at_speed_is_told_so(human7: ArmDescription) -> None:
    moved = at_speed(human7)
    said = refused(human7, elbow(human7, moved[-1] - moved[::-1], 0.05))
    assert said.endswith("(row 10 of 11): the motion ends at speed; let it come to rest")


def test_a_motion_that_starts_too_far_off_is_told_so(human7: ArmDescription) -> None:
    slow = replace(human7, joint=tuple(replace(j, max_velocity=0.3) for j in human7.joint))
    motion = swinging(slow, 600)
    check_streamed(motion, slow.rest, CommandLimits.of(slow, PERIOD), lambda: None)
    said = refused(slow, motion, off=0.045)
    assert said.endswith("the motion starts too far from where the arm stands; plan it from there")


def test_samples_that_are_too_far_apart_are_told_so(human7: ArmDescription) -> None:
    moved = np.array([0.0, 0.0, 0.0, 0.3, 0.6, 0.6, 0.6])
    said = refused(human7, elbow(human7, moved, 0.1))
    assert "the samples are too far apart there, or too fast" in said
    assert "at speed" not in said


def test_a_position_beyond_its_limit_is_no_matter_of_samples(human7: ArmDescription) -> None:
    beyond = human7.chain.upper[3] - human7.rest[3] + 0.02
    moved = beyond * 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, 1201)))
    said = refused(human7, elbow(human7, moved, PERIOD))
    assert "is outside its limit" in said
    assert said.endswith("of 1201)")


@pytest.mark.parametrize("jump", [3, 1998, 1999, 2000, 2001, 2002, 2003, 5000, 7000])
def test_a_long_motion_is_judged_as_one_stream(human7: ArmDescription, jump: int) -> None:
    motion = swinging(human7, 7001, jump)
    limits = CommandLimits.of(human7, PERIOD)
    path = Path(motion, start=human7.rest)
    whole = check_commands(np.array([path.at(k * PERIOD) for k in range(7001)]), limits)
    assert whole is not None
    said = refused(human7, motion)
    assert said.startswith(f"{whole[1]} at {min(whole[0], 7000) * PERIOD:.3f} s")


def test_a_good_motion_says_where_it_ends(human7: ArmDescription) -> None:
    motion = swinging(human7, 5001)
    end = check_streamed(motion, human7.rest, CommandLimits.of(human7, PERIOD), lambda: None)
    assert end == pytest.approx(motion.angles[-1])


def test_a_stop_is_heeded_while_a_long_motion_is_judged(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = stepped.session()
    judged: list[int] = []

    def counted(commands: np.ndarray, *args: object, **options: object) -> object:
        judged.append(len(commands))
        if len(judged) == 2:
            opened.stops.request()
        return check_commands(commands, *args, **options)  # type: ignore[arg-type]

    monkeypatch.setattr("armsyn.driver.limits.check_commands", counted)
    with pytest.raises(StopRequestedError, match="before the motion began"):
        opened.run(swinging(stepped.description, MINUTE))
    assert len(judged) == 2
    assert sum(judged) < MINUTE / 2
    assert stepped.torque() == [0] * 7
    assert stepped.value("Bus Watchdog") == [0] * 7
