"""MX-64 with protocol 2.0: its control table and motor.

Rows, access and initial values: e-Manual, docs/en/dxl/mx/mx-64-2 (repository at 203f49b), "Control
Table of EEPROM Area" and "Control Table of RAM Area"; ranges: "Control Table Description", there.
Addresses, sizes and names also in the SDK's ``mx_64.model``. Motor: the same page,
"Specifications", at 12.0 V.

The firmware for protocol 2.0 has its own model number and table; the one for protocol 1.0 is
``mx_64.py``. Both page and SDK write "BUS Watchdog", all other models "Bus Watchdog": the latter
here too. That state of the page has neither Startup Configuration nor Backup Ready, as the SDK.
"""

from __future__ import annotations

from firmware_sim.firmware.control_table import ControlTable, indirect_rows, row
from firmware_sim.firmware.model import X_BAUD_RATES, MotorData, ServoModel
from firmware_sim.tables.versions import mx_versions

_TABLE = ControlTable(
    [
        row(0, 2, "Model Number", "R", 311),
        row(2, 4, "Model Information", "R", 0),
        row(6, 1, "Firmware Version", "R", 42),
        row(7, 1, "ID", "RW", 1, (0, 252)),
        row(8, 1, "Baud Rate", "RW", 1, (0, 7)),
        row(9, 1, "Return Delay Time", "RW", 250, (0, 254), "2 us"),
        row(10, 1, "Drive Mode", "RW", 0, (0, 5)),
        row(11, 1, "Operating Mode", "RW", 3, (0, 16)),
        row(12, 1, "Secondary(Shadow) ID", "RW", 255, (0, 255)),
        row(13, 1, "Protocol Type", "RW", 2, (1, 2)),
        row(20, 4, "Homing Offset", "RW", 0, (-1_044_479, 1_044_479), "tick"),
        row(24, 4, "Moving Threshold", "RW", 10, (0, 1023), "0.229 rev/min"),
        row(31, 1, "Temperature Limit", "RW", 80, (0, 100), "deg C"),
        row(32, 2, "Max Voltage Limit", "RW", 160, (95, 160), "0.1 V"),
        row(34, 2, "Min Voltage Limit", "RW", 95, (95, 160), "0.1 V"),
        row(36, 2, "PWM Limit", "RW", 885, (0, 885), "0.113 %"),
        row(38, 2, "Current Limit", "RW", 1941, (0, 1941), "3.36 mA"),
        row(40, 4, "Acceleration Limit", "RW", 32_767, (0, 32_767), "214.577 rev/min^2"),
        row(44, 4, "Velocity Limit", "RW", 285, (0, 1023), "0.229 rev/min"),
        row(48, 4, "Max Position Limit", "RW", 4095, (0, 4095), "tick"),
        row(52, 4, "Min Position Limit", "RW", 0, (0, 4095), "tick"),
        row(63, 1, "Shutdown", "RW", 52),
        row(64, 1, "Torque Enable", "RW", 0, (0, 1)),
        row(65, 1, "LED", "RW", 0, (0, 1)),
        row(68, 1, "Status Return Level", "RW", 2, (0, 2)),
        row(69, 1, "Registered Instruction", "R", 0, (0, 1)),
        row(70, 1, "Hardware Error Status", "R", 0),
        row(76, 2, "Velocity I Gain", "RW", 1920, (0, 16_383)),
        row(78, 2, "Velocity P Gain", "RW", 100, (0, 16_383)),
        row(80, 2, "Position D Gain", "RW", 0, (0, 16_383)),
        row(82, 2, "Position I Gain", "RW", 0, (0, 16_383)),
        row(84, 2, "Position P Gain", "RW", 850, (0, 16_383)),
        row(88, 2, "Feedforward 2nd Gain", "RW", 0, (0, 16_383)),
        row(90, 2, "Feedforward 1st Gain", "RW", 0, (0, 16_383)),
        row(98, 1, "Bus Watchdog", "RW", 0, (0, 127), "20 ms"),
        row(100, 2, "Goal PWM", "RW", 885, (-885, 885), "0.113 %"),
        row(102, 2, "Goal Current", "RW", 1941, (-1941, 1941), "3.36 mA"),
        row(104, 4, "Goal Velocity", "RW", 285, (-1023, 1023), "0.229 rev/min"),
        row(108, 4, "Profile Acceleration", "RW", 0, (0, 32_767), "214.577 rev/min^2 or ms"),
        row(112, 4, "Profile Velocity", "RW", 0, (0, 32_767), "0.229 rev/min or ms"),
        row(116, 4, "Goal Position", "RW", 0, (-1_048_575, 1_048_575), "tick"),
        row(120, 2, "Realtime Tick", "R", 0, (0, 32_767), "ms"),
        row(122, 1, "Moving", "R", 0, (0, 1)),
        row(123, 1, "Moving Status", "R", 0),
        row(124, 2, "Present PWM", "R", 0, (-885, 885), "0.113 %"),
        row(126, 2, "Present Current", "R", 0, (-32_768, 32_767), "3.36 mA"),
        row(128, 4, "Present Velocity", "R", 0, (-(2**31), 2**31 - 1), "0.229 rev/min"),
        row(132, 4, "Present Position", "R", 0, (-(2**31), 2**31 - 1), "tick"),
        row(136, 4, "Velocity Trajectory", "R", 0, (-(2**31), 2**31 - 1), "0.229 rev/min"),
        row(140, 4, "Position Trajectory", "R", 0, (-(2**31), 2**31 - 1), "tick"),
        row(144, 2, "Present Input Voltage", "R", 0, unit="0.1 V"),
        row(146, 1, "Present Temperature", "R", 0, unit="deg C"),
        *indirect_rows(1, 28, 168, 224, 661),
        *indirect_rows(29, 28, 578, 634, 661),
    ]
)

MODELS = mx_versions(
    ServoModel(
        name="mx-64",
        number=311,
        firmware=42,
        table=_TABLE,
        baud_rates=X_BAUD_RATES,
        drive_mode_bits=0b0101,
        current_unit=3.36e-3,
        motor=MotorData(
            nominal_voltage=12.0,
            stall_torque=6.0,
            stall_current=4.1,
            no_load_speed=63.0,
            inertia=0.0091,
            mass=0.165,
        ),
        protocols=frozenset((1, 2)),
        first_firmware=42,
    ),
)
