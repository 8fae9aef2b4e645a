"""A run over a wire that damages replies: whatever comes back, the arm is never told nonsense."""

import contextlib

import numpy as np
import pytest

from armsyn.arm import ArmDescription
from armsyn.driver import Ending
from armsyn.errors import BusError
from tests.driver.stepped import SteppedArm


class NoisyWire:
    """Drops, cuts, flips and invents bytes, as often as `rate` says and as its seed has it."""

    def __init__(self, seed: int, rate: float) -> None:
        self.rng = np.random.default_rng(seed)
        self.rate = rate
        self.damaged = 0

    def __call__(self, data: bytes) -> bytes:
        if not data or self.rng.random() >= self.rate:
            return data
        self.damaged += 1
        place = int(self.rng.integers(len(data)))
        match self.rng.integers(4):
            case 0:
                return b""
            case 1:
                return data[:place]
            case 2:
                flipped = data[place] ^ 1 << int(self.rng.integers(8))
                return data[:place] + bytes([flipped]) + data[place + 1 :]
            case _:
                noise = self.rng.choice(np.array([0xFF, 0xFD, 0x00, 0x55]), size=place % 9)
                return data[:place] + bytes(noise.tolist()) + data[place:]


@pytest.mark.fault(1)
@pytest.mark.parametrize("rate", [0.01, 0.05, 0.3])
@pytest.mark.parametrize("seed", range(4))
def test_noise_never_reaches_the_goals(human7: ArmDescription, seed: int, rate: float) -> None:
    stepped = SteppedArm(human7)
    session = stepped.session()
    way = stepped.way(0.6, 0.3, -0.6, 0.9)
    wire = NoisyWire(seed, rate)
    stepped.at(0.0, lambda: setattr(stepped, "damage", wire))
    with contextlib.suppress(BusError):  # too much noise is a fault of the bus, and of nothing else
        session.run(way)
    recording = session.recording
    assert recording is not None
    assert recording.ending is (Ending.COMPLETED if session.fault is None else Ending.FAULT)
    assert wire.damaged > 0
    assert stepped.torque() == [1] * 7  # noise is no reason to let an arm fall
    steps = np.abs(np.diff(recording.commanded_rad, axis=0))
    assert (steps <= human7.max_velocity / 200.0 * 1.05 + 1e-12).all()
    assert (recording.commanded_rad >= human7.chain.lower - 1e-6).all()
    assert (recording.commanded_rad <= human7.chain.upper + 1e-6).all()
    # what was taken for a measurement was one: near its command, however the wire lied
    off = np.abs(recording.measured_rad - recording.commanded_rad)[~recording.stale]
    assert off.max() < 0.35
    last = human7.calibration.to_ticks(recording.commanded_rad[-1])
    goals = np.array(stepped.value("Goal Position"))
    assert (np.abs(goals - last) <= 1).all()
