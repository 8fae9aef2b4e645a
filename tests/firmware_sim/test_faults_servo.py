"""Faults of servos: what a client sees of each."""

import pytest

from tests.firmware_sim.faults_bench import FaultBench, frames_of, request, sync_read_request

TORQUE, LED, ERROR, WATCHDOG, PROFILE_VELOCITY, GOAL = 64, 65, 70, 98, 112, 116
MOVING, VELOCITY, POSITION, VOLTAGE = 122, 128, 132, 144
TWO = ("xm430-w350:1", "xm430-w350:2")


def holding(*faults: str, servos: tuple[str, ...] = ("xm430-w350:1",)) -> FaultBench:
    """Servos whose torque is on."""
    bench = FaultBench(*faults, servos=servos)
    for servo in bench.servos:
        assert bench.write(TORQUE, 1, servo_id=servo.servo_id) == 0
    return bench


def test_a_silent_servo_holds_on_and_speaks_again() -> None:
    bench = holding("silent-servo:id=2,at=1,for=0.5", servos=TWO)
    bench.wait(0.9)
    bench.wait(0.2)
    assert bench.ping(2) == b""
    assert len(bench.ping(1)) == 14
    bench.wait(0.5)
    assert bench.register(TORQUE, servo_id=2) == 1


def test_a_missing_servo_is_not_there_from_the_start() -> None:
    bench = FaultBench("missing-servo:id=2", servos=TWO)
    ids = [frame[4] for frame in frames_of(bench.exchange(request(254, 0x01), 1.0))]
    assert ids == [1]
    bench.simulation.clear("missing-servo")
    bench.wait(0.2)
    assert len(bench.ping(2)) == 14


def test_a_servo_that_goes_missing_lets_go_and_comes_back_fresh() -> None:
    bench = holding("missing-servo:id=1,at=1,for=1")
    assert bench.write(LED, 1) == 0
    bench.wait(1.5)
    assert not bench.servos[0].axis.torque_on
    assert bench.ping() == b""
    bench.wait(1.0)
    assert bench.register(TORQUE) == 0
    assert bench.register(LED) == 0


def test_a_reboot_is_deaf_for_a_moment_and_forgets_ram() -> None:
    bench = holding("reboot:at=1")
    assert bench.write(PROFILE_VELOCITY, 100, 4) == 0
    bench.wait_until(1.01)
    assert bench.exchange(request(1, 0x01), 0.01) == b""
    bench.wait(0.2)
    assert bench.register(TORQUE) == 0
    assert bench.register(PROFILE_VELOCITY, 4) == 0


def test_a_power_cut_strikes_all_and_keeps_eeprom() -> None:
    bench = FaultBench("power-cut:at=1,off=0.5", servos=TWO)
    assert bench.write(20, 77, 4, servo_id=2) == 0
    for servo_id in (1, 2):
        assert bench.write(TORQUE, 1, servo_id=servo_id) == 0
    bench.wait(1.3)
    assert bench.ping(1) == bench.ping(2) == b""
    bench.wait(0.5)
    assert bench.register(TORQUE, servo_id=1) == bench.register(TORQUE, servo_id=2) == 0
    assert bench.register(20, 4, servo_id=2) == 77


@pytest.mark.parametrize(
    ("fault", "bit"),
    [
        ("input-voltage", 0x01),
        ("overheating", 0x04),
        ("encoder-error", 0x08),
        ("electrical-shock", 0x10),
        ("overload", 0x20),
    ],
)
def test_hardware_errors_latch_until_a_reboot(fault: str, bit: int) -> None:
    bench = FaultBench(f"{fault}:at=1")
    assert bench.write(63, 0x3D) == 0  # shut down for all of them
    assert bench.write(TORQUE, 1) == 0
    bench.wait(1.0)
    status = bench.ping()
    assert status[8] == 0x80
    assert bench.register(ERROR) == bit
    assert bench.register(TORQUE) == 0
    assert bench.write(TORQUE, 1) & 0x7F != 0
    bench.exchange(request(1, 0x08))
    bench.wait(0.5)
    assert bench.register(ERROR) == 0
    assert bench.write(TORQUE, 1) == 0


def test_errors_that_shutdown_does_not_name_leave_the_torque_on() -> None:
    bench = FaultBench("overload:at=1")
    assert bench.write(63, 0x04) == 0
    assert bench.write(TORQUE, 1) == 0
    bench.wait(1.1)
    assert bench.register(ERROR) == 0x20
    assert bench.register(TORQUE) == 1


def test_wrong_baud_is_silence_at_the_right_rate_and_an_answer_at_the_other() -> None:
    bench = FaultBench("wrong-baud:id=2,baud=57600", servos=TWO)
    assert bench.ping(2) == b""
    assert len(bench.ping(1)) == 14
    bench.port.baud_rate = 57_600
    assert len(bench.ping(2)) == 14
    bench.simulation.clear()
    bench.port.baud_rate = 1_000_000
    assert len(bench.ping(2)) == 14


def test_two_servos_with_one_id_talk_into_each_other() -> None:
    bench = FaultBench(servos=TWO)
    assert bench.write(20, 0x155, 4, servo_id=1) == 0
    assert bench.write(20, 0x2AA, 4, servo_id=2) == 0
    bench.simulation.inject("duplicate-id:id=2,as=1")
    assert bench.ping(2) == b""
    answer = bench.exchange(request(1, 0x02, b"\x14\x00\x04\x00"))
    assert answer[9:13] == (0x155 & 0x2AA).to_bytes(4, "little")
    bench.simulation.clear("duplicate-id")
    assert bench.register(20, 4, servo_id=1) == 0x155
    assert bench.register(20, 4, servo_id=2) == 0x2AA


def test_an_expired_watchdog_refuses_goals_until_it_is_cleared() -> None:
    bench = holding("watchdog-expired:at=1")
    bench.wait(1.1)
    assert bench.register(WATCHDOG) == -1
    assert bench.write(GOAL, 2000, 4) & 0x7F != 0
    assert bench.write(WATCHDOG, 0) == 0
    assert bench.write(GOAL, 2000, 4) == 0


def test_a_watchdog_of_a_servo_at_rest_does_not_expire() -> None:
    bench = FaultBench("watchdog-expired:at=1")
    bench.wait(1.1)
    assert bench.register(WATCHDOG) == 0


def test_a_fold_takes_the_turns_away() -> None:
    bench = FaultBench("multi-turn-fold:at=5")
    assert bench.write(11, 4) == 0
    assert bench.write(TORQUE, 1) == 0
    assert bench.write(GOAL, 2048 + 3 * 4096, 4) == 0
    bench.wait(4.5)
    before = bench.register(POSITION, 4)
    assert before == pytest.approx(2048 + 3 * 4096, abs=20)
    bench.wait(0.6)
    assert bench.register(POSITION, 4) == pytest.approx(before - 3 * 4096, abs=2)


def test_a_fold_waits_until_the_servo_stands() -> None:
    bench = FaultBench("multi-turn-fold:at=0.5")
    assert bench.write(11, 4) == 0
    assert bench.write(TORQUE, 1) == 0
    assert bench.write(GOAL, 2048 + 3 * 4096, 4) == 0
    bench.wait(0.5)
    assert not bench.told
    bench.wait(5.0)
    assert len(bench.told) == 1
    assert bench.register(POSITION, 4) == pytest.approx(2048, abs=20)


def test_a_jammed_servo_does_not_move_and_overloads() -> None:
    bench = holding("jam")
    assert bench.write(GOAL, 3000, 4) == 0
    bench.wait(0.5)
    assert bench.register(POSITION, 4) == pytest.approx(2048, abs=20)
    bench.wait(10.0)
    assert bench.register(ERROR) & 0x20
    assert bench.register(TORQUE) == 0


def test_a_freed_servo_goes_on() -> None:
    bench = holding("jam:for=0.3")
    assert bench.write(GOAL, 3000, 4) == 0
    bench.wait(2.0)
    assert bench.register(POSITION, 4) == pytest.approx(3000, abs=20)


def test_a_push_moves_what_is_loose_and_bends_what_holds() -> None:
    loose = FaultBench("push:torque=1,for=0.5")
    loose.wait(0.6)
    firm = holding("push:torque=1")
    firm.wait(0.6)
    assert loose.register(POSITION, 4) < 1500
    assert 1900 < firm.register(POSITION, 4) < 2048


def test_friction_slows_and_stops() -> None:
    places = []
    for fault in ((), ("friction:factor=100",)):
        bench = holding(*fault)
        assert bench.write(GOAL, 3000, 4) == 0
        bench.wait(1.0)
        places.append(bench.register(POSITION, 4))
    assert places[0] == pytest.approx(3000, abs=20)
    assert places[1] < 2900


def test_a_stuck_encoder_shows_where_the_horn_was() -> None:
    bench = holding("stuck-encoder:at=0.2")
    bench.wait(0.2)
    assert bench.write(GOAL, 2500, 4) == 0
    bench.wait(0.5)
    assert bench.register(POSITION, 4) == pytest.approx(2048, abs=2)
    assert bench.servos[0].axis.angle > 0.2 + 2048 / 4096 * 6.2832 - 3.1416


def test_a_sagging_supply_is_measured_and_reported_as_an_error() -> None:
    bench = FaultBench("supply-sag:voltage=9,at=1,for=1", servos=TWO)
    normal = bench.register(VOLTAGE, 2)
    bench.wait(1.5)
    assert bench.register(VOLTAGE, 2) == pytest.approx(90, abs=1)
    assert bench.register(ERROR) & 0x01
    bench.wait(1.0)
    assert bench.register(VOLTAGE, 2) == normal


def test_overlapping_faults_of_one_state_end_apart() -> None:
    bench = FaultBench("silent-servo:id=1,for=1", "silent-servo:for=2", servos=TWO)
    bench.wait(1.5)
    assert bench.ping(1) == bench.ping(2) == b""
    bench.wait(1.0)
    assert len(bench.ping(1)) == len(bench.ping(2)) == 14


def test_overlapping_sags_end_at_the_normal_voltage() -> None:
    bench = FaultBench("supply-sag:voltage=11,for=2", "supply-sag:voltage=10.5,at=1,for=2")
    seen = []
    for _ in range(4):
        bench.wait(0.9)
        seen.append(bench.register(VOLTAGE, 2))
    assert seen == [110, 105, 105, 120]


def test_states_come_again_every_so_often() -> None:
    bench = FaultBench("silent-servo:at=1,for=0.5,every=2,count=2")
    heard = []
    for _ in range(14):
        heard.append(bool(bench.ping()))
        bench.wait(0.45)
    silent = [index * 0.5 for index, there in enumerate(heard) if not there]
    assert silent == [1.0, 3.0]


def test_a_silent_servo_has_no_turn_in_a_sync_read() -> None:
    bench = FaultBench("silent-servo:id=1", servos=TWO)
    answers = frames_of(bench.exchange(sync_read_request(POSITION, 4, 1, 2), 0.2))
    assert 1 not in [frame[4] for frame in answers]
