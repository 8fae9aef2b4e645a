"""What the command says, to whom, and when there is nobody left to hear it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from firmware_sim.errors import FaultError
from firmware_sim.testing import SteppedSerial, simulated, stepped

COMMAND = f"{sys.executable} -m firmware_sim"
SERVE = f"{COMMAND} --servo xm430-w350:1 --exit-with-stdin"


def shell(line: str) -> tuple[int, str]:
    """Run a line; return its status and what is on standard error."""
    done = subprocess.run(
        ["bash", "-o", "pipefail", "-c", line],
        stdin=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
        timeout=60,
        check=False,
    )
    return done.returncode, done.stderr


@pytest.mark.parametrize(
    ("line", "status", "says"),
    [
        (f"{SERVE} <&-", 2, "standard input is closed"),
        (f"{SERVE} >&-", 2, "standard output is closed"),
        (f"{SERVE} > /dev/full", 2, "standard output cannot be written: No space left"),
        (f"{COMMAND} --list-models > /dev/full", 2, "No space left"),
        (f"{COMMAND} --list-models >&-", 2, "standard output is closed"),
    ],
)
def test_closed_and_full_outputs_are_a_line(line: str, status: int, says: str) -> None:
    code, errors = shell(line)
    assert code == status
    assert says in errors
    assert errors.count("\n") == 1


@pytest.mark.parametrize("errors", ["2>&-", "2>/dev/full"])
def test_without_standard_error_it_runs_all_the_same(errors: str) -> None:
    assert shell(f"{SERVE} {errors} < /dev/null") == (0, "")
    assert shell(f"{COMMAND} --servo nothing:1 {errors}") == (2, "")


def test_what_faults_do_is_said_a_few_times_and_summed_up() -> None:
    line = f"{SERVE} --fault reboot:every=0.05 --fault silent-servo:at=0.5,for=0.2"
    pipe = subprocess.PIPE
    with subprocess.Popen(
        line.split(), stdin=pipe, stderr=pipe, stdout=subprocess.DEVNULL, text=True
    ) as run:
        assert run.stdin is not None
        assert run.stderr is not None
        errors = ""
        while "silent-servo: begins" not in errors:
            said = run.stderr.readline()
            assert said, errors
            errors += said
        run.stdin.close()  # which ends it
        errors += run.stderr.read()
    assert run.returncode == 0
    assert errors.count(" fault 1 reboot") == 5 + 1
    assert "what follows is counted, not said" in errors
    assert "tick 500 (0.500000 s) fault 2 silent-servo: begins" in errors
    assert "silent-servo: 1 strikes" in errors


def test_the_log_is_told_by_the_control_client() -> None:
    with simulated("xm430-w350:1") as arm:
        control = Path(arm.link).parent / "control"
        ask = f"{COMMAND} --control {control}"
        done = subprocess.run(
            [*f"{ask} --log".split()], capture_output=True, text=True, check=True, timeout=60
        )
        assert done.stdout == "no fault has struck yet\n"
        arm.inject("reboot:id=1")
        arm.status()
        done = subprocess.run(
            [*f"{ask} --log".split()], capture_output=True, text=True, check=True, timeout=60
        )
        assert "fault 1 reboot servo 1" in done.stdout
        assert done.stdout.startswith("tick ")
        done = subprocess.run(
            [*f"{ask} --clear all".split()], capture_output=True, text=True, check=True, timeout=60
        )
        assert done.stdout == "no faults were in force\n"


def test_help_has_the_formats_of_its_files() -> None:
    done = subprocess.run(
        [*f"{COMMAND} --help".split()], capture_output=True, text=True, check=True, timeout=60
    )
    assert "[[servo]]" in done.stdout
    assert "[[fault]]" in done.stdout
    assert "0.1 s later" in " ".join(done.stdout.split())


def test_a_fault_that_would_do_nothing_is_refused() -> None:
    for name in ("encoder-error", "electrical-shock"):
        with pytest.raises(FaultError, match="nothing would happen"):
            stepped("ax-12a:1", faults=[name])
        stepped("ax-12a:1", "xm430-w350:2", faults=[name])


def test_wrong_bauds_default_does_for_an_ax() -> None:
    """It has 57143 bit/s, which understands 57600."""
    serial = SteppedSerial(stepped("ax-12a:1", faults=["wrong-baud"]), timeout=0.1)
    serial.baudrate = 57_600
    serial.write(b"\xff\xff\x01\x02\x01\xfb")
    assert serial.read(6) == b"\xff\xff\x01\x02\x00\xfc"
    with pytest.raises(FaultError, match=r"none of ax-12a's .*\.\.\.$") as caught:
        stepped("ax-12a:1", faults=["wrong-baud:baud=3"])
    assert len(str(caught.value)) < 200
    assert os.linesep not in str(caught.value)
