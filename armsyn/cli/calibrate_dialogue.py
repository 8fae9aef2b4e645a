"""What `armsyn calibrate` asks of the person who moves the arm."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from armsyn.cli.prompts import Person
    from armsyn.driver.calibrating import ArmCalibrator


class Dialogue:
    """Asks step by step; a step that did not work is asked for again, until Ctrl-C.

    Parameters
    ----------
    calibrator : ArmCalibrator
    person : Person
    options : dict
        Of the command.
    """

    def __init__(self, calibrator: ArmCalibrator, person: Person, options: dict[str, Any]) -> None:
        self.calibrator = calibrator
        self._person = person
        self._options = options

    def rest(self) -> None:
        """Have the arm put to rest."""
        self._person.say(f"Rest posture of {self.calibrator.arm.name}, from base to tip:")
        from armsyn.driver.calibrating import rest_angles

        for joint, angle in rest_angles(self.calibrator.arm).items():
            self._person.say(f"  {joint}: {math.degrees(angle):z.1f} degrees from zero")
        self._person.watch("Put the arm into its rest posture and hold it there", self._all)
        while not self.calibrator.mark_rest():
            self._person.watch("It was moving: hold it still in its rest posture", self._all)

    def align(self) -> None:
        """Offer to align dual joints."""
        from armsyn.arm.calibration_file import folder_for_writing
        from armsyn.driver.calibrating_pairs import align, misalignments
        from armsyn.driver.eeprom_file import BackupFile, Reach
        from armsyn.errors import ServoMismatchError

        calibrator = self.calibrator
        found = misalignments(calibrator)
        if not found:
            return
        for pair in found:
            self._person.say(
                f"{pair.title} reads {abs(pair.apart)} ticks off servo {pair.shadow.shadow_of} in"
                f" the same posture: Homing Offset (register 20) {pair.change.found} ->"
                f" {pair.change.wanted}"
            )
        if not self._options["yes"] and not self._person.confirm("Write this?"):
            raise ServoMismatchError(
                f"{found[0].title} and servo {found[0].shadow.shadow_of} would fight each other:"
                " nothing was written, and the arm cannot be used like this"
            )
        folder = folder_for_writing(calibrator.arm.name, self._options["calibration"])
        backup = BackupFile(folder, calibrator.arm.name, self._options["port"])
        for pair in found:
            place = pair.image.found
            backup.add(pair.image, Reach(place.servo_id, 2, place.baud))
        self._person.say(f"backup: {backup.path}")
        for pair in found:
            align(calibrator, pair)
            self._person.say(f"{pair.title}: aligned, written and read back")
        calibrator.follow_anew()
        self._person.watch("Hold the arm in its rest posture once more", self._all)
        while not calibrator.mark_rest():
            self._person.watch("It was moving: hold it still in its rest posture", self._all)

    def joint(self, joint: str) -> None:
        """Have one joint moved: its positive direction, then its ends."""
        from armsyn.driver.calibrating import LEAST_MOVE
        from armsyn.driver.calibrating_words import positive_direction

        calibrator = self.calibrator
        way = positive_direction(calibrator.arm, joint)
        ask = f"{joint}: move it by 20 degrees or more so that {way}"
        while True:
            began = dict(calibrator.follower.look())
            self._person.watch(ask, lambda: self._one(joint))
            calibrator.follower.look()
            if calibrator.mark_direction(joint, began):
                break
            ask = f"{joint} has hardly moved; move it by 20 degrees or more so that {way}"
        self._warn_of_direction(joint)
        gripper = calibrator.arm.gripper
        ends = "one end and to the other"
        if gripper is not None and joint == gripper.name:
            ends = "where it is closed and to where it is wide open: armsyn grip keeps to that"
        ask = f"{joint}: move it to {ends}"
        calibrator.follower.forget_range()
        while True:
            self._person.watch(ask, lambda: self._one(joint))
            calibrator.follower.look()
            if calibrator.mark_range(joint) >= LEAST_MOVE:
                return
            ask = f"{joint} has hardly moved; move it to {ends}"

    def _warn_of_direction(self, joint: str) -> None:
        leader = self.calibrator.servos_of(joint)[0]
        if self.calibrator.direction(leader.id) != leader.direction:
            self._person.say(
                f"  {joint} counts the other way than described: if you moved it as asked, go on;"
                " if not, press Ctrl-C and begin again"
            )

    def rest_again(self) -> None:
        """Have the arm put to rest once more: it must read as before."""
        from armsyn.driver.calibrating import REST_AGAIN

        ask = "Put the arm back into its rest posture and hold it there"
        while True:
            self._person.watch(ask, self._all)
            away = self.calibrator.away_from_rest()
            if away is None:
                ask = "It was moving: hold it still in its rest posture"
                continue
            off = {joint: angle for joint, angle in away.items() if abs(angle) > REST_AGAIN}
            if not off:
                return
            named = ", ".join(f"{j} by {math.degrees(a):+z.0f} degrees" for j, a in off.items())
            ask = f"It is not where it was at the beginning ({named}): put it there"

    def _all(self) -> str:
        ticks = self.calibrator.follower.look()
        return "  ".join(f"{servo_id}: {tick}" for servo_id, tick in ticks.items())

    def _one(self, joint: str) -> str:
        from armsyn.arm.calibration import radians_per_tick

        follower = self.calibrator.follower
        ticks = follower.look()
        parts = []
        for servo in self.calibrator.servos_of(joint):
            low, high = follower.lowest[servo.id], follower.highest[servo.id]
            span = math.degrees((high - low) * radians_per_tick(servo.model))
            parts.append(f"servo {servo.id}: {ticks[servo.id]} ({low} to {high}, {span:.0f} deg)")
        return "  ".join(parts)
