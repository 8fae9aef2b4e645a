"""Choices that several commands offer."""

import click

IKS = click.Choice(["svd", "jt", "njt", "dls"])
MODELS = click.Choice(["A", "B", "C", "D"])
