"""What `armsyn status` shows: tables for people, and the document for programs."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from rich.console import Console, Group
from rich.table import Table
from rich.text import Text

from armsyn.driver import registers as reg
from armsyn.driver.status import ArmStatus, ServoStatus
from armsyn.driver.status_findings import Finding

WIDTH = 120
"""Columns where nobody looks on: a file, a pipe."""

_MODES = {
    0: "current",
    1: "velocity",
    3: "position",
    4: "extended",
    5: "current+position",
    16: "PWM",
}
_XL320_MODES = {1: "wheel", 2: "joint"}
_UNKNOWN = "-"


def console() -> Console:
    """Where tables go: standard output, wide where it is no terminal."""
    screen = Console(highlight=False, markup=False)
    return screen if screen.is_terminal else Console(highlight=False, markup=False, width=WIDTH)


def state_table(status: ArmStatus) -> Table:
    """Posture and health, one row a servo."""
    table = Table(box=None, pad_edge=False)
    for name in ("joint", "ID", "angle", "goal", "to limit", "torque", "load", "V", "C", "error"):
        table.add_column(name, justify="left" if name in ("joint", "error") else "right")
    room = dict(zip(status.arm.joint_names, status.to_limits.tolist(), strict=True))
    for servo in status.servos:
        own = servo.described.shadow_of is None
        table.add_row(
            *_cells(
                servo.described.joint if own else f"  shadow of {servo.described.shadow_of}",
                servo.described.id,
                _degrees(servo.angle),
                _degrees(servo.goal) if servo.torque else "",
                _degrees(room.get(servo.described.joint) if own else None),
                {True: "on", False: "off", None: None}[servo.torque],
                _load(servo),
                _number(servo.voltage, ".1f"),
                _number(servo.temperature, ".0f"),
                _errors(servo),
            )
        )
    return table


def settings_table(status: ArmStatus) -> Table:
    """Model, firmware and settings, one row a servo."""
    table = Table(box=None, pad_edge=False)
    for name in (
        *("ID", "model", "firmware", "mode", "drive mode", "delay us", "replies"),
        *("watchdog", "2nd ID", "tick", "goal tick"),
    ):
        table.add_column(name, justify="left" if name in ("model", "mode") else "right")
    for servo in status.servos:
        values = servo.values
        second = values.get("Secondary ID", reg.NO_SECONDARY_ID)
        table.add_row(
            *_cells(
                servo.described.id,
                servo.model.name if servo.model is not None else servo.number,
                servo.firmware,
                _mode(servo),
                values.get("Drive Mode"),
                _number(servo.return_delay, ".0f", 1e6),
                values.get("Status Return Level"),
                _watchdog(servo),
                second if second < reg.NO_SECONDARY_ID else "",
                values.get("Present Position"),
                values.get("Goal Position"),
            )
        )
    return table


def hand_line(status: ArmStatus) -> str:
    """Where the hand is."""
    hand = status.hand
    if hand is None:
        return "hand: not known, as a joint's angle is not"
    x, y, z = hand.tolist()
    return f"hand: x {x:z.3f}, y {y:z.3f}, z {z:z.3f} m (base frame)"


def bus_line(status: ArmStatus) -> str:
    """Baud rate, adapter, and the rate that fits."""
    rate = status.fitting_rate
    latency = f"{status.latency * 1e3:.0f} ms" if status.latency else "no timer"
    fits = f"up to {rate:.0f} Hz" if rate is not None else "not known"
    found = sum(servo.answers for servo in status.servos)
    return (
        f"bus: {status.baud} baud, adapter latency {latency}, rate that fits {fits},"
        f" {found} of {len(status.servos)} servos answer"
    )


def finding_lines(findings: Iterable[Finding]) -> list[Text]:
    """Findings in one line each; those that many servos share, together."""
    shared: dict[tuple[str, str, str], list[str]] = {}
    for finding in findings:
        shared.setdefault((finding.level, finding.what, finding.cure), []).append(finding.where)
    lines = []
    for (level, what, cure), where in shared.items():
        ending = f": {cure}" if cure else ""
        style = "bold red" if level == "problem" else "yellow"
        lines.append(Text(f"{level}: {', '.join(where)}: {what}{ending}", style=style))
    return lines


def live_view(status: ArmStatus, findings: Iterable[Finding]) -> Group:
    """Posture and health with the problems below, for a live table."""
    problems = finding_lines(f for f in findings if f.level == "problem")
    return Group(state_table(status), Text(hand_line(status)), *problems)


def document(status: ArmStatus, findings: Iterable[Finding]) -> dict[str, Any]:
    """The status for programs, in SI units and degrees Celsius; None for what is not known."""
    hand = status.hand
    room = [None if math.isnan(value) else value for value in status.to_limits.tolist()]
    return {
        "arm": status.arm.name,
        "port": status.port,
        "baud": status.baud,
        "latency_s": status.latency,
        "fitting_rate_hz": status.fitting_rate,
        "posture_rad": [None if np.isnan(a) else a for a in status.posture.tolist()],
        "to_limits_rad": room,
        "hand_m": None if hand is None else hand.tolist(),
        "servos": [_entry(servo) for servo in status.servos],
        "unexpected_ids": list(status.unexpected),
        "findings": [
            {"level": f.level, "where": f.where, "what": f.what, "cure": f.cure} for f in findings
        ],
    }


def _entry(servo: ServoStatus) -> dict[str, Any]:
    return {
        "id": servo.described.id,
        "joint": servo.described.joint,
        "answers": servo.answers,
        "model": servo.model.name if servo.model is not None else None,
        "firmware": servo.firmware,
        "voltage_v": servo.voltage,
        "temperature_c": servo.temperature,
        "current_a": servo.current,
        "load_percent": servo.load,
        "torque": servo.torque,
        "angle_rad": servo.angle,
        "goal_rad": servo.goal,
        "registers": dict(servo.values),
    }


def _cells(*values: object) -> list[Text]:
    return [Text(_UNKNOWN if value is None else str(value)) for value in values]


def _number(value: float | None, form: str, factor: float = 1.0) -> str | None:
    return None if value is None else format(value * factor, form)


def _degrees(angle: float | None) -> str | None:
    return None if angle is None or math.isnan(angle) else f"{math.degrees(angle):z.1f}"


def _load(servo: ServoStatus) -> str | None:
    if servo.current is not None:
        return f"{servo.current:z.2f} A"
    return None if servo.load is None else f"{servo.load:z.0f} %"


def _errors(servo: ServoStatus) -> str:
    if servo.model is None:
        return "no reply" if not servo.answers else "unknown model"
    return reg.hardware_error_names(servo.hardware_error) if servo.hardware_error else ""


def _mode(servo: ServoStatus) -> str | None:
    mode = servo.values.get("Operating Mode")
    if mode is None or servo.model is None:
        return None
    return (_XL320_MODES if servo.model.layout is reg.XL320 else _MODES).get(mode, str(mode))


def _watchdog(servo: ServoStatus) -> str | None:
    value = servo.values.get("Bus Watchdog")
    if value is None:
        return None
    return {0: "off", reg.WATCHDOG_EXPIRED: "expired"}.get(value, f"{value * 20} ms")
