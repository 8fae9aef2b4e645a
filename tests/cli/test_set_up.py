"""`armsyn scan`, `setup`, `restore` and `calibrate` on simulated servos in another process."""

from __future__ import annotations

import re
import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import click
import pytest

from armsyn.arm import load_arm
from armsyn.arm.calibration_file import read_calibration
from armsyn.cli import prompts
from firmware_sim.testing import RunningSimulator, simulated
from tests.cli.commands import Outcome, run

CALIBRATION = Path(__file__).resolve().parents[2] / "calibration"

FOUND_AT = 4_000_000
"""bit/s; fast to look at."""

Call = Callable[..., Outcome]
Script = list[object]
Watching = Callable[[Callable[[], str]], None]


class ScriptedPerson:
    """Answers in order: a string to a question, a bool to a yes-or-no, a callable to Enter.

    An exception is what the person does instead.
    """

    def __init__(self, *script: object) -> None:
        self.script: Script = list(script)
        self.heard: list[str] = []

    def _next(self, text: str) -> object:
        self.heard.append(text)
        assert self.script, f"nobody answers {text!r}"
        answer = self.script.pop(0)
        if isinstance(answer, BaseException):
            raise answer
        return answer

    def say(self, text: str) -> None:
        self.heard.append(text)

    def confirm(self, question: str) -> bool:
        answer = self._next(question)
        assert isinstance(answer, bool), question
        return answer

    def ask(self, question: str) -> str:
        answer = self._next(question)
        assert isinstance(answer, str), question
        return answer

    def watch(self, text: str, look: Callable[[], str]) -> None:
        answer = self._next(text)
        assert callable(answer), text
        answer(look)

    @property
    def said(self) -> str:
        return "\n".join(self.heard)


@pytest.fixture
def person(monkeypatch: pytest.MonkeyPatch) -> Callable[..., ScriptedPerson]:
    def make(*script: object) -> ScriptedPerson:
        asked = ScriptedPerson(*script)
        monkeypatch.setattr(prompts, "person", lambda: asked)
        return asked

    return make


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    shutil.copy(CALIBRATION / "koch.toml", tmp_path)
    (tmp_path / f"{SMALL}.toml").write_text(DESCRIPTION)
    return tmp_path


@pytest.fixture(scope="module")
def lone() -> Iterator[RunningSimulator]:
    """One servo, as the factory leaves it; each test restores what it changes."""
    with simulated("xl430-w250:1", baud=FOUND_AT) as servo:
        yield servo


def scanned(call: Call, port: str, baud: int) -> list[tuple[int, int, str]]:
    servos = call("scan", "--port", port, "--baud", baud, "--protocol", 2, "--json").document
    return [(s["id"], s["baud"], s["model"]) for s in servos["servos"]]


def test_a_servo_is_set_up_and_restored(
    call: Call, person: Callable[..., ScriptedPerson], lone: RunningSimulator, folder: Path
) -> None:
    options = ("--arm", "koch", "--port", lone.port, "--calibration", folder, "--baud", FOUND_AT)
    asked = person("", True)
    outcome = call("setup", *options, "--servo", 2, "--json")
    assert outcome.status == 0, outcome.err
    assert "connect only the servo for shoulder_lift" in asked.heard[0]
    (servo,) = outcome.document["servos"]
    assert [(c["register"], c["found"], c["wanted"]) for c in servo["changes"]] == [
        ("Return Delay Time", 250, 0),
        ("ID", 1, 2),
        ("Baud Rate", 6, 3),
    ]
    assert servo["written"]
    backup = Path(outcome.document["backup"])
    assert backup.parent == folder
    assert scanned(call, lone.port, 1_000_000) == [(2, 1_000_000, "xl430-w250")]

    person(True)
    restored = call("restore", backup, "--port", lone.port, "--json")
    assert restored.status == 0, restored.err
    assert scanned(call, lone.port, FOUND_AT) == [(1, FOUND_AT, "xl430-w250")]
    assert len(list(folder.glob("koch-*.eeprom.json"))) == 2


@pytest.mark.parametrize(
    ("script", "options", "status"),
    [
        (("", False), (), 0),
        (("",), ("--dry-run",), 0),
        (("s",), (), 0),
        ((KeyboardInterrupt(),), (), 130),
        (("", click.Abort()), (), 130),
    ],
)
def test_who_gives_up_has_written_nothing(
    call: Call,
    person: Callable[..., ScriptedPerson],
    lone: RunningSimulator,
    folder: Path,
    script: tuple[object, ...],
    options: tuple[str, ...],
    status: int,
) -> None:
    asked = person(*script)
    where = ("--arm", "koch", "--port", lone.port, "--calibration", folder)
    outcome = call("setup", *where, "--servo", 2, "--baud", FOUND_AT, *options)
    assert outcome.status == status, outcome.err
    assert not asked.script
    assert scanned(call, lone.port, FOUND_AT) == [(1, FOUND_AT, "xl430-w250")]
    assert not list(folder.glob("*.eeprom.json"))


def test_ctrl_c_while_it_writes_is_met_after_the_servo(
    call: Call,
    person: Callable[..., ScriptedPerson],
    lone: RunningSimulator,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    import os
    import signal

    from armsyn.driver.transactions import Bus

    original = Bus.sync_write

    def interrupted(self: Bus, *arguments: object) -> None:
        os.kill(os.getpid(), signal.SIGINT)
        original(self, *arguments)  # type: ignore[arg-type]

    person("", True)
    monkeypatch.setattr(Bus, "sync_write", interrupted)
    where = ("--arm", "koch", "--port", lone.port, "--calibration", folder)
    outcome = call("setup", *where, "--servo", 2, "--baud", FOUND_AT)
    assert outcome.status == 130
    monkeypatch.setattr(Bus, "sync_write", original)
    assert scanned(call, lone.port, 1_000_000) == [(2, 1_000_000, "xl430-w250")]
    (backup,) = folder.glob("*.eeprom.json")
    assert call("restore", backup, "--port", lone.port, "--yes").status == 0


def test_refusals_are_one_line(call: Call, lone: RunningSimulator, folder: Path) -> None:
    where = ("--port", lone.port, "--calibration", folder, "--yes")
    call("setup", "--arm", "koch", *where, "--servo", 4, "--baud", FOUND_AT).refused(
        3, "is an xl430-w250", "nothing was written"
    )
    call("setup", "--arm", "koch", *where, "--servo", 44).refused(2, "--servo 44", "1, 2, 3")
    call("setup", "--arm", "hug_mp4", "--port", lone.port).refused(2, "no servos")
    call("setup", "--arm", "koch", *where, "--all").refused(3, "no answer from servo 1")
    call("restore", folder / "nothing.json", "--port", lone.port).refused(2, "nothing.json")
    call("calibrate", "--arm", "koch", *where[:4], "--check").refused(2, "not calibrated")
    call("calibrate", "--arm", "koch", *where[:4], "--name", "../x").refused(2, "--name")


def test_an_arm_that_is_set_up_is_sent_to_its_calibration(
    call: Call, person: Callable[..., ScriptedPerson], arm: RunningSimulator, folder: Path
) -> None:
    where = ("--arm", SMALL, "--port", arm.port, "--calibration", folder)
    asked = person()
    assert call("setup", *where, "--all", "--yes").status == 0
    assert asked.heard[-1] == f"next: armsyn calibrate {' '.join(map(str, where))}"
    asked = person()
    assert call("setup", *where, "--all", "--yes", "--servo", 1).status == 0
    assert "next:" not in asked.said


def test_a_servo_under_torque_is_left_alone(
    call: Call, lone: RunningSimulator, folder: Path
) -> None:
    from armsyn.driver.registers import X
    from armsyn.driver.transactions import Bus

    bus = Bus(lone.port, FOUND_AT)
    bus.write(1, X["Torque Enable"], 1)
    bus.close()
    where = ("--arm", "koch", "--port", lone.port, "--calibration", folder, "--yes")
    outcome = call("setup", *where, "--servo", 1, "--baud", FOUND_AT)
    bus = Bus(lone.port, FOUND_AT)
    held = bus.read(1, X["Torque Enable"])
    bus.write(1, X["Torque Enable"], 0)
    bus.close()
    outcome.refused(3, "armsyn release")
    assert held == 1


def test_scan_says_what_it_found(call: Call, lone: RunningSimulator) -> None:
    found = call("scan", "--port", lone.port, "--baud", FOUND_AT)
    assert found.status == 0
    assert "xl430-w250" in found.out
    nobody = call("scan", "--port", lone.port, "--baud", 1_000_000, "--protocol", 1)
    assert nobody.status == 3
    assert "no servo answers" in nobody.out
    call("scan", "--port", "/dev/nowhere").refused(3, "does not exist")


# an arm that hands move

SMALL = "small"
REST = {1: 2048, 2: 2374}
DESCRIPTION = """
schema = "armsyn-arm-1"
name = "small"
title = "two joints"
landmarks = { hand = "tip" }
tip = { xyz = [0.2, 0.0, 0.0] }

[[joint]]
name = "pan"
axis = [0.0, 0.0, 1.0]
lower = -2.0
upper = 2.0
rest = 0.0
max_velocity = 3.0
max_acceleration = 10.0

[[joint]]
name = "bend"
xyz = [0.1, 0.0, 0.0]
axis = [0.0, 1.0, 0.0]
lower = -1.5
upper = 1.5
rest = 0.5
max_velocity = 3.0
max_acceleration = 10.0

[[servo]]
joint = "pan"
id = 1
model = "xm430-w350"
zero_tick = 2048
rest_tick = 2048
supply_voltage = 12.0

[[servo]]
joint = "bend"
id = 2
model = "xm430-w350"
zero_tick = 2048
rest_tick = 2374
supply_voltage = 12.0
"""


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningSimulator]:
    place = tmp_path_factory.mktemp("arm")
    (place / f"{SMALL}.toml").write_text(DESCRIPTION)
    with simulated(arguments=("--arm", SMALL, "--calibration", str(place))) as simulator:
        yield simulator


PATIENCE = 20.0
NEAR = 12


def hand(simulator: RunningSimulator, *places: dict[int, int]) -> Watching:
    """Turn horns to places, one after the other, while the command looks."""

    def watch(look: Callable[[], str]) -> None:
        for ticks in places:
            for servo_id, tick in ticks.items():
                simulator.inject(f"hand:id={servo_id},to={tick},speed=20")
            end = time.monotonic() + PATIENCE
            while not arrived(look(), ticks):
                assert time.monotonic() < end, f"the hand does not get to {ticks}"
            simulator.clear("hand")

    return watch


def arrived(seen: str, ticks: dict[int, int]) -> bool:
    """Whether what the command shows is where the hand was to go."""
    shown = {int(a): int(b) for a, b in re.findall(r"(\d+): (-?\d+)", seen)}
    return all(abs(shown[i] - tick) <= NEAR for i, tick in ticks.items() if i in shown)


def nothing(look: Callable[[], str]) -> None:
    look()


def test_an_arm_is_calibrated_by_its_rest_posture(
    call: Call, person: Callable[..., ScriptedPerson], arm: RunningSimulator, folder: Path
) -> None:
    where = ("--arm", SMALL, "--port", arm.port, "--calibration", folder)
    asked = person(hand(arm, REST), True)
    assert call("calibrate", *where, "--name", "left").status == 0
    assert "Rest posture of small" in asked.said
    path = folder / f"{SMALL}.left.calibration.json"
    assert f"wrote {path}\ncommands that run in another folder" in asked.said
    options = f"--arm {SMALL} --port {arm.port} --name left --calibration {folder}"
    assert f"next: armsyn status --watch {options};" in asked.said
    status = call("status", *where, "--name", "left", "--json")
    assert status.err.startswith(f"{SMALL} on {arm.port}, calibrated by {path}\n")
    assert status.document["calibration"] == str(path)
    calibration = read_calibration(path)
    described = load_arm(SMALL, folder)
    assert (calibration.name, calibration.method) == ("left", "rest")
    zeros = [servo.zero_tick for servo in described.servo]
    assert [s.zero_tick for s in calibration.servo] == pytest.approx(zeros, abs=NEAR)
    checked = call("calibrate", *where, "--name", "left", "--check", "--at-rest", "--json")
    assert checked.status == 0
    assert checked.document["problems"] == []

    person(hand(arm, REST), False)
    before = path.read_bytes()
    assert call("calibrate", *where, "--name", "left").status == 0
    assert path.read_bytes() == before
    person(hand(arm, REST), True)
    assert call("calibrate", *where, "--name", "left").status == 0
    assert path.with_name(f"{path.name}.old").read_bytes() == before


def test_who_gives_up_in_the_middle_has_no_calibration(
    call: Call, person: Callable[..., ScriptedPerson], arm: RunningSimulator, folder: Path
) -> None:
    where = ("--arm", SMALL, "--port", arm.port, "--calibration", folder)
    person(nothing, hand(arm, {1: 2400}), KeyboardInterrupt())
    assert call("calibrate", *where, "--method", "hand").status == 130
    assert not list(folder.glob("*.calibration.json*"))


def test_an_arm_is_calibrated_by_hand(
    call: Call, person: Callable[..., ScriptedPerson], arm: RunningSimulator, folder: Path
) -> None:
    rest = {servo.id: servo.rest_tick for servo in load_arm(SMALL, folder).servo}
    steps: list[object] = [hand(arm, rest)]
    for servo_id, tick in rest.items():
        steps += [
            hand(arm, {servo_id: tick + 30}),  # too little: asked once more
            hand(arm, {servo_id: tick + 350}),
            hand(arm, {servo_id: tick + 500}, {servo_id: tick - 500}, {servo_id: tick}),
        ]
    steps += [hand(arm, {1: rest[1] + 400}), hand(arm, rest), True]
    asked = person(*steps)
    where = ("--arm", SMALL, "--port", arm.port, "--calibration", folder)
    outcome = call("calibrate", *where, "--method", "hand", "--json")
    assert outcome.status == 0, outcome.err
    assert not asked.script
    assert asked.said.count("has hardly moved") == len(rest)
    assert "It is not where it was at the beginning (pan by +3" in asked.said
    for servo in outcome.document["calibration"]["servo"]:
        middle = rest[servo["id"]]
        assert servo["range_ticks"] == pytest.approx((middle - 500, middle + 500), abs=2 * NEAR)
        assert servo["direction"] == 1
    limits = [load_arm(SMALL, folder, calibrated=c).joint[1].upper for c in (True, False)]
    assert limits[0] < limits[1]


def test_help_of_each_command_says_what_it_does() -> None:
    for command in ("scan", "setup", "restore", "calibrate"):
        outcome = run(command, "--help")
        assert outcome.status == 0
        assert "--port" in outcome.out
