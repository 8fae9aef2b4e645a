"""Wire times against the table of the bus's arithmetic, and rates that do not fit."""

import pytest

from armsyn.driver.timing import check_rate, cycle_wire_time, fitting_rate
from armsyn.errors import BusRateError

# servos, bytes read, return delay (us): milliseconds at 57600, 1 M and 4 M baud
TABLE = [
    (6, 4, 500, (29.7, 4.54, 3.38)),
    (6, 4, 0, (26.7, 1.54, 0.39)),
    (7, 10, 500, (41.2, 5.67, 4.04)),
    (7, 10, 0, (37.7, 2.17, 0.54)),
]


@pytest.mark.parametrize(("servos", "size", "delay", "expected"), TABLE)
def test_cycle_on_the_wire(servos: int, size: int, delay: int, expected: tuple[float, ...]) -> None:
    for baud, milliseconds in zip((57_600, 1_000_000, 4_000_000), expected, strict=True):
        cycle = cycle_wire_time(servos, baud, [delay * 1e-6] * servos, size)
        assert cycle * 1e3 == pytest.approx(milliseconds, abs=0.06 if baud < 1e5 else 0.006)


def test_factory_return_delay_is_refused_with_the_arithmetic() -> None:
    with pytest.raises(BusRateError) as caught:
        check_rate(200.0, 1_000_000, [500e-6] * 7)
    message = str(caught.value)
    for part in ("200 Hz leaves 5.00 ms", "5.67 ms", "2.17 ms of bytes", "3.50 ms of return delay"):
        assert part in message
    assert "Return Delay Time (register 9) to 0" in message
    assert caught.value.cycle_s == pytest.approx(5.67e-3)


def test_no_return_delay_carries_200_hz() -> None:
    check_rate(200.0, 1_000_000, [0.0] * 7)


def test_a_slow_bus_is_told_to_be_faster() -> None:
    with pytest.raises(BusRateError, match="raise the baud rate, or use 20 Hz or less"):
        check_rate(200.0, 57_600, [0.0] * 7)


@pytest.mark.parametrize("baud", [57_600, 1_000_000, 4_000_000])
@pytest.mark.parametrize("delay", [0.0, 500e-6])
def test_the_fitting_rate_just_fits(baud: int, delay: float) -> None:
    rate = fitting_rate(baud, [delay] * 7)
    check_rate(rate * 0.9999, baud, [delay] * 7)
    with pytest.raises(BusRateError):
        check_rate(rate * 1.0001, baud, [delay] * 7)


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan"), float("inf")])
def test_rates_that_are_none(rate: float) -> None:
    with pytest.raises(BusRateError, match="not a positive number"):
        check_rate(rate, 1_000_000, [0.0])
