"""XL-320: its control table and motor.

Rows, access, initial values and ranges: e-Manual, docs/en/dxl/x/xl320, "Control Table of EEPROM
Area" and "Control Table of RAM Area"; addresses, sizes and names also in the SDK's
``xl320.model``. Motor: the same page, "Specifications". The firmware's number is not in the manual.
"""

from __future__ import annotations

from firmware_sim.classic.rows import STEP_UNITS
from firmware_sim.classic.rows import classic_row as row
from firmware_sim.firmware.control_table import ControlTable
from firmware_sim.firmware.model import X_BAUD_RATES, MotorData, ServoModel

_TABLE = ControlTable(
    [
        row(0, 2, "Model Number", "R", 350),
        row(2, 1, "Firmware Version", "R", 30),
        row(3, 1, "ID", "RW", 1, (0, 252)),
        row(4, 1, "Baud Rate", "RW", 3, (0, 3)),
        row(5, 1, "Return Delay Time", "RW", 250, (0, 254), "2 us"),
        row(6, 2, "CW Angle Limit", "RW", 0, (0, 1023), "0.29 deg"),
        row(8, 2, "CCW Angle Limit", "RW", 1023, (0, 1023), "0.29 deg"),
        row(11, 1, "Control Mode", "RW", 2, (1, 2)),
        row(12, 1, "Temperature Limit", "RW", 65, (0, 150), "deg C"),
        row(13, 1, "Min Voltage Limit", "RW", 60, (50, 250), "0.1 V"),
        row(14, 1, "Max Voltage Limit", "RW", 90, (50, 250), "0.1 V"),
        row(15, 2, "Max Torque", "RW", 1023, (0, 1023), "0.1 %"),
        row(17, 1, "Status Return Level", "RW", 2, (0, 2)),
        row(18, 1, "Shutdown", "RW", 3, (0, 7)),
        row(24, 1, "Torque Enable", "RW", 0, (0, 1)),
        row(25, 1, "LED", "RW", 0, (0, 7)),
        row(27, 1, "D Gain", "RW", 0, (0, 254)),
        row(28, 1, "I Gain", "RW", 0, (0, 254)),
        row(29, 1, "P Gain", "RW", 32, (0, 254)),
        row(30, 2, "Goal Position", "RW", 0, (0, 1023), "0.29 deg"),
        row(32, 2, "Moving Speed", "RW", 0, (0, 2047), "0.111 rev/min or 0.1 %"),
        row(35, 2, "Torque Limit", "RW", 1023, (0, 1023), "0.1 %"),
        row(37, 2, "Present Position", "R", 0, (0, 1023), "0.29 deg"),
        row(39, 2, "Present Speed", "R", 0, (0, 2047), "0.111 rev/min or 0.1 %"),
        row(41, 2, "Present Load", "R", 0, (0, 2047), "0.1 %"),
        row(45, 1, "Present Voltage", "R", 0, unit="0.1 V"),
        row(46, 1, "Present Temperature", "R", 0, unit="deg C"),
        row(47, 1, "Registered Instruction", "R", 0, (0, 1)),
        row(49, 1, "Moving", "R", 0, (0, 1)),
        row(50, 1, "Hardware Error Status", "R", 0),
        row(51, 2, "Punch", "RW", 32, (0, 1023), "0.1 %"),
    ]
)

MODELS = (
    ServoModel(
        name="xl-320",
        number=350,
        firmware=30,
        table=_TABLE,
        baud_rates={code: rate for code, rate in X_BAUD_RATES.items() if code < 4},
        drive_mode_bits=0,
        current_unit=None,
        motor=MotorData(
            nominal_voltage=7.4,
            stall_torque=0.39,
            stall_current=1.1,
            no_load_speed=114.0,
            inertia=0.00033,
            mass=0.0167,
        ),
        units=STEP_UNITS,
        family="xl320",
        operating_modes=frozenset(),
    ),
)
