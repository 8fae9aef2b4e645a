"""Which row of the experiment `anytarget` is best, and what its figures say, in words."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from armsyn.experiments.anytarget_bootstrap import Interval, interval, target_differences
from armsyn.experiments.anytarget_run import Outcome
from armsyn.planning.prediction import REACHED_M

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
    """Return the row of the least held distance, over the floor where there is one.

    Of those that compete; without such as have constants tuned in view of the judged reaches, if
    there are others.
    """
    competing = [outcome for outcome in outcomes.values() if outcome.row.competes]
    held_out = [outcome for outcome in competing if not outcome.row.tuned]
    return _least(held_out or competing, outcomes)


def _least(chosen: Sequence[Outcome], outcomes: Outcomes) -> Outcome:
    def worth(outcome: Outcome) -> float:
        floors = over_floor(outcome, outcomes)
        return outcome.mean("held") if math.isnan(floors) else floors

    return min(chosen, key=worth)


def verdict(outcomes: Outcomes, found: Mapping[str, Interval]) -> str:
    """Say in one line what the figures say of the best row."""
    best = best_of(outcomes)
    said = [f"Best: {_distance(best, outcomes)}"]
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


def said_of_tuned(outcomes: Outcomes) -> list[str]:
    """Say what the best of the tuned rows comes to, if there are any; no held-out figure."""
    tuned = [one for one in outcomes.values() if one.row.competes and one.row.tuned]
    if not tuned:
        return []
    best = _least(tuned, outcomes)
    return [
        f"Beside it, tuned in view of reaches of HuG-MP ({best.row.tuned}), so not held out there:"
        f" {_distance(best, outcomes)}."
    ]


def bells_and_ends(best: Outcome, one_peak: float) -> str:
    """Say whether the best row's hand speeds up once, and ends at its target, in every reach.

    Parameters
    ----------
    best : Outcome
    one_peak : float
        Share of the captured reaches.
    """
    bells, ends = has_one_peak(best), float((best.of("endpoint") <= REACHED_M).mean())
    return (
        f"{best.row.title}: a bell with one peak {_holds(bells)}, as in {one_peak:.1%} of the"
        f" captured ones; ends within 1 mm of its target {_holds(ends)}, as the captured ones do by"
        " definition: a target is where one ended."
    )


def _holds(share: float) -> str:
    return f"{'holds' if share == 1 else 'does not hold'}: in {share:.1%} of its reaches"


def _distance(outcome: Outcome, outcomes: Outcomes) -> str:
    """Held distance in words, over the floor if there is one."""
    floors, said = over_floor(outcome, outcomes), f"{outcome.mean('held') * 100:.2f} cm"
    if math.isnan(floors):
        return f"{outcome.row.title}, {said}"
    kept = "within" if floors <= _PER_FLOOR else "above"
    return (
        f"{outcome.row.title}, {said}, {floors:.3f} times the human floor: {kept} the wanted"
        f" {_PER_FLOOR}"
    )


def over_floor(outcome: Outcome, outcomes: Outcomes, measure: str = "held") -> float:
    """Mean over persons of a distance over the floor's own; NaN where there is no floor."""
    if "floor" not in outcomes:
        return math.nan
    floors, own = outcomes["floor"].by_subject(measure), outcome.by_subject(measure)
    return float(np.mean([own[subject] / floors[subject] for subject in own]))


def has_one_peak(outcome: Outcome) -> float:
    """Share of reaches whose hand speeds up once."""
    return float((outcome.of("speed_peaks") == 1).mean())
