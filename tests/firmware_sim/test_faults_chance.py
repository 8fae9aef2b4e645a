"""When faults strike: chance, seeds, windows, and the record of it."""

import tracemalloc

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_sim.errors import FaultError
from firmware_sim.faults.frames import RequestCutter
from firmware_sim.faults.roster import FAULT_CAP, LOG_CAP
from tests.firmware_sim.faults_bench import (
    FaultBench,
    frames_of,
    read_request,
    request,
    sync_read_request,
)

TWO = ("xm430-w350:1", "xl430-w250:2")
MIXTURE = (
    "noise:probability=0.1",
    "crc-error:probability=0.1,id=1",
    "truncated-status:probability=0.05",
    "lost-instructions:id=2,probability=0.05",
    "late-reply:probability=0.05",
    "slow-adapter:jitter=0.003",
    "idle-noise:every=0.07,probability=0.5",
    "reboot:id=2,every=0.9",
    "silent-servo:id=1,at=0.5,for=0.2,every=1",
    "foreign-traffic:id=2,every=0.11",
    "push:id=1,at=0.3,for=0.5,torque=0.5",
)


def transcript(*faults: str, seed: int = 0) -> tuple[list[bytes], list[str]]:
    """What a client hears in 2 s of sync reads, and what struck."""
    bench = FaultBench(*faults, servos=TWO, seed=seed)
    heard = [bench.exchange(sync_read_request(128, 8, 1, 2), 0.02) for _ in range(100)]
    return heard, bench.told


def test_one_scenario_and_seed_give_the_same_bytes() -> None:
    heard, told = transcript(*MIXTURE, seed=5)
    assert len(set(heard)) > 10
    assert len({line.split()[5] for line in told}) == len(MIXTURE)
    assert (heard, told) == transcript(*MIXTURE, seed=5)


def test_another_seed_gives_others() -> None:
    assert transcript(*MIXTURE, seed=5) != transcript(*MIXTURE, seed=6)


def test_no_fault_shifts_the_chance_of_another() -> None:
    def struck(*faults: str) -> list[str]:
        _, told = transcript(*faults)
        return [line.split(")")[0] for line in told if "crc-error" in line]

    alone = struck("crc-error:probability=0.1")
    assert len(alone) > 5
    assert struck("noise:probability=0.3,place=after", "crc-error:probability=0.1") == alone


def test_two_faults_of_one_kind_have_chances_of_their_own() -> None:
    bench = FaultBench("lost-bytes:probability=0.5", "lost-bytes:probability=0.5")
    lengths = [len(bench.ping()) for _ in range(60)]
    assert set(lengths) == {12, 13, 14}


def test_probability_is_the_share_that_is_struck() -> None:
    bench = FaultBench("lost-replies:probability=0.25")
    lost = sum(not bench.exchange(request(1, 0x01), 0.001) for _ in range(1000))
    assert abs(lost - 250) < 4.0 * (1000 * 0.25 * 0.75) ** 0.5


def test_a_window_opens_and_closes() -> None:
    bench = FaultBench("lost-replies:at=1,for=0.5")
    lost = []
    for tenth in range(20):
        bench.wait_until(tenth * 0.1 + 0.01)
        if not bench.exchange(request(1, 0x01), 0.01):
            lost.append(tenth)
    assert lost == [10, 11, 12, 13, 14]
    assert not bench.simulation.faults


def test_count_and_every_limit_the_strikes() -> None:
    bench = FaultBench("lost-replies:count=3,every=0.1")
    lost = []
    for hundredth in range(50):
        bench.wait_until(hundredth * 0.01 + 0.001)
        if not bench.exchange(request(1, 0x01), 0.005):
            lost.append(hundredth)
    assert lost == [0, 10, 20]


def test_strikes_are_recorded_with_their_tick() -> None:
    bench = FaultBench("reboot:id=1,at=1.2345", "crc-error:at=2")
    bench.wait_until(2.5)
    bench.ping()
    first, second = bench.simulation.log
    assert (first.tick, first.time, first.name, first.number) == (1234, 1.2345, "reboot", 1)
    assert (second.tick, second.servo_id, second.number) == (2500, 1, 2)
    assert bench.told[0] == "tick 1234 (1.234500 s) fault 1 reboot servo 1"
    assert bench.simulation.strikes == {"reboot": 1, "crc-error": 1}


def test_after_counts_from_the_injection() -> None:
    bench = FaultBench()
    bench.wait_until(3.0)
    bench.simulation.inject("reboot:after=0.5")
    assert bench.simulation.next_event == pytest.approx(3.5)


@pytest.mark.parametrize(
    "text",
    [
        "reboot:id=9",
        "jam:every=1",
        "jam:every=1,for=1",
        "wrong-baud:baud=12345",
        "duplicate-id:id=1,as=9",
        "duplicate-id:id=1,as=1",
    ],
)
def test_faults_that_make_no_sense_here_are_refused(text: str) -> None:
    with pytest.raises(FaultError) as caught:
        FaultBench(text)
    assert len(str(caught.value).splitlines()) == 1
    bench = FaultBench()
    with pytest.raises(FaultError):
        bench.simulation.inject(text)
    assert not bench.simulation.faults


def test_a_watchdog_that_is_not_there_cannot_expire() -> None:
    with pytest.raises(FaultError, match="no such servo has a bus watchdog"):
        FaultBench("watchdog-expired", servos=("ax-12a:1",))


def test_faults_are_cleared_by_name_by_number_and_all() -> None:
    bench = FaultBench("crc-error", "noise", "noise:place=after", "silent-servo")
    simulation = bench.simulation
    assert [fault.number for fault in simulation.clear("noise")] == [2, 3]
    assert [fault.number for fault in simulation.clear("4")] == [4]
    with pytest.raises(FaultError, match="no fault 'noise' is in force"):
        simulation.clear("noise")
    assert [fault.number for fault in simulation.clear()] == [1]
    assert simulation.clear() == []
    assert bench.ping() == FaultBench().ping()


def test_the_number_of_faults_and_the_record_have_bounds() -> None:
    simulation = FaultBench().simulation
    for _ in range(FAULT_CAP):
        simulation.inject("crc-error:at=100")
    with pytest.raises(FaultError, match="clear some"):
        simulation.inject("crc-error")
    simulation.clear()
    simulation.inject("idle-noise:bytes=1,to=client,every=0.001")
    simulation.advance(LOG_CAP * 0.001 + 1.0)
    assert len(simulation.log) == LOG_CAP


def test_memory_stays_flat_under_faults() -> None:
    bench = FaultBench(*MIXTURE, "late-reply", servos=TWO)
    bench.told = []

    def run(cycles: int) -> None:
        for _ in range(cycles):
            bench.exchange(sync_read_request(128, 8, 1, 2), 0.004)
            bench.told.clear()
            bench.simulation._roster.log.clear()

    run(300)
    tracemalloc.start()
    try:
        run(50)
        before = tracemalloc.get_traced_memory()[0]
        run(600)
        grown = tracemalloc.get_traced_memory()[0] - before
    finally:
        tracemalloc.stop()
    assert grown < 50_000


@given(
    st.lists(
        st.sampled_from(
            [
                request(1, 0x01),
                read_request(132, 4),
                b"\xff\xff\x01\x02\x01\xfb",
                b"\xff\xff\xfd\x00\x01\xff\xff",
                b"\xff\xff\xfd\x00\x01\x00\x00",
                b"\xff",
                b"\xff\xff\xff",
                b"noise",
            ]
        )
        | st.binary(max_size=20),
        max_size=20,
    ),
    st.data(),
)
def test_cutting_requests_loses_no_byte(parts: list[bytes], data: st.DataObject) -> None:
    stream = b"".join(parts)
    cutter, out, rest = RequestCutter(), [], stream
    while rest:
        size = data.draw(st.integers(1, len(rest)))
        out += cutter.feed(rest[:size])
        rest = rest[size:]
    assert b"".join(out) + cutter.flush() == stream
    assert all(out)
    assert not cutter.holds


@settings(max_examples=50, deadline=None)
@given(st.lists(st.binary(min_size=1, max_size=40), max_size=8), st.integers(0, 10))
def test_no_bytes_of_a_client_disturb_what_faults_do_next(chunks: list[bytes], seed: int) -> None:
    bench = FaultBench(
        "noise:to=servos,probability=0.2,for=0.3",
        "lost-instructions:probability=0.2,for=0.3",
        "missing-stuffing:to=servos,for=0.3",
        "lying-length:to=servos,probability=0.3,for=0.3",
        "alert-bit:for=0.3",
        "local-echo:share=0.3,for=0.3",
        seed=seed,
    )
    for chunk in chunks:
        bench.exchange(chunk, 0.01)
    bench.wait_until(0.5)
    assert not bench.simulation.faults
    answers = frames_of(bench.ping() + bench.ping())
    assert answers[-1][4:8] == bytes((1, 7, 0, 0x55))
