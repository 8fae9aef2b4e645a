"""How AX hold a goal: margins, slopes and punch against the manuals' figures and hand calculation.

RX-64 User's Manual, page 27, has an example in figures: goal 512, margins 5, slopes 16, punch 10:
full output up to 491, from there less and less down to the punch at 507, none from 507 to 517. AX
count as RX do. e-Manual, ax-12a, "Compliance Slope (28, 29)" has the seven steps of the slope.
"""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_sim.classic.compliance import Compliance, Side, compliance, gains, slope_used
from firmware_sim.firmware.memory import Memory
from firmware_sim.tables import ax_12a, mx_28

STEP = math.radians(300.0) / 1024  # rad a step

STEPS_OF_THE_MANUAL = [
    (range(4), 2),
    (range(4, 8), 4),
    (range(8, 16), 8),
    (range(16, 32), 16),
    (range(32, 64), 32),
    (range(64, 128), 64),
    (range(128, 255), 128),
]


@pytest.mark.parametrize(("values", "used"), STEPS_OF_THE_MANUAL)
def test_slopes_have_seven_steps(values: range, used: int) -> None:
    assert {slope_used(value) for value in values} == {used}


def output(curve: Compliance, goal: int, position: int) -> float:
    """Return the duty at a position, from the curve's own numbers."""
    error = (goal - position) * STEP
    side: Side = curve.counter_clockwise if error > 0 else curve.clockwise
    beyond = abs(error) - side.margin
    if beyond <= 1e-12:
        return 0.0
    return math.copysign(min(1.0, curve.punch + side.slope * beyond), error)


def curve_of(**settings: int) -> Compliance:
    memory = Memory(ax_12a.MODELS[0].table)
    for name, value in settings.items():
        memory.store(name.replace("_", " "), value)
    return compliance(memory)


def test_the_example_of_the_rx_64_manual() -> None:
    curve = curve_of(
        CW_Compliance_Margin=5,
        CCW_Compliance_Margin=5,
        CW_Compliance_Slope=16,
        CCW_Compliance_Slope=16,
        Punch=10,
    )
    assert output(curve, 512, 200) == 1.0
    assert output(curve, 512, 491) == pytest.approx(1.0)
    assert output(curve, 512, 499) == pytest.approx(0.5 * (1.0 + 10 / 1023))  # half of the slope
    assert output(curve, 512, 506) == pytest.approx(10 / 1023 + (1.0 - 10 / 1023) / 16)
    assert {output(curve, 512, position) for position in range(507, 518)} == {0.0}
    assert output(curve, 512, 533) == pytest.approx(-1.0)


def test_each_direction_has_its_own_margin_and_slope() -> None:
    curve = curve_of(
        CW_Compliance_Margin=3,
        CCW_Compliance_Margin=7,
        CW_Compliance_Slope=8,
        CCW_Compliance_Slope=64,
        Punch=32,
    )
    rest = 1.0 - 32 / 1023
    assert output(curve, 500, 493) == 0.0  # 7 short of the goal: pushes counter-clockwise after it
    assert output(curve, 500, 491) == pytest.approx(32 / 1023 + 2 / 64 * rest)
    assert output(curve, 500, 503) == 0.0
    assert output(curve, 500, 507) == pytest.approx(-(32 / 1023 + 4 / 8 * rest))


@given(
    margin=st.integers(0, 255),
    slope=st.integers(0, 254),
    punch=st.integers(32, 1023),
    error=st.integers(-1023, 1023),
)
def test_output_grows_with_the_error_and_turns_with_its_sign(
    margin: int, slope: int, punch: int, error: int
) -> None:
    names = {"Compliance_Margin": margin, "Compliance_Slope": slope}
    curve = curve_of(
        Punch=punch, **{f"{side}_{name}": v for name, v in names.items() for side in ("CW", "CCW")}
    )
    here, further = output(curve, 0, -error), output(curve, 0, -error - (1 if error >= 0 else -1))
    assert abs(here) <= abs(further) <= 1.0
    assert output(curve, 0, error) == -here
    assert here == 0.0 or abs(here) >= punch / 1023


@pytest.mark.parametrize(("slope", "p_gain"), [(8, 128), (16, 64), (32, 32), (64, 16), (128, 8)])
def test_p_gains_do_what_slopes_did(slope: int, p_gain: int) -> None:
    # e-Manual, mx-28, "PID Gains", "The relationship between Compliance Slop and PID".
    memory = Memory(mx_28.MODELS[0].table)
    memory.store("P Gain", p_gain)
    assert gains(memory).proportional * slope * STEP == pytest.approx(1.0)


def test_i_and_d_gains_are_in_the_manuals_proportion() -> None:
    # Kp = P / 8, Ki = I * 1000 / 2048, Kd = D * 4 / 1000.
    memory = Memory(mx_28.MODELS[0].table)
    for name, value in {"P Gain": 8, "I Gain": 2048 // 16, "D Gain": 250}.items():
        memory.store(name, value)
    found = gains(memory)
    assert found.integral / found.proportional == pytest.approx(62.5)
    assert found.derivative / found.proportional == pytest.approx(1.0)
