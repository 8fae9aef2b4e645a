"""The command ``armsyn`` and what all its commands share: lazy loading, one-line errors."""

from __future__ import annotations

import importlib
import re
import sys
from typing import Any

import click

import armsyn
from armsyn.cli.interrupts import LostInterrupts, interruptible
from armsyn.cli.json_errors import DocumentedError, document_of
from armsyn.errors import ArmsynError, by_interrupt, meant

COMMANDS = {
    "arms": "List the arms that are described, show one, or write what other programs need of it.",
    "bands": "Compute bands of human-likeness from CAPTURES, for `armsyn score --bands`.",
    "calibrate": "Find how one real arm is assembled, while you move it by hand.",
    "clear": "Clear what a fault left on an arm, so that it may move again.",
    "edit": "Learn the pattern of motions, and bend one to constraints without leaving it.",
    "experiment": "Repeat a figure or case of the papers on captured motions.",
    "find-port": "Find the serial port that an arm is plugged into.",
    "generate": "Make reaches by the thousand, each checked as one that is driven.",
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
    "track": "Follow targets that come as lines of JSON on standard input.",
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

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command that is called; name the one that may be meant."""
        if args and args[0] not in COMMANDS and not args[0].startswith("-"):
            raise click.UsageError(f"No such command {args[0]!r}{meant(args[0], COMMANDS)}", ctx)
        return super().resolve_command(ctx, args)

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
    130 stopped by Ctrl-C or SIGTERM. With --json, what went wrong is one JSON document, too:
    {"error": {"type", "message", "exit_status", ...}}.
    """


def main() -> None:
    """Run the command line; end with the exit status of what went wrong."""
    with interruptible() as lost:
        sys.exit(_status(lost))


def _status(lost: LostInterrupts) -> int:
    try:
        # Outside its stand-alone mode click returns the status that a command exits with
        return cli.main(prog_name="armsyn", standalone_mode=False) or 0
    except DocumentedError as error:
        return _tell(error.error, str(error), error.error.exit_status, error.document)
    except ArmsynError as error:
        return _tell(error, str(error), error.exit_status)
    except click.exceptions.NoArgsIsHelpError as error:
        error.show()
        return error.exit_code
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        path = context.command_path if context is not None else "armsyn"
        said = error.format_message().rstrip(".")
        text = f"{said}{_choice_meant(error)} (see {path} --help)"
        return _tell(error, text, error.exit_code)
    except (KeyboardInterrupt, Exception) as error:
        interrupted = isinstance(error, click.Abort) or by_interrupt(error)
        if not (interrupted or lost.any):
            raise
        lost.forget()
        # What failed for an interrupt is told as one, in a document, too
        kind = error if isinstance(error, click.Abort) else KeyboardInterrupt()
        return _tell(kind, "interrupted", INTERRUPTED)


def _choice_meant(error: click.ClickException) -> str:
    """The choice of an option that a misspelt one may mean."""
    kind = getattr(getattr(error, "param", None), "type", None)
    given = re.match(r"'([^']*)' is not one of", getattr(error, "message", ""))
    return (
        meant(given[1], map(str, kind.choices)) if isinstance(kind, click.Choice) and given else ""
    )


def _tell(
    error: BaseException, text: str, status: int, document: dict[str, Any] | None = None
) -> int:
    """Say in one line what went wrong; where JSON was asked for, as a document, too."""
    line = " ".join(text.split())
    click.echo(f"armsyn: {line}", err=True)
    if _wants_json():
        click.echo(document_of(error, line, status, document or {}))
    return status


def _wants_json() -> bool:
    """Whether the command line asks for JSON, be it one that can be understood or not."""
    arguments = sys.argv[1:]
    return "--json" in arguments[: arguments.index("--") if "--" in arguments else None]
