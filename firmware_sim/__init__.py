"""Simulated Dynamixel servos behind a virtual serial port, speaking Protocol 2.0 byte for byte.

``python -m firmware_sim --servo xm430-w350:1`` prints the port and runs until it is stopped; any
program that talks to Dynamixel servos may open it. `firmware_sim.testing` starts one for a test,
and has a bus on a stepped clock for tests without real time.

What is simulated: the models in `firmware_sim.tables` with their control tables, and of Protocol
2.0 ping, read, write, reg write, action, factory reset, reboot, sync read, sync write; error
numbers, alert bit, status return level, return delay; EEPROM lock, limits, homing offset, reverse
mode, operating modes 3 (position) and 4 (extended position), velocity- and time-based profiles,
PID gains, bus watchdog, hardware errors and shutdown; a first-order motor with back-EMF, current
or load, and temperature; the time that bytes take on the wire.

What is not modelled:

- Protocol 1.0; the instructions clear, control table backup, bulk read and write, fast reads
  (answered with an instruction error).
- Operating modes 0, 1, 5 and 16, the slave of a dual joint (drive mode bit 1), startup
  configuration, secondary ID, other protocol types: refused with a data range error.
- Indirect addresses: their registers are plain memory. LED, external ports, PWM slope, feed-forward
  gains, velocity gains and Goal Current are kept, and do nothing.
- Gravity, inertia that changes with the posture, collisions, static friction, backlash, sensor
  noise, a supply that sags; overload is never detected by itself.
- Collisions on the wire: what is sent while an answer is due waits for its end. Two servos with
  one ID answer one after the other.
- A client whose baud rate no servo has is answered with garbage, where a real line would often be
  silent. Parity, stop bits and modem lines are ignored.
- How long an EEPROM write takes, and how many a servo lives through.
"""

from __future__ import annotations

__all__: list[str] = []
