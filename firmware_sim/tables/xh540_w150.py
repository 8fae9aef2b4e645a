"""XH540-W150: its control table and motor.

Rows, access, initial values and ranges: e-Manual, docs/en/dxl/x/xh540-w150 (repository at 028a13d),
"Control Table of EEPROM Area" and "Control Table of RAM Area"; addresses, sizes and names also in
the SDK's ``xh540_w150.model``. Motor: the same page, "Specifications", at 12.0 V.

The range of Drive Mode is that of its section, "Drive Mode(10)", with bit 3 of firmware 45; the
page's table stops at 5.

Drive Mode's bit 1 (slave of a dual joint) is in its range and refused: it is not modelled. Nothing
is attached to the external ports: an input reads what pulls it up or down, an output what it is set
to.
"""

from __future__ import annotations

from firmware_sim.firmware.control_table import ControlTable, indirect_rows, row
from firmware_sim.firmware.model import X_BAUD_RATES, MotorData, ServoModel
from firmware_sim.tables.versions import x430_versions

_TABLE = ControlTable(
    [
        row(0, 2, "Model Number", "R", 1110),
        row(2, 4, "Model Information", "R", 0),
        row(6, 1, "Firmware Version", "R", 45),
        row(7, 1, "ID", "RW", 1, (0, 252)),
        row(8, 1, "Baud Rate", "RW", 1, (0, 7)),
        row(9, 1, "Return Delay Time", "RW", 250, (0, 254), "2 us"),
        row(10, 1, "Drive Mode", "RW", 0, (0, 15)),
        row(11, 1, "Operating Mode", "RW", 3, (0, 16)),
        row(12, 1, "Secondary(Shadow) ID", "RW", 255, (0, 255)),
        row(13, 1, "Protocol Type", "RW", 2, (1, 2)),
        row(20, 4, "Homing Offset", "RW", 0, (-1_044_479, 1_044_479), "tick"),
        row(24, 4, "Moving Threshold", "RW", 10, (0, 1023), "0.229 rev/min"),
        row(31, 1, "Temperature Limit", "RW", 80, (0, 100), "deg C"),
        row(32, 2, "Max Voltage Limit", "RW", 160, (95, 160), "0.1 V"),
        row(34, 2, "Min Voltage Limit", "RW", 95, (95, 160), "0.1 V"),
        row(36, 2, "PWM Limit", "RW", 885, (0, 885), "0.113 %"),
        row(38, 2, "Current Limit", "RW", 2047, (0, 2047), "2.69 mA"),
        row(44, 4, "Velocity Limit", "RW", 300, (0, 1023), "0.229 rev/min"),
        row(48, 4, "Max Position Limit", "RW", 4095, (0, 4095), "tick"),
        row(52, 4, "Min Position Limit", "RW", 0, (0, 4095), "tick"),
        row(56, 1, "External Port Mode 1", "RW", 3, (0, 3)),
        row(57, 1, "External Port Mode 2", "RW", 3, (0, 3)),
        row(58, 1, "External Port Mode 3", "RW", 3, (0, 3)),
        row(60, 1, "Startup Configuration", "RW", 0, (0, 3)),
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
        row(84, 2, "Position P Gain", "RW", 800, (0, 16_383)),
        row(88, 2, "Feedforward 2nd Gain", "RW", 0, (0, 16_383)),
        row(90, 2, "Feedforward 1st Gain", "RW", 0, (0, 16_383)),
        row(98, 1, "Bus Watchdog", "RW", 0, (0, 127), "20 ms"),
        row(100, 2, "Goal PWM", "RW", 885, (-885, 885), "0.113 %"),
        row(102, 2, "Goal Current", "RW", 2047, (-2047, 2047), "2.69 mA"),
        row(104, 4, "Goal Velocity", "RW", 300, (-1023, 1023), "0.229 rev/min"),
        row(108, 4, "Profile Acceleration", "RW", 0, (0, 32_767), "214.577 rev/min^2 or ms"),
        row(112, 4, "Profile Velocity", "RW", 0, (0, 32_767), "0.229 rev/min or ms"),
        row(116, 4, "Goal Position", "RW", 0, (-1_048_575, 1_048_575), "tick"),
        row(120, 2, "Realtime Tick", "R", 0, (0, 32_767), "ms"),
        row(122, 1, "Moving", "R", 0, (0, 1)),
        row(123, 1, "Moving Status", "R", 0),
        row(124, 2, "Present PWM", "R", 0, (-885, 885), "0.113 %"),
        row(126, 2, "Present Current", "R", 0, (-32_768, 32_767), "2.69 mA"),
        row(128, 4, "Present Velocity", "R", 0, (-(2**31), 2**31 - 1), "0.229 rev/min"),
        row(132, 4, "Present Position", "R", 0, (-(2**31), 2**31 - 1), "tick"),
        row(136, 4, "Velocity Trajectory", "R", 0, (-(2**31), 2**31 - 1), "0.229 rev/min"),
        row(140, 4, "Position Trajectory", "R", 0, (-(2**31), 2**31 - 1), "tick"),
        row(144, 2, "Present Input Voltage", "R", 0, unit="0.1 V"),
        row(146, 1, "Present Temperature", "R", 0, unit="deg C"),
        row(147, 1, "Backup Ready", "R", 0, (0, 1)),
        row(152, 2, "External Port Data 1", "RW", 0),
        row(154, 2, "External Port Data 2", "RW", 0),
        row(156, 2, "External Port Data 3", "RW", 0),
        *indirect_rows(1, 28, 168, 224, 661),
        *indirect_rows(29, 28, 578, 634, 661),
    ]
)

MODELS = x430_versions(
    ServoModel(
        name="xh540-w150",
        number=1110,
        firmware=45,
        table=_TABLE,
        baud_rates=X_BAUD_RATES,
        drive_mode_bits=0b1101,
        current_unit=2.69e-3,
        motor=MotorData(
            nominal_voltage=12.0,
            stall_torque=7.1,
            stall_current=4.9,
            no_load_speed=70.0,
            inertia=0.0097,
            mass=0.165,
        ),
        protocols=frozenset((1, 2)),
        first_firmware=45,
        backup_from=45,
        fast_from=45,
    ),
)
