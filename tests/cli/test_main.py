"""What all commands share: help without heavy imports, statuses, one line for what is wrong."""

import subprocess
import sys
from collections.abc import Callable

import pytest

import armsyn
from armsyn.cli import main as entry
from armsyn.cli.main import COMMANDS, cli
from tests.cli.commands import Outcome, run

Call = Callable[..., Outcome]


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


def test_without_arguments_it_shows_its_help(call: Call) -> None:
    said = call()
    assert said.status == 2
    assert "Commands:" in said.out + said.err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["grasp"], "No such command 'grasp'"),
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
