"""Looking for servos: all rates, both protocols, garbled answers, adapters that refuse or echo."""

import pytest

from armsyn.driver.scan import BAUD_RATES, FoundServo, SuspectId, protocols_at, scan
from armsyn.driver.setup_plan import X_BAUD_CODES
from tests.driver.set_up_bench import SteppedLineBus, bench

MIXED = ("xm430-w350:1", "ax-12a:7", "mx-28:9", "xl-320:11")
QUICK = (1_000_000, 57_600)


def found(bus: SteppedLineBus) -> set[tuple[int, int, int, str]]:
    return {(s.baud, s.protocol, s.servo_id, s.model) for s in scan(bus, QUICK).servos}


def test_finds_every_family_at_its_factory_rate_and_writes_nothing() -> None:
    bus = bench(*MIXED)
    before = [bytes(servo.memory.data) for servo in bus.port.bus.servos]
    assert found(bus) == {
        (57_600, 2, 1, "xm430-w350"),
        (1_000_000, 1, 7, "ax-12a"),
        (57_600, 1, 9, "mx-28"),
        (1_000_000, 2, 11, "xl-320"),
    }
    changed = [
        place
        for servo, old in zip(bus.port.bus.servos, before, strict=True)
        for place, (a, b) in enumerate(zip(servo.memory.data, old, strict=True))
        if a != b and place < 24
    ]
    assert not changed


def test_says_the_firmware_and_puts_the_baud_rate_back() -> None:
    bus = bench("xm430-w350:1")
    bus.setBaudRate(2_000_000)
    (servo,) = scan(bus, (57_600,), (2,)).servos
    assert servo == FoundServo(57_600, 2, 1, 1020, 45)
    assert bus.baudrate == bus.port.baud_rate == 2_000_000


@pytest.mark.parametrize("baud", sorted(X_BAUD_CODES))
def test_knows_every_rate_of_the_x_series(baud: int) -> None:
    bus = bench("xm430-w350:252", baud=baud)
    (servo,) = scan(bus, (baud,), (2,)).servos
    assert (servo.baud, servo.servo_id) == (baud, 252)


def test_the_rates_hold_both_families_and_slow_ones_come_last() -> None:
    assert set(X_BAUD_CODES) < set(BAUD_RATES)
    assert list(BAUD_RATES) == sorted(BAUD_RATES, reverse=True)
    assert protocols_at(1_000_000) == (2, 1)
    assert protocols_at(400_000) == (1,)
    assert protocols_at(400_000, (2,)) == ()


def test_a_whole_scan_is_well_under_a_minute() -> None:
    bus = bench("xm430-w350:1")
    began = bus.port.clock.now()
    progress: list[float] = []
    scan(bus, on_progress=lambda part, *_: progress.append(part))
    assert bus.port.clock.now() - began < 40.0
    assert progress == sorted(progress)
    assert 0.0 == progress[0] < progress[-1] < 1.0


@pytest.mark.fault(7)
def test_two_servos_of_one_id_are_suspected() -> None:
    bus = bench("xm430-w350:1", "xl430-w250:3", faults=["duplicate-id:id=3,as=1"])
    result = scan(bus, (57_600,), (2,))
    assert not result.servos
    assert result.suspects == (SuspectId(57_600, 2, 1),)


def test_two_alike_of_one_id_are_told_by_where_they_stand() -> None:
    bus = bench("xm430-w350:1", "xm430-w350:3", faults=["duplicate-id:id=3,as=1"])
    bus.port.simulation.inject("push:id=1,torque=2,for=1")  # strikes both; friction differs
    bus.port.bus.servos[1].axis.jam(on=True)
    bus.wait(1.0)
    assert scan(bus, (57_600,), (2,)).suspects == (SuspectId(57_600, 2, 1),)


def test_noise_at_a_wrong_rate_is_no_suspect() -> None:
    bus = bench("xm430-w350:1")
    result = scan(bus, (1_000_000, 115_200))
    assert not result.servos
    assert not result.suspects


def test_garbage_beside_a_rate_that_works_is_no_second_servo(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    servo = FoundServo(57_600, 2, 1, 1020, 45)
    answers = {
        (57_600, 2): ([servo], [SuspectId(57_600, 2, 3)]),
        (9_600, 1): ([], [SuspectId(9_600, 1, servo_id) for servo_id in range(24)]),
    }
    monkeypatch.setattr(
        "armsyn.driver.scan.scan_rate",
        lambda bus, number: answers.get((bus.baudrate, number), ([], [])),
    )
    result = scan(bench("xm430-w350:1"), (57_600, 9_600))
    assert result.servos == (servo,)
    assert result.suspects == (SuspectId(57_600, 2, 3),)
    assert result.noisy == (9_600,)


@pytest.mark.parametrize(
    "fault", ["latency-timer:latency=0.016", "local-echo", "slow-adapter:delay=0.02"]
)
def test_slow_and_echoing_adapters_hide_nobody(fault: str) -> None:
    bus = bench(*MIXED, faults=[fault])
    assert len(found(bus)) == len(MIXED)


def test_rates_that_the_adapter_refuses_are_said() -> None:
    bus = bench("xm430-w350:1")
    bus.line.refuses = {4_500_000}
    result = scan(bus, (4_500_000, 57_600), (2,))
    assert result.refused == (4_500_000,)
    assert [servo.servo_id for servo in result.servos] == [1]


def test_a_servo_that_answers_pings_only_is_found_without_a_model() -> None:
    bus = bench("ax-12a:7")
    bus.port.bus.servos[0].write(16, b"\0")
    (servo,) = scan(bus, (1_000_000,), (1,)).servos
    assert servo == FoundServo(1_000_000, 1, 7, None, None)
    assert servo.model == "unknown"
