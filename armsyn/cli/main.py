"""The command ``armsyn`` and what all its commands share: lazy loading, one-line errors."""

from __future__ import annotations

import importlib
import sys

import click

import armsyn
from armsyn.errors import ArmsynError

COMMANDS = {
    "arms": "List the arms that are described, show one, or write what other programs need of it.",
    "bands": "Compute bands of human-likeness from CAPTURES, for `armsyn score --bands`.",
    "calibrate": "Find how one real arm is assembled, while you move it by hand.",
    "clear": "Clear what a fault left on an arm, so that it may move again.",
    "experiment": "Repeat a figure of the first paper on captured reaches.",
    "find-port": "Find the serial port that an arm is plugged into.",
    "grip": "Open or close the gripper, to a width or until it holds something.",
    "jog": "Move JOINT by DEGREES (at most 45, negative backwards), slowly; then hold.",
    "learn": "Learn an arm's synergies from captured reaches.",
    "motion": "Look into motion files, and turn one kind into another.",
    "park": "Put an arm to its rest posture and switch its torque off.",
    "reach": "Reach a target as a person would, on a real or simulated arm.",
    "reboot": "Restart servos of an arm that a hardware error has stopped.",
    "record": "Record an arm without moving it.",
    "release": "Switch an arm's torque off: what is raised falls.",
    "restore": "Write a backup (ARM-DATE.eeprom.json) of servos' EEPROM back.",
    "scan": "Look for servos at all baud rates, in both protocols; takes about half a minute.",
    "score": "Score motion B against the captured (or reference) motion A.",
    "setup": "Give servos the IDs, baud rate and settings that an arm's description asks for.",
    "status": "Show an arm's posture, voltages, temperatures, errors and settings.",
    "stream": "Stream a trajectory or a recording to an arm.",
}
"""Each command with the first line of its help: `armsyn --help` imports none of them."""

INTERRUPTED = 130


class LazyGroup(click.Group):
    """A group whose commands are imported when they are called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names of the commands."""
        del ctx
        return sorted(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import the module of a command."""
        del ctx
        if cmd_name not in COMMANDS:
            return None
        module_name = cmd_name.replace("-", "_")
        module = importlib.import_module(f"armsyn.cli.{module_name}")
        command = getattr(module, module_name)
        assert isinstance(command, click.Command)  # noqa: S101 - a slip of ours, not of a user
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands without importing them."""
        del ctx
        with formatter.section("Commands"):
            formatter.write_dl(sorted(COMMANDS.items()))


@click.command(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(armsyn.__version__, prog_name="armsyn")
def cli() -> None:
    """Human-like reaching for Dynamixel arms.

    A target in space becomes a reach with the bell-shaped speed of people (synergy inverse
    kinematics, learned from captured reaches), which is checked, streamed to the arm, recorded
    and scored. Without --port the arm is simulated, and the first line says so.

    Exit status: 0 done; 2 bad input; 3 a fault of the arm, bus or port; 4 a motion refused;
    130 stopped by Ctrl-C or SIGTERM.
    """


def main() -> None:
    """Run the command line; end with the exit status of what went wrong."""
    try:
        # Outside its stand-alone mode click returns the status that a command exits with
        sys.exit(cli.main(prog_name="armsyn", standalone_mode=False) or 0)
    except ArmsynError as error:
        click.echo(f"armsyn: {_one_line(error)}", err=True)
        sys.exit(error.exit_status)
    except click.exceptions.NoArgsIsHelpError as error:
        error.show()
        sys.exit(error.exit_code)
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        path = context.command_path if context is not None else "armsyn"
        click.echo(f"armsyn: {_one_line(error.format_message())} (see {path} --help)", err=True)
        sys.exit(error.exit_code)
    except (KeyboardInterrupt, click.Abort):
        click.echo("armsyn: interrupted", err=True)
        sys.exit(INTERRUPTED)


def _one_line(error: BaseException | str) -> str:
    return " ".join(str(error).split())
