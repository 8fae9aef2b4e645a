"""Wire times against the table of the bus's arithmetic, and rates that do not fit."""

from pathlib import Path

import pytest

from armsyn.driver.adapter import adapter_latency
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


@pytest.mark.parametrize("latency", [1e-3, 16e-3])
def test_the_fitting_rate_counts_the_adapter(latency: float) -> None:
    rate = fitting_rate(1_000_000, [0.0] * 7, latency)
    busy = 2.17e-3 + 0.33e-3 + 2.0 * latency
    assert rate == pytest.approx(min(0.9 / busy, 1.0 / (busy + 0.2e-3)))
    check_rate(rate * 0.9999, 1_000_000, [0.0] * 7, latency)
    with pytest.raises(BusRateError, match=f"keeps both replies for up to {latency * 1e3:g} ms"):
        check_rate(rate * 1.0001, 1_000_000, [0.0] * 7, latency)


def test_200_hz_just_fit_behind_a_low_latency_adapter() -> None:
    check_rate(200.0, 1_000_000, [0.0] * 7, 1e-3)  # 2.17 + 0.33 + 2 x 1 + 0.5 ms


@pytest.mark.fault(15)
def test_an_adapter_as_it_comes_is_told_to_be_faster() -> None:
    with pytest.raises(
        BusRateError, match=r"set the adapter's latency timer to 1 ms .*, or use 26"
    ):
        check_rate(200.0, 1_000_000, [0.0] * 7, 16e-3)


def test_a_rate_that_starves_the_watchdog() -> None:
    check_rate(20.0 / 3.0, 1_000_000, [0.0] * 7)
    with pytest.raises(BusRateError) as caught:
        check_rate(6.6, 1_000_000, [0.0] * 7)
    message = str(caught.value)
    assert "6.6 Hz sends a goal every 152 ms" in message
    assert "after 300 ms of silence" in message
    assert message.endswith("use 6.67 Hz or more")


def test_a_wire_that_carries_no_rate_at_all() -> None:
    with pytest.raises(BusRateError) as caught:
        check_rate(10.0, 9600, [0.0] * 7)
    assert str(caught.value).endswith(": raise the baud rate")


PLACES = ("class/tty/{}/device", "bus/usb-serial/devices/{}")


@pytest.mark.parametrize("place", PLACES)
def test_the_latency_timer_is_read(tmp_path: Path, place: str) -> None:
    folder = tmp_path / place.format("ttyUSB3")
    folder.mkdir(parents=True)
    (folder / "latency_timer").write_text("16\n")
    link = tmp_path / "arm"
    link.symlink_to("/dev/ttyUSB3")
    assert adapter_latency(str(link), tmp_path) == 16e-3
    assert adapter_latency("/dev/ttyUSB4", tmp_path) == 0.0
    assert adapter_latency("/dev/pts/3", tmp_path) == 0.0


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan"), float("inf")])
def test_rates_that_are_none(rate: float) -> None:
    with pytest.raises(BusRateError, match="not a positive number"):
        check_rate(rate, 1_000_000, [0.0])
