"""What every experiment's report says beside its own tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from armsyn.experiments.learned import Learned
from armsyn.experiments.selections import Prepared
from armsyn.experiments.settings import ROLL_OUTS, Settings
from armsyn.experiments.tables import Column, Table, Value, centimetres
from armsyn.synergy.learning import inputs_hash

TRAINING_ERROR = (
    "Every distance here is a **training error**: the parameters were fitted to the very reach"
    " that they are compared with, one set a reach, by the paper's distance. It says how much a"
    " model can express, not how well it predicts. A person's other repeats, on the mean, come"
    " within 1.5 to 2.4 cm of a reach of HuG-MP (the human floor): what lies below is fitted, too."
)


def made_with(
    settings: Settings, prepared: Sequence[Prepared], iks: Sequence[str]
) -> dict[str, Any]:
    """Say what a result depends on.

    Parameters
    ----------
    settings : Settings
    prepared : sequence of Prepared
    iks : sequence of str
        Optimisers.

    Returns
    -------
    dict
    """
    options = settings.options(prepared[0])
    return {
        "learner": options.learner,
        "budget": f"{ROLL_OUTS[settings.budget]} roll-outs a parameter",
        "seed": settings.seed,
        "bounds": "the paper's: gains -5 to 5, slopes 1 to 10 1/s, offsets 0 to 20",
        "lambda_per_s": {ik: options.rate_of(ik) for ik in iks},
        "inputs_sha256": {
            each.selection.key: inputs_hash(each.arm, each.trainings, settings.options(each))
            for each in prepared
        },
    }


def each_reach(learned: Sequence[Learned]) -> Table:
    """List the distance of every reach under every model learned.

    Parameters
    ----------
    learned : sequence of Learned
        Of one selection.

    Returns
    -------
    Table
    """
    prepared = learned[0].prepared
    several = len({each.ik for each in learned}) > 1
    columns = [Column("reach", "reach"), Column("duration_s", "duration, s", ".2f")]
    for each in learned:
        place = f"{each.ik} " if several else ""
        columns.append(centimetres(f"{each.ik}_{each.model}", f"{place}S_{each.model}"))
    rows: list[tuple[Value, ...]] = [
        (
            training.capture.name,
            float(training.time[-1]),
            *(float(each.distances[row]) for each in learned),
        )
        for row, training in enumerate(prepared.trainings)
    ]
    return Table(f"{prepared.selection.title}: every reach", columns, rows)
