"""Tables of the experiment `neighbours`."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from armsyn.experiments.serving import Served
from armsyn.experiments.tables import Column, Table, Value, centimetres

FACTORS = (1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0)
LENGTHS_M = (0.03, 0.04, 0.05, 0.06, 0.08, 0.10, 0.12)
"""Tolerances in human floors, and in m where there are none."""
_EDGES_M = (0.0, 0.1, 0.2, 0.3, 0.4, 0.6, 2.0)
_WHO = (Column("who", "who"), Column("bounds", "bounds"))


def distance_table(people: Sequence[Served]) -> Table:
    """Held distance by how far a target is from the one that a set was learned at.

    Parameters
    ----------
    people : sequence of Served

    Returns
    -------
    Table
    """
    columns = (
        *_WHO,
        Column("apart", "target is"),
        Column("pairs", "pairs", ".0f"),
        centimetres("mean", "mean held"),
        centimetres("median", "median"),
        centimetres("floor", "floor"),
        Column("floors", "mean / floor", ".2f"),
        Column("served", "served", ".0%"),
    )
    rows = [row for served in people for row in _distance_rows(served)]
    note = "pairs: of a set and a target; the same target: on repeats not learned from."
    return Table("Distance against how far the target is", columns, rows, [note])


def _distance_rows(served: Served) -> list[tuple[Value, ...]]:
    groups = [("the same", served.apart == 0)]
    for low, high in itertools.pairwise(_EDGES_M):
        inside = (served.apart > low) & (served.apart <= high)
        until = f"to {high * 100:.0f} cm" if high < _EDGES_M[-1] else f"over {low * 100:.0f} cm"
        groups.append((until, inside))
    rows: list[tuple[Value, ...]] = []
    for apart, inside in groups:
        chosen = inside & np.isfinite(served.means)
        if not chosen.any():
            continue
        means = served.means[chosen]
        floor = None if served.floors is None else _alike(served.floors, served)[chosen]
        rows.append(
            (
                served.title,
                served.bounds,
                apart,
                means.size,
                float(means.mean()),
                float(np.median(means)),
                None if floor is None else float(floor.mean()),
                None if floor is None else float((means / floor).mean()),
                float(served.serves(served.usual_tolerance)[chosen].mean()),
            )
        )
    return rows


def _alike(floors: np.ndarray, served: Served) -> np.ndarray:
    """Repeat each target's floor for every set, shape (sets, targets)."""
    return np.broadcast_to(floors, served.means.shape)


def fewest_table(person: Sequence[Served]) -> Table:
    """Fewest sets that serve all targets, for rising tolerances.

    Parameters
    ----------
    person : sequence of Served
        The same person with several bounds.

    Returns
    -------
    Table
    """
    has_floor = person[0].floors is not None
    columns = (
        _WHO[1],
        Column("tolerance_floors", "up to floors", "g")
        if has_floor
        else centimetres("tolerance", "up to"),
        Column("sets", "fewest sets", ".0f"),
        Column("covered", "targets served", ".0f"),
        Column("targets", "of", ".0f"),
        Column("chosen", "learned at"),
        Column("not_served", "not served by any"),
    )
    rows: list[tuple[Value, ...]] = []
    for served in person:
        for tolerance in FACTORS if has_floor else LENGTHS_M:
            chosen = served.fewest(tolerance)
            reached = np.asarray(served.serves(tolerance).any(axis=0))
            missing = [place for place, yes in zip(served.targets, reached, strict=True) if not yes]
            rows.append(
                (
                    served.bounds,
                    tolerance,
                    len(chosen),
                    int(reached.sum()),
                    len(reached),
                    _listed([served.targets[served.own[row]] for row in chosen]),
                    _listed(missing),
                )
            )
    notes = [] if has_floor else [_LONE]
    return Table(f"{person[0].title}: fewest sets that serve all targets", columns, rows, notes)


_LONE = (
    "A target's only reach counts for the set that was learned from it, too: there it is a training"
    " error."
)


def _listed(places: Sequence[str]) -> str:
    return " ".join(places) or "-"


def regions_table(person: Sequence[Served]) -> Table:
    """Where each set serves.

    Parameters
    ----------
    person : sequence of Served
        The same person with several bounds.

    Returns
    -------
    Table
    """
    columns = (
        _WHO[1],
        Column("learned_from", "learned from"),
        centimetres("training", "training error"),
        centimetres("own_target", "its target"),
        Column("served", "targets served", ".0f"),
        centimetres("farthest_served", "farthest served"),
        centimetres("nearest_not_served", "nearest not"),
        Column("region", "its region"),
    )
    rows: list[tuple[Value, ...]] = []
    for served in person:
        serves = served.serves(served.usual_tolerance)
        for row, name in enumerate(served.learned.prepared.names):
            yes, apart = serves[row], served.apart[row]
            own = served.means[row, served.own[row]]
            rows.append(
                (
                    served.bounds,
                    name,
                    float(served.learned.distances[row]),
                    float(own) if np.isfinite(own) else None,
                    int(yes.sum()),
                    float(apart[yes].max()) if yes.any() else None,
                    float(apart[~yes].min()) if not yes.all() else None,
                    _listed(
                        [place for place, is_in in zip(served.targets, yes, strict=True) if is_in]
                    ),
                )
            )
    notes = [
        "training error: the paper's distance to the very reach learned from; its target: held"
        " distance on the target's other repeats.",
        *([] if person[0].floors is not None else [_LONE]),
    ]
    return Table(f"{person[0].title}: the region each set serves", columns, rows, notes)


def pairs_table(people: Sequence[Served]) -> Table:
    """Every set on every target.

    Parameters
    ----------
    people : sequence of Served

    Returns
    -------
    Table
    """
    columns = (
        *_WHO,
        Column("learned_from", "learned from"),
        Column("target", "target"),
        centimetres("apart", "apart"),
        centimetres("held", "held"),
        Column("floors", "held / floor", ".2f"),
    )
    rows: list[tuple[Value, ...]] = [
        (
            served.title,
            served.bounds,
            name,
            place,
            float(served.apart[row, column]),
            float(served.means[row, column]),
            None
            if served.floors is None
            else float(served.means[row, column] / served.floors[column]),
        )
        for served in people
        for row, name in enumerate(served.learned.prepared.names)
        for column, place in enumerate(served.targets)
        if np.isfinite(served.means[row, column])
    ]
    return Table("Every set on every target", columns, rows)
