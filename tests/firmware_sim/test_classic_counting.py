"""How AX, MX and XL-320 count positions, against the e-Manual's figures."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_sim.classic.counting import Mode, StepCount, TickCount, mode_of
from firmware_sim.firmware.memory import Memory
from firmware_sim.tables import ax_12a, mx_28, mx_106, xl_320

STEPS_PER_TURN = 1024 * 360 / 300
MULTI_TURN = {"CW_Angle_Limit": 4095, "CCW_Angle_Limit": 4095}


def memory_of(table_file: object, **settings: int) -> Memory:
    memory = Memory(table_file.MODELS[0].table)  # type: ignore[attr-defined]
    for name, value in settings.items():
        memory.store(name.replace("_", " "), value)
    return memory


@pytest.mark.parametrize(
    ("limits", "mode"),
    [
        ((0, 0), Mode.WHEEL),
        ((0, 4095), Mode.JOINT),
        ((100, 200), Mode.JOINT),
        ((0, 100), Mode.JOINT),
        ((4095, 4095), Mode.MULTI_TURN),
    ],
)
def test_angle_limits_choose_the_mode(limits: tuple[int, int], mode: Mode) -> None:
    memory = memory_of(mx_28, CW_Angle_Limit=limits[0], CCW_Angle_Limit=limits[1])
    assert mode_of(memory) is mode


def test_an_ax_has_no_multi_turn_mode() -> None:
    assert mode_of(memory_of(ax_12a, CW_Angle_Limit=1023)) is Mode.JOINT
    assert mode_of(memory_of(ax_12a, CW_Angle_Limit=0, CCW_Angle_Limit=0)) is Mode.WHEEL


@pytest.mark.parametrize(("control_mode", "mode"), [(1, Mode.WHEEL), (2, Mode.JOINT)])
def test_control_mode_chooses_the_mode_of_an_xl_320(control_mode: int, mode: Mode) -> None:
    memory = memory_of(xl_320, Control_Mode=control_mode, CW_Angle_Limit=0, CCW_Angle_Limit=0)
    assert mode_of(memory) is mode


@pytest.mark.parametrize(
    ("degrees", "position"),
    [(0.0, 0), (150.0, 512), (299.0, 1021), (300.0, 1023), (315.0, 1023), (345.0, 0), (359.9, 0)],
)
def test_a_potentiometer_has_a_dead_zone(degrees: float, position: int) -> None:
    steps = degrees * 1024 / 300
    assert StepCount().position(steps) == position
    assert StepCount().position(steps - STEPS_PER_TURN) == position


@given(position=st.integers(0, 1023), turn=st.integers(-5, 5))
def test_a_step_goal_is_in_the_turn_of_the_shaft(position: int, turn: int) -> None:
    near = (turn + 0.4) * STEPS_PER_TURN
    angle = StepCount().steps(position, near)
    assert StepCount().position(angle) == position
    assert math.floor(angle / STEPS_PER_TURN + 1e-9) == turn


def test_an_mx_shows_one_turn_outside_multi_turn_mode() -> None:
    count = TickCount(memory_of(mx_28, Multi_Turn_Offset=1024, Resolution_Divider=4))
    assert [count.position(ticks) for ticks in (0, 2048, 4095, 4096, -1)] == [
        0,
        2048,
        4095,
        0,
        4095,
    ]
    assert count.steps(100, near=4096 * 3 + 5) == 4096 * 3 + 100


def test_offset_and_divider_as_in_the_manuals_examples() -> None:
    # "Multi Turn Offset (20)": 2048 with an offset of 1024 returns 3072. "Resolution Divider (22)":
    # 2048 with a divider of 2 yields 1024; with 4 and an offset of 1024, (2048/4) + 1024 = 1536
    # (the page says 1535).
    for settings, shown in (
        ({"Multi_Turn_Offset": 1024}, 3072),
        ({"Resolution_Divider": 2}, 1024),
        ({"Resolution_Divider": 4, "Multi_Turn_Offset": 1024}, 1536),
    ):
        count = TickCount(memory_of(mx_28, **MULTI_TURN, **settings))
        assert count.position(2048) == shown
        assert count.steps(shown, near=0) == 2048


@pytest.mark.parametrize(("divider", "turns"), [(1, 7), (2, 14), (3, 21), (4, 28)])
def test_multi_turn_reaches_28_turns(divider: int, turns: int) -> None:
    # "can turn up to 7 revolutions in either CW or CCW direction"; "up to 28 turns".
    count = TickCount(memory_of(mx_28, **MULTI_TURN, Resolution_Divider=divider))
    assert count.position(turns * 4096) == 28_672
    assert count.position((turns + 1) * 4096) == 28_672
    assert count.position(-(turns + 1) * 4096) == -28_672


@given(
    goal=st.integers(-20_000, 20_000),
    offset=st.integers(-4000, 4000),
    divider=st.integers(1, 4),
    start=st.integers(-100_000, 100_000),
)
def test_a_multi_turn_goal_is_shown_when_reached(
    goal: int, offset: int, divider: int, start: int
) -> None:
    settings = {"Multi_Turn_Offset": offset, "Resolution_Divider": divider}
    count = TickCount(memory_of(mx_28, **MULTI_TURN, **settings))
    count.fold(start)
    assert count.position(count.steps(goal, near=start)) == goal


def test_folding_forgets_turns() -> None:
    count = TickCount(memory_of(mx_28, **MULTI_TURN))
    assert count.position(5 * 4096 + 10) == 5 * 4096 + 10
    count.fold(5 * 4096 + 10)
    assert count.position(5 * 4096 + 10) == 10


def test_reverse_mode_of_an_mx_106_turns_positions_but_not_in_wheel_mode() -> None:
    # mx-106, "Drive Mode (10)": "not available" in wheel mode.
    reverse = TickCount(memory_of(mx_106, Drive_Mode=1))
    assert reverse.position(1000) == 3095
    assert reverse.steps(3095, near=0) == 1000
    wheel = TickCount(memory_of(mx_106, Drive_Mode=1, CW_Angle_Limit=0, CCW_Angle_Limit=0))
    assert wheel.position(1000) == 1000
