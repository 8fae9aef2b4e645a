"""`armsyn edit`: learn the pattern of motions, and bend one to constraints without leaving it."""

from __future__ import annotations

import click

from armsyn.cli.edit_apply import apply
from armsyn.cli.edit_learn import learn
from armsyn.cli.edit_template import template


@click.group()
def edit() -> None:
    """Learn the pattern of motions, and bend one to constraints without leaving it.

    From Carvalho, Boulic and Thalmann, Motion Pattern Encapsulation for Data-Driven
    Constraint-Based Motion Editing: for whole bodies as captured, and for recorded reaches of arms.
    """


for command in (apply, learn, template):
    edit.add_command(command)
