"""MX-106 with protocol 1.0: its control table and motor.

Rows, access and initial values: e-Manual, docs/en/dxl/mx/mx-106, "Control Table of EEPROM Area" and
"Control Table of RAM Area"; addresses and sizes also in rustypot's register list. Ranges: the same
page, "Control Table Description". Motor: the same page, "Specifications". It is sold with this
firmware; the one for protocol 2.0, another table, has to be put in ("Note" of the same page).

Realtime Tick(50) exists from firmware 40 on, as the page says. 44 is "Registered" in the page's
table and "Registered Instruction" in its text. 70 is "Torque Ctrl Mode
Enable" in the table. Drive Mode(10) has a bit 1 for a slave on a sync cable, which is not modelled
and refused. The firmware's number is not in the manual.
"""

from __future__ import annotations

from firmware_sim.classic.rows import MX_BAUD_RATES, MX_UNITS
from firmware_sim.classic.rows import classic_row as row
from firmware_sim.firmware.control_table import ControlTable, Register
from firmware_sim.firmware.model import MotorData, ServoModel

_REALTIME_TICK_FROM = 40


def _rows() -> list[Register]:
    return [
        row(0, 2, "Model Number", "R", 320),
        row(2, 1, "Firmware Version", "R", 41),
        row(3, 1, "ID", "RW", 1, (0, 253)),
        row(4, 1, "Baud Rate", "RW", 34, (0, 252)),
        row(5, 1, "Return Delay Time", "RW", 250, (0, 254), "2 us"),
        row(6, 2, "CW Angle Limit", "RW", 0, (0, 4095), "0.088 deg"),
        row(8, 2, "CCW Angle Limit", "RW", 4095, (0, 4095), "0.088 deg"),
        row(10, 1, "Drive Mode", "RW", 0, (0, 1)),
        row(11, 1, "Temperature Limit", "RW", 80, (0, 100), "deg C"),
        row(12, 1, "Min Voltage Limit", "RW", 60, (50, 160), "0.1 V"),
        row(13, 1, "Max Voltage Limit", "RW", 160, (50, 160), "0.1 V"),
        row(14, 2, "Max Torque", "RW", 1023, (0, 1023), "0.1 %"),
        row(16, 1, "Status Return Level", "RW", 2, (0, 2)),
        row(17, 1, "Alarm LED", "RW", 36, (0, 127)),
        row(18, 1, "Shutdown", "RW", 36, (0, 127)),
        row(20, 2, "Multi Turn Offset", "RW", 0, (-24_576, 24_576), "tick"),
        row(22, 1, "Resolution Divider", "RW", 1, (1, 4)),
        row(24, 1, "Torque Enable", "RW", 0, (0, 1)),
        row(25, 1, "LED", "RW", 0, (0, 1)),
        row(26, 1, "D Gain", "RW", 0, (0, 254)),
        row(27, 1, "I Gain", "RW", 0, (0, 254)),
        row(28, 1, "P Gain", "RW", 32, (0, 254)),
        row(30, 2, "Goal Position", "RW", 0, (-28_672, 28_672), "0.088 deg"),
        row(32, 2, "Moving Speed", "RW", 0, (0, 2047), "0.114 rev/min"),
        row(34, 2, "Torque Limit", "RW", 1023, (0, 1023), "0.1 %"),
        row(36, 2, "Present Position", "R", 0, (-32_768, 32_767), "0.088 deg"),
        row(38, 2, "Present Speed", "R", 0, (0, 2047), "0.114 rev/min"),
        row(40, 2, "Present Load", "R", 0, (0, 2047), "0.1 %"),
        row(42, 1, "Present Voltage", "R", 0, unit="0.1 V"),
        row(43, 1, "Present Temperature", "R", 0, unit="deg C"),
        row(44, 1, "Registered Instruction", "R", 0, (0, 1)),
        row(46, 1, "Moving", "R", 0, (0, 1)),
        row(47, 1, "Lock", "RW", 0, (0, 1)),
        row(48, 2, "Punch", "RW", 0, (0, 1023), "0.1 %"),
        row(68, 2, "Current", "RW", 0, unit="4.5 mA from 2048"),
        row(70, 1, "Torque Control Mode Enable", "RW", 0, (0, 1)),
        row(71, 2, "Goal Torque", "RW", 0, (0, 2047), "4.5 mA"),
        row(73, 1, "Goal Acceleration", "RW", 0, (0, 254), "8.583 deg/s^2"),
    ]


def _model(firmware: int, first: int, last: int | None, rows: list[Register]) -> ServoModel:
    return ServoModel(
        name="mx-106",
        number=320,
        firmware=firmware,
        table=ControlTable(rows),
        baud_rates=MX_BAUD_RATES,
        drive_mode_bits=0b01,
        current_unit=4.5e-3,
        motor=MotorData(
            nominal_voltage=12.0,
            stall_torque=8.4,
            stall_current=5.2,
            no_load_speed=45.0,
            inertia=0.018,
            mass=0.165,
        ),
        protocol=1,
        protocols=frozenset((1,)),
        units=MX_UNITS,
        family="classic",
        operating_modes=frozenset(),
        first_firmware=first,
        last_firmware=last,
    )


MODELS = (
    _model(
        41,
        _REALTIME_TICK_FROM,
        None,
        [*_rows(), row(50, 2, "Realtime Tick", "R", 0, (0, 32_767), "ms")],
    ),
    _model(39, 0, _REALTIME_TICK_FROM - 1, _rows()),
)
