"""Small experiments: two reaches, few evaluations."""

import dataclasses

import pytest

from armsyn.experiments import settings as experiment_settings
from armsyn.experiments.selections import GARZA, HUG_MP, Selection
from armsyn.experiments.settings import Settings


@pytest.fixture
def tiny(monkeypatch: pytest.MonkeyPatch) -> Settings:
    """A budget of a few evaluations; what is tested is what is written, not how good it is."""
    monkeypatch.setitem(experiment_settings.ROLL_OUTS, "small", 8)
    return Settings(budget="small", seed=3, workers=1)


@pytest.fixture
def two_of_each(captures: object) -> tuple[Selection, ...]:
    """Two reaches of each of the experiments' selections."""
    del captures
    return tuple(dataclasses.replace(selection, at_most=2) for selection in (HUG_MP, GARZA))


def silent(name: str, done: int, total: int, said: str) -> None:
    """Report no progress."""
    del name, done, total, said
