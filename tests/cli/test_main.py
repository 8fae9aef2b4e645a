"""What all commands share: help without heavy imports, statuses, one line for what is wrong."""

import json
import signal
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import armsyn
from armsyn.cli import main as entry
from armsyn.cli.json_errors import document_of
from armsyn.cli.main import COMMANDS, cli
from armsyn.errors import SetpointError
from tests.cli.commands import Outcome, run

Call = Callable[..., Outcome]
ROOT = Path(__file__).resolve().parents[2]


def test_help_lists_every_command_with_its_own_words(call: Call) -> None:
    said = call("--help")
    assert said.status == 0
    for name, words in COMMANDS.items():
        command = cli.get_command(None, name)  # type: ignore[arg-type]
        assert command is not None
        assert command.name == name
        assert command.get_short_help_str(limit=200) == words
        assert " ".join(words.split()) in " ".join(said.out.split())
        own = call(name, "--help")
        assert own.status == 0
        assert words in " ".join(own.out.split())
        assert not own.err


def test_help_imports_nothing_heavy() -> None:
    program = (
        "import sys; sys.argv = ['armsyn', '--help']\n"
        "from armsyn.cli.main import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "heavy = {'numpy', 'scipy', 'numba', 'matplotlib', 'rich', 'serial', 'dynamixel_sdk'}\n"
        "print('heavy:', sorted(heavy & set(sys.modules)))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == "heavy: []"
    assert "Commands:" in done.stdout


def test_the_module_is_the_command() -> None:
    said = run("--version")
    assert (said.status, said.err) == (0, "")
    assert said.out == f"armsyn, version {armsyn.__version__}\n"


def test_an_interrupt_while_it_is_imported_takes_one_line_too() -> None:
    program = (
        "import sys\n"
        "class Interrupted:\n"
        "    def find_spec(name, path=None, target=None):\n"
        "        if name == 'click': raise KeyboardInterrupt\n"
        "sys.meta_path.insert(0, Interrupted)\n"
        "from armsyn.__main__ import main\n"
        "main()\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "armsyn: interrupted\n")


def test_the_command_is_the_module() -> None:
    """The script that is installed begins where an interrupt is caught."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["scripts"]["armsyn"] == "armsyn.__main__:main"


def test_without_arguments_it_shows_its_help(call: Call) -> None:
    said = call()
    assert said.status == 2
    assert "Commands:" in said.out + said.err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["xyzzy"], "No such command 'xyzzy' (see armsyn --help)"),
        (["grasp"], "No such command 'grasp'; did you mean 'grip'?"),
        (["strem"], "No such command 'strem'; did you mean 'stream'?"),
        (["reach", "--tarjet", "0.3"], "'--target'"),
        (["stream", "a.npz", "--plant", "mujocco"], "; did you mean 'mujoco'?"),
        (["--fast"], "--fast"),
        (["reach"], "Missing option '--target'"),
        (["reach", "--target", "0.3", "-0.1"], "Option '--target' requires 3 arguments"),
        (["reach", "--target", "0.3", "-0.1", "up"], "'up' is not a valid float"),
        (["reach", "--target", "0.3", "-0.1", "0", "0"], "unexpected extra argument (0)"),
        (["reach", "--target", "0.3", "-0.1", "0", "--ik", "qp"], "'qp' is not one of"),
        (["learn", "--arm", "human7"], "Missing option '--captures'"),
        (["score", "a.csv"], "Missing argument 'B'"),
    ],
)
def test_usage_errors_are_one_line(call: Call, arguments: list[str], said: str) -> None:
    outcome = call(*arguments)
    outcome.refused(2, said, "--help")


def test_an_interruption_before_anything_ran(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(entry.cli, "main", interrupted)
    call("reach").refused(130, "interrupted")


def test_with_json_errors_are_documents(call: Call) -> None:
    usage = call("reach", "--target", "0.3", "--json")
    assert usage.status == 2
    found = usage.document["error"]
    assert found["type"] == "BadOptionUsage"
    assert found["exit_status"] == 2
    assert usage.err == f"armsyn: {found['message']}\n"
    unknown = call("strem", "--json").document["error"]
    assert "did you mean 'stream'?" in unknown["message"]
    far = call("reach", "--target", "3", "0", "0", "--json")
    assert far.status == far.document["error"]["exit_status"] == 4
    assert far.document["error"]["type"] == "UnreachableError"
    assert far.document["error"]["miss_m"] == pytest.approx(2.4, abs=0.3)


def test_a_misspelt_arm_is_named_as_it_may_be_meant(call: Call) -> None:
    call("arms", "show", "humn7").refused(2, "; did you mean 'human7'?")
    assert "did you mean" not in call("arms", "show", "xyzzy").err


def test_what_follows_two_dashes_asks_for_no_json(call: Call) -> None:
    assert not call("score", "--", "--json", "b.csv").out


def test_an_interruption_is_a_document_too(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise SystemError("compiled code") from KeyboardInterrupt()

    monkeypatch.setattr(entry.cli, "main", interrupted)
    said = call("reach", "--json")
    assert said.document["error"]["type"] == "KeyboardInterrupt"
    assert said.status == 130
    assert said.document["error"]["message"] == "interrupted"


def test_evidence_is_plain_json() -> None:
    error = SetpointError("it gave no posture")
    vars(error).update(value=np.float64(np.nan), rows=np.arange(2), ids=(1, 2), _hidden=1)
    found = json.loads(document_of(error, str(error), 3, {"ending": "held"}))
    assert found["ending"] == "held"
    assert found["error"] == {
        "type": "SetpointError",
        "message": "it gave no posture",
        "exit_status": 3,
        "value": None,
        "rows": [0, 1],
        "ids": [1, 2],
    }


def test_sigterm_ends_a_command_like_ctrl_c(tmp_path: Path) -> None:
    program = "import sys\n"
    program += "from armsyn.cli import main as entry\n"
    program += "entry.cli.main = lambda **_: (print('ready', flush=True), sys.stdin.read())\n"
    program += "entry.main()\n"
    with subprocess.Popen(
        [sys.executable, "-c", program],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        process.send_signal(signal.SIGTERM)
        _, errors = process.communicate(timeout=60)
    assert (process.returncode, errors) == (130, "armsyn: interrupted\n")
