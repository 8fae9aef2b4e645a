"""Faults of the line as a whole: the port, a second master, noise."""

import pytest

from firmware_sim.errors import FaultError
from tests.firmware_sim.faults_bench import (
    BYTE,
    FaultBench,
    crc_fits,
    frames_of,
    read_request,
    request,
)


def test_an_unplugged_port_fails_and_comes_back() -> None:
    bench = FaultBench("unplugged:at=1,for=0.5")
    assert len(bench.ping()) == 14
    bench.clock.advance_to(1.2)
    with pytest.raises(OSError, match="unplugged"):
        bench.port.write(request(1, 0x01))
    bench.clock.advance_to(1.6)
    assert len(bench.ping()) == 14


def test_servos_hold_on_while_the_port_is_unplugged() -> None:
    bench = FaultBench("unplugged:at=1,for=1")
    assert bench.write(64, 1) == 0
    bench.clock.advance_to(2.5)
    assert bench.register(64) == 1


def test_bytes_on_their_way_are_lost_when_the_port_goes() -> None:
    bench = FaultBench("unplugged:at=1,for=0.5")
    bench.wait(1.0 - 5 * BYTE)
    bench.port.write(request(1, 0x01))
    bench.clock.advance_to(1.2)
    with pytest.raises(OSError, match="unplugged"):
        bench.port.in_waiting()
    bench.clock.advance_to(1.7)
    assert bench.port.in_waiting() == 0


def test_when_the_port_comes_and_goes_is_foretold() -> None:
    simulation = FaultBench("unplugged:at=1,for=0.5", "no-permission:at=3").simulation
    seen = []
    while (event := simulation.next_event) is not None:
        simulation.advance(event)
        seen.append((event, simulation.unplugged, simulation.forbidden))
    assert seen == [(1.0, True, False), (1.5, False, False), (3.0, False, True)]


def test_a_second_master_is_heard_with_its_answers() -> None:
    bench = FaultBench("foreign-traffic:id=1,at=0.5,every=0.1,count=3")
    bench.wait(1.0)
    heard = frames_of(bench.port.read(bench.port.in_waiting(), 0.0))
    assert heard[::2] == [read_request(132, 4)] * 3
    assert [(frame[4], frame[7]) for frame in heard[1::2]] == [(1, 0x55)] * 3
    assert all(map(crc_fits, heard))


def test_what_a_second_master_writes_is_done() -> None:
    bench = FaultBench("foreign-traffic:instruction=write,address=65,size=1,value=1")
    bench.wait(0.1)
    bench.port.read(100, 0.0)
    assert bench.register(65) == 1


def test_a_second_master_of_protocol_1_speaks_protocol_1() -> None:
    bench = FaultBench("foreign-traffic:instruction=ping", servos=("ax-12a:1",))
    bench.wait(0.1)
    heard = bench.port.read(100, 0.0)
    assert heard == b"\xff\xff\x01\x02\x01\xfb" + b"\xff\xff\x01\x02\x00\xfc"


@pytest.mark.parametrize("arguments", ["instruction=reboot", "address=300"])
def test_what_protocol_1_cannot_say_is_refused(arguments: str) -> None:
    with pytest.raises(FaultError, match=r"foreign-traffic: protocol 1\.0"):
        FaultBench(f"foreign-traffic:{arguments}", servos=("ax-12a:1",))


def test_idle_noise_reaches_the_client() -> None:
    bench = FaultBench("idle-noise:bytes=7,at=0.5,to=client")
    bench.wait(0.4)
    assert bench.port.in_waiting() == 0
    bench.wait(0.2)
    assert bench.port.in_waiting() == 7
    bench.port.read(7, 0.0)
    assert len(bench.ping()) == 14


def test_servos_find_the_next_request_after_noise() -> None:
    bench = FaultBench("idle-noise:bytes=300,at=0.5,every=0.1,count=20,to=servos")
    for _ in range(25):
        bench.wait(0.1)
        assert len(bench.ping()) == 14


def test_what_left_by_itself_waits_for_whoever_asks_next() -> None:
    bench = FaultBench()
    bench.simulation.inject("idle-noise:bytes=3,to=client")
    assert bench.simulation.next_event == 0.0
    bench.simulation.catch_up(1.0)
    (noise,) = bench.simulation.advance(1.0)
    assert len(noise.data) == 3
    assert bench.simulation.next_event is None
