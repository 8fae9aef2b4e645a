"""`armsyn motion`: look into motion files, and turn one kind into another."""

from __future__ import annotations

import importlib

import click

_COMMANDS = {
    "convert": "Write the motion of the file IN as the file OUT; its suffix says the format.",
    "info": "Show what is in a motion FILE: rate, joints, landmarks, gaps, glitches.",
    "retarget": "Put the arm of a captured motion on a described arm's link lengths.",
    "segment": "Find the movements in motions, and say which are usable reaches.",
}
"""Each command with the first line of its help; the module of each is ``motion_NAME``."""


class _Commands(click.Group):
    """A group whose commands are imported when they are called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        del ctx
        return sorted(_COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        del ctx
        if cmd_name not in _COMMANDS:
            return None
        module = importlib.import_module(f"armsyn.cli.motion_{cmd_name}")
        command = getattr(module, cmd_name)
        assert isinstance(command, click.Command)  # noqa: S101 - a slip of ours, not of a user
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        del ctx
        with formatter.section("Commands"):
            formatter.write_dl(sorted(_COMMANDS.items()))


@click.command(cls=_Commands)
def motion() -> None:
    """Look into motion files, and turn one kind into another.

    BVH, ASF/AMC, C3D, TRC, delimited text, MATLAB files of HuG-MP, numpy archives, recordings and
    logs of robots' joints. Inside, lengths are metres, angles radians, and z is up; what a file
    leaves open is assumed and said, unless an option tells it.
    """
