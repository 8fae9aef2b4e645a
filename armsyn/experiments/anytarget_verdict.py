"""Which row of the experiment `anytarget` is best, and what its figures say, in words."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from armsyn.experiments.anytarget_bootstrap import Interval, interval, target_differences
from armsyn.experiments.anytarget_run import Outcome

Outcomes = Mapping[str, Outcome]
_PER_FLOOR = 1.08
"""Held distance over the floor, on the mean, that the best row is to come within."""


def differences(outcomes: Outcomes, best: Outcome, seed: int) -> dict[str, Interval]:
    """By how much every other competing row's held distance exceeds the best row's, m."""
    return {
        key: interval(target_differences(best, outcome), seed)
        for key, outcome in outcomes.items()
        if outcome.row.competes and outcome is not best
    }


def best_of(outcomes: Outcomes) -> Outcome:
    """Return the competing row of the least held distance, over the floor where there is one."""
    competing = [outcome for outcome in outcomes.values() if outcome.row.competes]

    def worth(outcome: Outcome) -> float:
        floors = over_floor(outcome, outcomes)
        return outcome.mean("held") if math.isnan(floors) else floors

    return min(competing, key=worth)


def verdict(outcomes: Outcomes, found: Mapping[str, Interval]) -> str:
    """Say in one line what the figures say of the best row."""
    best = best_of(outcomes)
    floors = over_floor(best, outcomes)
    said = [f"Best: {best.row.title}, {best.mean('held') * 100:.2f} cm"]
    if not math.isnan(floors):
        kept = "within" if floors <= _PER_FLOOR else "above"
        said[0] += f", {floors:.3f} times the human floor: {kept} the wanted {_PER_FLOOR}"
    if best.row.kind == "baseline":
        said.append("neither synergies nor latent motions beat this baseline here")
    rivals = {
        key: gap
        for key, gap in found.items()
        if outcomes[key].row.kind == "baseline" and gap.verdict != "ahead"
    }
    named = ", ".join(outcomes[key].row.title for key in rivals)
    others = "every other baseline" if best.row.kind == "baseline" else "every baseline"
    said.append(
        f"its interval does not put it ahead of: {named}"
        if rivals
        else f"its interval puts it ahead of {others}"
    )
    return "; ".join(said) + "."


def over_floor(outcome: Outcome, outcomes: Outcomes, measure: str = "held") -> float:
    """Mean over persons of a distance over the floor's own; NaN where there is no floor."""
    if "floor" not in outcomes:
        return math.nan
    floors, own = outcomes["floor"].by_subject(measure), outcome.by_subject(measure)
    return float(np.mean([own[subject] / floors[subject] for subject in own]))


def has_one_peak(outcome: Outcome) -> float:
    """Share of reaches whose hand speeds up once."""
    return float((outcome.of("speed_peaks") == 1).mean())
