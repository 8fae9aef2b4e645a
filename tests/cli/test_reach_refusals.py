"""What `armsyn reach` refuses: status, one line, torque as it was found, nothing half-written."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from armsyn.arm import load_arm
from armsyn.driver import ArmSession
from armsyn.driver import registers as reg
from armsyn.driver.transactions import Bus
from firmware_sim.testing import running
from tests.cli.commands import Outcome, run

pytestmark = pytest.mark.usefixtures("compiled")

Call = Callable[..., Outcome]
TARGET = ("--target", "0.35", "-0.1", "-0.15")
ARM = ("--arm", "human7", "--baud", "1000000")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--target", "nan", "0", "0"), "--target must be three finite numbers of metres"),
        (("--target", "0.3", "-inf", "0"), "--target must be three finite numbers of metres"),
        ((*TARGET, "--arm", "human8"), "no human8.toml in"),
        ((*TARGET, "--arm", "../human7"), "'../human7' is not the name of an arm"),
        ((*TARGET, "--arm", "hug_mp4"), "hug_mp4"),
        ((*TARGET, "--calibration", "/nowhere"), "no human7.toml in /nowhere"),
        ((*TARGET, "--port", "/dev/ttyUSB0"), "--port needs --arm"),
        ((*TARGET, "--rate", "0"), "--rate must be above 0 and at most 2000 Hz, got 0"),
        ((*TARGET, "--rate", "nan"), "--rate must be above 0 and at most 2000 Hz, got nan"),
        ((*TARGET, "--slower", "0.5"), "--slower must be at least 1, got 0.5"),
        ((*TARGET, "--slower", "nan"), "--slower must be at least 1, got nan"),
        ((*TARGET, "--slower", "1e200"), "--slower must be at most 1000000, got 1e+200"),
        ((*TARGET, "--raw", "--model", "D"), "--raw is model A: give either --raw or --model"),
        ((*TARGET, "--plan", "latent", "--ik", "dls"), "are of --plan synergy, not of latent"),
        ((*TARGET, "--plan", "linear", "--raw"), "are of --plan synergy, not of linear"),
        ((*TARGET, "--plan", "best"), "'best' is not one of 'synergy', 'latent', 'linear', 'minj"),
        ((*TARGET, "--pointing", "0", "0", "0"), "--pointing: a direction is 3 finite numbers"),
        ((*TARGET, "--pointing", "1", "nan", "0"), "--pointing: a direction is 3 finite numbers"),
        ((*TARGET, "--orientation", "0", "inf", "0"), "--orientation must be three finite angles"),
        (
            (*TARGET, "--orientation", "0", "0", "0", "--pointing", "1", "0", "0"),
            "--pointing or --orientation",
        ),
        ((*TARGET, "--orientation-tolerance", "3"), "needs --pointing or --orientation"),
        (
            (*TARGET, "--pointing", "1", "0", "0", "--orientation-tolerance", "0"),
            "--orientation-tolerance must be above 0 and at most 180 degrees, got 0",
        ),
        ((*TARGET, "--rate", "1e9"), "--rate must be above 0 and at most 2000 Hz, got 1e+09"),
        ((*TARGET, "--plot", "absent/a.png"), "--plot absent/a.png: must end in .png, in a folder"),
        ((*TARGET, "--plot", "a.pdf"), "--plot a.pdf: must end in .png"),
        ((*TARGET, "--record", "a.txt"), "a.txt: recordings are written as .npz or .csv"),
        ((*TARGET, "--record", "absent/a.csv"), "the folder absent does not exist: make it first"),
    ],
    ids=lambda value: " ".join(value[-2:]) if isinstance(value, tuple) else "",
)
def test_bad_input_is_refused_before_any_port(
    call: Call,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    arguments: tuple[str, ...],
    said: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    outcome = call("reach", *arguments)
    outcome.refused(2, said)
    assert not outcome.out  # no simulator was started
    assert list(tmp_path.iterdir()) == []


def test_a_refusal_is_the_same_in_a_process_of_its_own() -> None:
    outcome = run("reach", "--target", "nan", "0", "0")
    outcome.refused(2, "--target must be three finite numbers of metres")


def cut(path: Path) -> None:
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])


def twice(path: Path) -> None:
    text = path.read_text()
    assert "\nid = 3\n" in text
    path.write_text(text.replace("\nid = 3\n", "\nid = 2\n"))


@pytest.mark.parametrize(
    ("name", "damage", "said"),
    [
        ("human7.synergies.json", cut, "learn it again with armsyn learn"),
        (
            "human7.synergies.json",
            Path.unlink,
            "(run armsyn learn --arm human7 --captures",
        ),
        ("human7.toml", cut, ""),
        ("human7.toml", Path.unlink, "no human7.toml in"),
        ("human7.toml", twice, "servo ID 2 is given twice"),
        ("human7.toml", lambda path: path.write_bytes(b"\xff\xfe"), "can't decode byte"),
    ],
    ids=["half synergies", "no synergies", "half arm", "no arm", "ID twice", "bytes"],
)
def test_damaged_files_are_named(
    call: Call, calibration: Path, name: str, damage: Callable[[Path], object], said: str
) -> None:
    damage(calibration / name)
    outcome = call("reach", *TARGET, "--model", "C", "--calibration", calibration)
    outcome.refused(2, said, f"{calibration}")
    assert not outcome.out


def test_synergies_of_another_arm_are_refused(call: Call, calibration: Path) -> None:
    (calibration / "koch.synergies.json").write_bytes(
        (calibration / "human7.synergies.json").read_bytes()
    )
    asked = ("--arm", "koch", "--model", "C", "--calibration", calibration)
    outcome = call("reach", *TARGET, *asked)
    outcome.refused(2, "the synergies are those of human7", "run armsyn learn --arm koch")


@pytest.mark.parametrize("option", [("--model", "D"), ("--ik", "dls")])
def test_what_was_not_learned_is_refused(
    call: Call, calibration: Path, option: tuple[str, str]
) -> None:
    path = calibration / "human7.synergies.json"
    content = json.loads(path.read_text())
    for reach in content["reaches"]:
        reach["sets"] = [s for s in reach["sets"] if (s["ik"], s["model"]) == ("svd", "C")]
    path.write_text(json.dumps(content))
    outcome = call("reach", *TARGET, *option, "--calibration", calibration)
    outcome.refused(2, "human7 has learned nothing", "only svd/C: run armsyn learn")


@pytest.mark.parametrize("plan", ["latent", "linear"])
def test_an_arm_without_an_atlas_says_how_to_get_one(
    call: Call, calibration: Path, plan: str
) -> None:
    (calibration / "human7.atlas.json").unlink(missing_ok=True)
    outcome = call("reach", *TARGET, "--plan", plan, "--calibration", calibration)
    outcome.refused(2, "armsyn learn --arm human7 --atlas", "--plan synergy or minjerk")


def test_what_an_arm_cannot_express_is_said(call: Call) -> None:
    arm = ("--arm", "openmanipulator_x", "--target", "0.2", "0.08", "0.15")
    outcome = call("reach", *arm, "--plan", "minjerk", "--pointing", "0", "1", "0")
    outcome.refused(4, "its 4 joints leave one of 2 angles of the hand free", "degrees")


@pytest.mark.fault(32)
@pytest.mark.parametrize("target", [("0.9", "0", "0"), ("0", "0", "0.9"), ("-0.5", "0.3", "0.2")])
def test_out_of_reach_is_refused(call: Call, target: tuple[str, str, str], tmp_path: Path) -> None:
    record = tmp_path / "reach.npz"
    outcome = call("reach", "--target", *target, "--record", record)
    outcome.refused(4, "cannot be reached by human7", "its hand stays 0.")
    assert not record.exists()


@pytest.mark.fault(13)
def test_a_port_that_does_not_exist(call: Call, tmp_path: Path) -> None:
    port = tmp_path / "ttyUSB7"
    on_port(call, str(port)).refused(3, str(port))


def test_a_file_is_no_port(call: Call, tmp_path: Path) -> None:
    port = tmp_path / "ttyUSB7"
    port.write_text("no port")
    on_port(call, str(port)).refused(3, str(port))
    assert port.read_text() == "no port"


def torque(port: str, ids: tuple[int, ...]) -> list[int]:
    bus = Bus(port, 1_000_000)
    try:
        return list(bus.read_all(reg.TORQUE_ENABLE, ids).values())
    finally:
        bus.close()


def on_port(call: Call, port: str, *more: str) -> Outcome:
    outcome = call("reach", *TARGET, "--arm", "human7", "--port", port, *more)
    assert outcome.out in ("", f"human7 on {port}, not calibrated: the description's zeros\n")
    return Outcome(outcome.status, "", outcome.err)


def test_a_port_that_is_taken() -> None:
    with (
        running(arguments=(*ARM, "--return-delay", "0")) as port,
        ArmSession.open(port, load_arm("human7"), 200.0),
    ):
        outcome = run("reach", *TARGET, "--arm", "human7", "--port", port)
        Outcome(outcome.status, "", outcome.err).refused(3, port, "taken by process")


@pytest.mark.fault(8)
def test_a_servo_that_is_missing(call: Call) -> None:
    models = ["xm540-w270"] * 4 + ["xm430-w350"] * 3
    present = [f"{model}:{i}" for i, model in enumerate(models, start=1) if i != 5]
    with running(*present, arguments=("--baud", "1000000", "--return-delay", "0")) as port:
        on_port(call, port).refused(3, "servo 5", "forearm_pronation")
        assert torque(port, (1, 2, 3, 4, 6, 7)) == [0] * 6


def test_a_servo_of_another_model(call: Call) -> None:
    servos = [f"xm540-w270:{i}" for i in range(1, 8)]
    with running(*servos, arguments=("--baud", "1000000", "--return-delay", "0")) as port:
        on_port(call, port).refused(3, "xm430-w350", "xm540-w270")
        assert torque(port, tuple(range(1, 8))) == [0] * 7


def test_a_rate_that_the_wire_cannot_carry(call: Call) -> None:
    """Seven servos with the factory's return delay of 500 us: 2.26 ms a cycle, by fast reads."""
    with running(arguments=(*ARM, "--return-delay", "250")) as port:
        outcome = on_port(call, port, "--rate", "400")
        outcome.refused(3, "400 Hz leaves 2.50 ms", "2.26 ms", "0.50 ms of return delay")
        assert torque(port, tuple(range(1, 8))) == [0] * 7


@pytest.mark.fault(42)
def test_torque_that_was_on_stays_on_after_a_refusal(call: Call) -> None:
    with running(arguments=(*ARM, "--return-delay", "0")) as port:
        bus = Bus(port, 1_000_000)
        for servo in range(1, 8):
            bus.write(servo, reg.TORQUE_ENABLE, 1)
        bus.close()
        outcome = call("reach", "--target", "0.9", "0", "0", "--arm", "human7", "--port", port)
        Outcome(outcome.status, "", outcome.err).refused(4, "cannot be reached")
        assert torque(port, tuple(range(1, 8))) == [1] * 7
