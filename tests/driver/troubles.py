"""What goes wrong with an arm, as strategies of hypothesis: mostly the simulator's faults."""

from __future__ import annotations

from typing import NamedTuple

import hypothesis.strategies as st

from armsyn.arm import ArmDescription

OF_THE_LINE = (
    "bit-errors:rate=0.001", "chunked-reply", "crc-error:probability=0.3",
    "crc-error:to=servos,probability=0.2", "duplicate-reply", "foreign-traffic:every=0.02",
    "idle-noise:bytes=20,every=0.01", "late-reply:probability=0.2", "late-reply:delay=0.004",
    "local-echo", "local-echo:share=0.5", "lost-bytes:probability=0.3",
    "lost-instructions:probability=0.3", "lost-replies:probability=0.3",
    "lying-length:probability=0.2", "lying-length:length=0,to=servos,probability=0.2",
    "missing-stuffing", "noise:place=inside,probability=0.3", "noise:bytes=40,probability=0.5",
    "noise:to=servos,probability=0.3", "slow-adapter:delay=0.001,jitter=0.002",
    "truncated-status:probability=0.3", "unplugged", "return-delay", "latency-timer",
)  # fmt: skip
"""Faults of the line."""

OF_A_SERVO = (
    "alert-bit", "electrical-shock:count=1", "encoder-error:count=1", "missing-servo",
    "overheating:count=1", "overload:count=1", "reboot:count=1", "silent-servo", "wrong-baud",
    "input-voltage:count=1", "lost-instructions", "lost-replies", "crc-error",
)  # fmt: skip
"""Faults of one servo that move nothing; an ID is put to them."""

MECHANICAL = (
    "jam", "friction:factor=20", "push:torque=4", "push:torque=-4", "push:torque=12",
    "stuck-encoder",
)  # fmt: skip
"""Faults of one servo that make it move, or not move, otherwise than it was told."""

OF_THE_HOST = ("stop", "stop", "stop", "stall:0.03", "stall:0.12", "stall:0.5", "close")
OF_OTHERS = ("torque-off", "watchdog-expired", "supply-sag:voltage=7", "power-cut:count=1")
RESTARTING = ("reboot", "power-cut", "missing-servo", "torque-off")
"""After which servos have lost their torque without a hardware error."""

NEWER_ONLY = ("watchdog-expired", "encoder-error", "electrical-shock")
"""What happens to no servo of protocol 1.0."""

DISTURBING = ("jam", "friction", "push", "stuck-encoder", "hand", "supply-sag")


class Trouble(NamedTuple):
    """What goes wrong, when (s from the start) and with which servo (0: with all)."""

    after: float
    what: str
    servo_id: int = 0

    @property
    def name(self) -> str:
        """Of the fault, without its arguments."""
        return self.what.partition(":")[0]


def troubles(arm: ArmDescription) -> st.SearchStrategy[Trouble]:
    """What may go wrong while an arm is driven."""
    host = st.sampled_from(OF_THE_HOST).map(lambda what: (what, 0))
    return st.builds(
        lambda after, one: Trouble(after, *one),
        st.floats(0.0, 0.8),
        st.one_of(host, _faults(arm, (*OF_A_SERVO, *MECHANICAL, "torque-off", "watchdog-expired"))),
    )


def idle_troubles(arm: ArmDescription) -> st.SearchStrategy[Trouble]:
    """What may go wrong while nobody drives an arm."""
    hands = st.builds(
        lambda servo, by: (f"hand:to={servo.rest_tick + by},for=0.4", servo.id),
        st.sampled_from([servo for servo in arm.leaders if servo.protocol == 2]),
        st.integers(-60, 60),
    )
    return st.one_of(_faults(arm, (*OF_A_SERVO, *OF_OTHERS)), hands).map(
        lambda one: Trouble(0.0, *one)
    )


def _faults(arm: ArmDescription, kinds: tuple[str, ...]) -> st.SearchStrategy[tuple[str, int]]:
    watched = [servo.id for servo in arm.servo if servo.protocol == 2]

    def lasting(what: str, duration: float) -> str:
        if what == "torque-off" or "count=" in what:
            return what
        return f"{what}{',' if ':' in what else ':'}for={duration:.3f}"

    def ids(what: str) -> st.SearchStrategy[int]:
        if what.startswith(("supply-sag", "power-cut")):
            return st.just(0)
        everybody = [servo.id for servo in arm.servo]
        return st.sampled_from(watched if what.startswith(NEWER_ONLY) else everybody)

    durations = st.floats(0.01, 0.8)
    line = st.builds(lasting, st.sampled_from(OF_THE_LINE), durations).map(lambda what: (what, 0))
    one = st.sampled_from(kinds).flatmap(
        lambda what: st.tuples(st.builds(lasting, st.just(what), durations), ids(what))
    )
    return st.one_of(line, one)
