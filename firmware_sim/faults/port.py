"""Faults of the port itself: gone, or not for this client."""

from __future__ import annotations

from firmware_sim.faults.spec import FaultKind
from firmware_sim.faults.striking import StateFault


class Unplugged(StateFault):
    """The port is gone, as when its cable is pulled; the servos stay powered."""

    def enter(self, _when: float) -> None:
        """Take the port away."""
        self.site.unplugged_by.add(self.number)

    def leave(self, _when: float) -> None:
        """Bring it back."""
        self.site.unplugged_by.discard(self.number)


class NoPermission(StateFault):
    """The port is there, and nobody may open it."""

    def enter(self, _when: float) -> None:
        """Take the permission away."""
        self.site.forbidden_by.add(self.number)

    def leave(self, _when: float) -> None:
        """Give it back."""
        self.site.forbidden_by.discard(self.number)


KINDS = (
    FaultKind(
        "unplugged",
        (12, 13),
        "the port is gone, and comes back when its time is over",
        Unplugged,
        concerns_servo=False,
    ),
    FaultKind(
        "no-permission",
        (13,),
        "nobody may open the port (root may)",
        NoPermission,
        concerns_servo=False,
    ),
)
