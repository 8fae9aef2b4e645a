"""Choices that several commands offer."""

import click

IKS = click.Choice(["svd", "jt", "njt", "dls"])
LEARNERS = click.Choice(["least-squares", "annealing", "cma", "evolution"])
MODELS = click.Choice(["A", "B", "C", "D"])
PLANS = click.Choice(["synergy", "latent", "linear", "minjerk"])
