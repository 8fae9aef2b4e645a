"""What a control socket says of faults, of what struck, and of the servos."""

from __future__ import annotations

from typing import Any

from firmware_sim.faults.fault import Fault
from firmware_sim.faults.roster import TICK, Strike
from firmware_sim.firmware.servo import Servo
from firmware_sim.simulation import Simulation

REGISTERS = (
    "Operating Mode",
    "Control Mode",
    "Torque Enable",
    "Hardware Error Status",
    "Goal Position",
    "Moving",
    "Present Current",
    "Present Load",
    "Present Velocity",
    "Present Speed",
    "Present Position",
    "Present Input Voltage",
    "Present Voltage",
    "Present Temperature",
    "Bus Watchdog",
)
"""What is said of a servo, as far as it has such registers; raw numbers with their sign."""


def describe_fault(fault: Fault, simulation: Simulation) -> dict[str, Any]:
    """Return a fault in force: its number, text, beginning (s since the start) and strikes."""
    return {
        "number": fault.number,
        "fault": fault.spec.text,
        "begin": round(fault.begin - simulation.start, 6),
        "strikes": fault.strikes,
    }


def describe_strike(strike: Strike) -> dict[str, Any]:
    """Return what a strike was."""
    return {
        "tick": strike.tick,
        "time": round(strike.time, 6),
        "fault": strike.name,
        "number": strike.number,
        "id": strike.servo_id,
        "detail": strike.detail,
    }


def describe_servo(servo: Servo) -> dict[str, Any]:
    """Return who a servo is and what its registers hold."""
    table = servo.model.table.by_name
    registers = [table[name] for name in REGISTERS if name in table]
    for register in registers:
        servo.read(register.address, register.size)  # brings present values up to date
    return {
        "id": servo.servo_id,
        "model": servo.model.name,
        "protocol": servo.protocol,
        "baud": servo.baud_rate,
        "hears": servo.hears,
        "error_bits": servo.error_bits,
        "registers": {row.name: servo.memory.value(row.name) for row in registers},
    }


def describe_simulation(simulation: Simulation) -> dict[str, Any]:
    """Return the time, the port, the faults and the servos."""
    time = simulation.now - simulation.start
    return {
        "time": round(time, 6),
        "tick": int(time / TICK + 1.0e-6),
        "unplugged": simulation.unplugged,
        "forbidden": simulation.forbidden,
        "faults": [describe_fault(fault, simulation) for fault in simulation.faults],
        "strikes": dict(simulation.strikes),
        "servos": [describe_servo(servo) for servo in simulation.bus.servos],
    }
