"""XC330-T181: its control table and motor.

Rows, access, initial values and ranges: e-Manual, docs/en/dxl/x/xc330-t181 (repository at 207d2e0),
"Control Table of EEPROM Area" and "Control Table of RAM Area"; addresses, sizes and names also in
the SDK's ``xc330_t181.model``. Motor: the same page, "Specifications", at 11.1 V.

The page's table is that of firmware 52 and below, with 20 indirect addresses and data from 208;
newer firmware has 28 and data from 224 (``xc330_t181.model`` of the SDK against its
``xc330_t181_fw52.model``).

Protocol Type also names three protocols of remote controls (20 to 22).
"""

from __future__ import annotations

from firmware_sim.firmware.control_table import ControlTable, indirect_rows, row
from firmware_sim.firmware.model import X_BAUD_RATES, MotorData, ServoModel
from firmware_sim.tables.versions import x330_versions

_ROWS = [
    row(0, 2, "Model Number", "R", 1210),
    row(2, 4, "Model Information", "R", 0),
    row(6, 1, "Firmware Version", "R", 53),
    row(7, 1, "ID", "RW", 1, (0, 252)),
    row(8, 1, "Baud Rate", "RW", 1, (0, 6)),
    row(9, 1, "Return Delay Time", "RW", 250, (0, 254), "2 us"),
    row(10, 1, "Drive Mode", "RW", 0, (0, 13)),
    row(11, 1, "Operating Mode", "RW", 3, (0, 16)),
    row(12, 1, "Secondary(Shadow) ID", "RW", 255, (0, 255)),
    row(13, 1, "Protocol Type", "RW", 2, (2, 22)),
    row(20, 4, "Homing Offset", "RW", 0, (-1_044_479, 1_044_479), "tick"),
    row(24, 4, "Moving Threshold", "RW", 10, (0, 1023), "0.229 rev/min"),
    row(31, 1, "Temperature Limit", "RW", 70, (0, 100), "deg C"),
    row(32, 2, "Max Voltage Limit", "RW", 140, (55, 140), "0.1 V"),
    row(34, 2, "Min Voltage Limit", "RW", 55, (55, 140), "0.1 V"),
    row(36, 2, "PWM Limit", "RW", 885, (0, 885), "0.113 %"),
    row(38, 2, "Current Limit", "RW", 910, (0, 910), "1 mA"),
    row(44, 4, "Velocity Limit", "RW", 510, (0, 2047), "0.229 rev/min"),
    row(48, 4, "Max Position Limit", "RW", 4095, (0, 4095), "tick"),
    row(52, 4, "Min Position Limit", "RW", 0, (0, 4095), "tick"),
    row(60, 1, "Startup Configuration", "RW", 0, (0, 3)),
    row(62, 1, "PWM Slope", "RW", 255, (1, 255), "3.955 mV/ms"),
    row(63, 1, "Shutdown", "RW", 52),
    row(64, 1, "Torque Enable", "RW", 0, (0, 1)),
    row(65, 1, "LED", "RW", 0, (0, 1)),
    row(68, 1, "Status Return Level", "RW", 2, (0, 2)),
    row(69, 1, "Registered Instruction", "R", 0, (0, 1)),
    row(70, 1, "Hardware Error Status", "R", 0),
    row(76, 2, "Velocity I Gain", "RW", 1200, (0, 16_383)),
    row(78, 2, "Velocity P Gain", "RW", 40, (0, 16_383)),
    row(80, 2, "Position D Gain", "RW", 0, (0, 16_383)),
    row(82, 2, "Position I Gain", "RW", 0, (0, 16_383)),
    row(84, 2, "Position P Gain", "RW", 900, (0, 16_383)),
    row(88, 2, "Feedforward 2nd Gain", "RW", 0, (0, 16_383)),
    row(90, 2, "Feedforward 1st Gain", "RW", 0, (0, 16_383)),
    row(98, 1, "Bus Watchdog", "RW", 0, (0, 127), "20 ms"),
    row(100, 2, "Goal PWM", "RW", 885, (-885, 885), "0.113 %"),
    row(102, 2, "Goal Current", "RW", 910, (-910, 910), "1 mA"),
    row(104, 4, "Goal Velocity", "RW", 510, (-2047, 2047), "0.229 rev/min"),
    row(108, 4, "Profile Acceleration", "RW", 0, (0, 32_767), "214.577 rev/min^2 or ms"),
    row(112, 4, "Profile Velocity", "RW", 0, (0, 32_767), "0.229 rev/min or ms"),
    row(116, 4, "Goal Position", "RW", 0, (-1_048_575, 1_048_575), "tick"),
    row(120, 2, "Realtime Tick", "R", 0, (0, 32_767), "ms"),
    row(122, 1, "Moving", "R", 0, (0, 1)),
    row(123, 1, "Moving Status", "R", 0),
    row(124, 2, "Present PWM", "R", 0, (-885, 885), "0.113 %"),
    row(126, 2, "Present Current", "R", 0, (-32_768, 32_767), "1 mA"),
    row(128, 4, "Present Velocity", "R", 0, (-(2**31), 2**31 - 1), "0.229 rev/min"),
    row(132, 4, "Present Position", "R", 0, (-(2**31), 2**31 - 1), "tick"),
    row(136, 4, "Velocity Trajectory", "R", 0, (-(2**31), 2**31 - 1), "0.229 rev/min"),
    row(140, 4, "Position Trajectory", "R", 0, (-(2**31), 2**31 - 1), "tick"),
    row(144, 2, "Present Input Voltage", "R", 0, unit="0.1 V"),
    row(146, 1, "Present Temperature", "R", 0, unit="deg C"),
    row(147, 1, "Backup Ready", "R", 0, (0, 1)),
]

_TABLE = ControlTable([*_ROWS, *indirect_rows(1, 28, 168, 224, 251)])
_TABLE_TO_52 = ControlTable([*_ROWS, *indirect_rows(1, 20, 168, 208, 227)])

MODELS = x330_versions(
    ServoModel(
        name="xc330-t181",
        number=1210,
        firmware=53,
        table=_TABLE,
        baud_rates={code: rate for code, rate in X_BAUD_RATES.items() if code < 7},
        drive_mode_bits=0b1101,
        current_unit=1.0e-3,
        motor=MotorData(
            nominal_voltage=11.1,
            stall_torque=0.76,
            stall_current=0.8,
            no_load_speed=104.0,
            inertia=0.0007,
            mass=0.023,
        ),
        first_firmware=53,
        backup_from=46,
        fast_from=46,
        pwm_slope_unit=3.955e-3,
    ),
    _TABLE_TO_52,
)
