"""AX-12A: its control table and motor.

Rows, access and initial values: e-Manual, docs/en/dxl/ax/ax-12a, "Control Table of EEPROM Area" and
"Control Table of RAM Area"; addresses and sizes also in rustypot's register list. Ranges: the same
page, "Control Table Description". Motor: the same page, "Specifications".

44 is "Registered" in the page's table and "Registered Instruction" in its text. The
ranges of the voltage limits and the compliance margins are those of docs/kr/dxl/ax/ax-12w, whose
text (in English) has them. The firmware's number is not in the manual.
"""

from __future__ import annotations

from firmware_sim.classic.rows import AX_BAUD_RATES, STEP_UNITS
from firmware_sim.classic.rows import classic_row as row
from firmware_sim.firmware.control_table import ControlTable
from firmware_sim.firmware.model import MotorData, ServoModel

_TABLE = ControlTable(
    [
        row(0, 2, "Model Number", "R", 12),
        row(2, 1, "Firmware Version", "R", 24),
        row(3, 1, "ID", "RW", 1, (0, 253)),
        row(4, 1, "Baud Rate", "RW", 1, (1, 254)),
        row(5, 1, "Return Delay Time", "RW", 250, (0, 254), "2 us"),
        row(6, 2, "CW Angle Limit", "RW", 0, (0, 1023), "0.29 deg"),
        row(8, 2, "CCW Angle Limit", "RW", 1023, (0, 1023), "0.29 deg"),
        row(11, 1, "Temperature Limit", "RW", 70, (0, 100), "deg C"),
        row(12, 1, "Min Voltage Limit", "RW", 60, (50, 250), "0.1 V"),
        row(13, 1, "Max Voltage Limit", "RW", 140, (50, 250), "0.1 V"),
        row(14, 2, "Max Torque", "RW", 1023, (0, 1023), "0.1 %"),
        row(16, 1, "Status Return Level", "RW", 2, (0, 2)),
        row(17, 1, "Alarm LED", "RW", 36, (0, 127)),
        row(18, 1, "Shutdown", "RW", 36, (0, 127)),
        row(24, 1, "Torque Enable", "RW", 0, (0, 1)),
        row(25, 1, "LED", "RW", 0, (0, 1)),
        row(26, 1, "CW Compliance Margin", "RW", 1, (0, 255), "0.29 deg"),
        row(27, 1, "CCW Compliance Margin", "RW", 1, (0, 255), "0.29 deg"),
        row(28, 1, "CW Compliance Slope", "RW", 32, (0, 254), "0.29 deg"),
        row(29, 1, "CCW Compliance Slope", "RW", 32, (0, 254), "0.29 deg"),
        row(30, 2, "Goal Position", "RW", 0, (0, 1023), "0.29 deg"),
        row(32, 2, "Moving Speed", "RW", 0, (0, 2047), "0.111 rev/min or 0.1 %"),
        row(34, 2, "Torque Limit", "RW", 1023, (0, 1023), "0.1 %"),
        row(36, 2, "Present Position", "R", 0, (0, 1023), "0.29 deg"),
        row(38, 2, "Present Speed", "R", 0, (0, 2047), "0.111 rev/min or 0.1 %"),
        row(40, 2, "Present Load", "R", 0, (0, 2047), "0.1 %"),
        row(42, 1, "Present Voltage", "R", 0, unit="0.1 V"),
        row(43, 1, "Present Temperature", "R", 0, unit="deg C"),
        row(44, 1, "Registered Instruction", "R", 0, (0, 1)),
        row(46, 1, "Moving", "R", 0, (0, 1)),
        row(47, 1, "Lock", "RW", 0, (0, 1)),
        row(48, 2, "Punch", "RW", 32, (32, 1023), "0.1 %"),
    ]
)

MODELS = (
    ServoModel(
        name="ax-12a",
        number=12,
        firmware=24,
        table=_TABLE,
        baud_rates=AX_BAUD_RATES,
        drive_mode_bits=0,
        current_unit=None,
        motor=MotorData(
            nominal_voltage=12.0,
            stall_torque=1.5,
            stall_current=1.5,
            no_load_speed=59.0,
            inertia=0.0024,
            mass=0.0546,
        ),
        protocol=1,
        protocols=frozenset((1,)),
        units=STEP_UNITS,
        family="classic",
        operating_modes=frozenset(),
    ),
)
