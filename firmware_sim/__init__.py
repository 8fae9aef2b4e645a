"""Simulated Dynamixel servos behind a virtual serial port, speaking both protocols byte for byte.

``firmware-sim --servo xm430-w350:1 ax-12a:2`` prints the port and runs until it is stopped; any
program that talks to Dynamixel servos may open it. `firmware_sim.testing` starts one for a test,
or puts servos on a stepped clock; `firmware_sim.pytest_plugin` has both as fixtures.

What is simulated:

- Protocol 2.0 with ping, read, write, reg write, action, factory reset, reboot, clear, control
  table backup, sync, bulk, fast sync and fast bulk; Protocol 1.0 with ping, read, write, reg
  write, action, factory reset, reboot (MX), sync write and bulk read (MX). Servos of both on one
  wire, with the time that bytes take on it, return delays, and the 1.5 ms gap rule.
- The models that --list-models names, each with its control table and firmware's layout: X
  series, MX in both protocols, AX, XL-320. Access, ranges, EEPROM lock, status return level, error
  numbers and alert, indirect addresses, secondary ID, startup configuration, bus watchdog.
- Operating modes, profiles by velocity and by time, gains with feed-forward, homing offset,
  reverse mode, limits; compliance and torque limit of AX and MX; shutdown by overload, heat and
  supply.
- Motors with gears, friction, heat and supply; by themselves, or as an arm under gravity (--plant
  mujoco). Servos of one voltage share a supply. Two servos on one joint (shadow_of in a rig file,
  or one joint's name) turn as one, share its load or fight each other.
- Faults, injected from the command line, by a scenario or at run time: see --list-faults. Among
  them a person's hand that turns a joint, and obstacles that stop it.

What is not modelled:

- Models that --list-models does not name. Slaves of a dual joint (drive mode bit 1) and protocols
  of remote controls (Protocol Type 20 to 22): refused with a data range error.
- That the two axles of a 2XL430 or 2XC430 are one case. Each is a servo by itself here; in a real
  one they share Baud Rate and Protocol Type, and torque on either locks the EEPROM of both.
- Figures that no data sheet has are chosen: friction, inertia of rotors, thermal resistance, the
  times after which overload is noticed, how long a reboot takes. Each stands where it is defined.
- Backlash is none unless a rig file says so, and none between servos on one joint. With --plant
  joints a horn carries nothing but its own inertia and what faults put on it; with mujoco bodies
  do not collide. Obstacles are hard, and give nothing back; hands hold the joint, not the link.
- Sensor noise, cogging, magnetic saturation, wear; what an external port's pins are wired to.
- Two masters at once on one port. What a client sends while an answer is due waits for the
  answer's end, where a real wire has a collision; servos that talk at once do collide.
- A client whose baud rate no servo has is answered with garbage, where a real line would often be
  silent. Parity and stop bits are ignored; a pseudo-terminal has no modem lines, so that asking
  for them fails (OSError). Answers within 0.4 ms may arrive together, as behind an adapter.
- How long an EEPROM write takes (but for AX), and how many a servo lives through.
"""

from __future__ import annotations

__all__: list[str] = []
