"""Arms that are only looked at, on the stepped clock."""

from pathlib import Path

import numpy as np
import pytest

from armsyn.driver import Ending, load_recording, save_recording
from armsyn.driver.monitor import ArmMonitor
from armsyn.driver.observe import Observer
from armsyn.errors import InputError
from tests.driver.stepped import SteppedArm, without


def observer_of(stepped: SteppedArm, folder: Path, rate: float = 100.0) -> Observer:
    monitor = ArmMonitor.attach(stepped.bus, stepped.description)
    return Observer(monitor, rate, folder, simulated=True, clock=stepped)


def test_a_limp_arm_is_recorded_and_nothing_written(stepped: SteppedArm, tmp_path: Path) -> None:
    observer = observer_of(stepped, tmp_path)
    stepped.bus.serial_port.written.clear()
    recording = observer.record(1.0)
    reads = {packet[7] for packet in stepped.bus.serial_port.written}
    assert reads <= {0x02, 0x82, 0x8A}  # read, sync read, fast sync read
    assert recording.ending is Ending.OBSERVED
    assert recording.ticks == len(recording.time_s) == 100
    assert recording.time_s == pytest.approx(np.arange(100) / 100.0, abs=1e-6)
    rest = np.tile(stepped.description.rest, (100, 1))
    assert recording.measured_rad == pytest.approx(rest, abs=0.001)
    assert np.isnan(recording.commanded_rad).all()
    assert not recording.stale.any()
    assert stepped.torque() == [0] * 7
    assert (recording.temperature_c[-1] > 20.0).all()
    assert recording.voltage_v[-1] == pytest.approx(np.full(7, 12.0), abs=0.5)


def test_it_reads_back_and_gives_a_motion(stepped: SteppedArm, tmp_path: Path) -> None:
    recording = observer_of(stepped, tmp_path).record(0.5)
    save_recording(tmp_path / "seen.npz", recording, stepped.description)
    again = load_recording(tmp_path / "seen.npz")
    assert again.ending is Ending.OBSERVED
    assert np.array_equal(again.measured_rad, recording.measured_rad)
    assert np.array_equal(again.temperature_c, recording.temperature_c, equal_nan=True)
    assert np.isnan(again.commanded_rad).all()
    assert np.isnan(recording.tracking_rms())


def test_a_request_ends_it(stepped: SteppedArm, tmp_path: Path) -> None:
    observer = observer_of(stepped, tmp_path)
    stepped.at(0.3, observer.stops.request)
    recording = observer.record()
    assert 0.29 < recording.time_s[-1] < 0.33
    assert observer.stops.count == 0


def test_ticks_that_are_missed_are_counted_and_not_made_up_for(
    stepped: SteppedArm, tmp_path: Path
) -> None:
    observer = observer_of(stepped, tmp_path)
    stepped.at(0.3, lambda: stepped.clock.advance(0.1))
    recording = observer.record(1.0)
    assert recording.missed_ticks in (9, 10)
    assert recording.ticks + recording.missed_ticks == 100
    assert np.diff(recording.time_s).min() > 0.0


def test_lost_replies_are_stale(stepped: SteppedArm, tmp_path: Path) -> None:
    observer = observer_of(stepped, tmp_path)
    stepped.at(0.5, lambda: setattr(stepped, "damage", without(4)))
    recording = observer.record(1.0)
    assert not recording.stale[:40].any()
    assert recording.stale[-20:, 3].all()


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan"), float("inf")])
def test_no_time_is_refused(stepped: SteppedArm, tmp_path: Path, seconds: float) -> None:
    with pytest.raises(InputError, match="is no time to record"):
        observer_of(stepped, tmp_path).record(seconds)


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan")])
def test_no_rate_is_refused(stepped: SteppedArm, tmp_path: Path, rate: float) -> None:
    with pytest.raises(InputError, match="is not a positive number"):
        observer_of(stepped, tmp_path, rate)
