"""Tables of the experiment `anytarget`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from armsyn.experiments.anytarget_bootstrap import LEVEL
from armsyn.experiments.anytarget_people import People
from armsyn.experiments.anytarget_rows import Row
from armsyn.experiments.anytarget_run import TITLES, Outcome
from armsyn.experiments.anytarget_scores import MEASURES, score
from armsyn.experiments.anytarget_verdict import (
    Outcomes,
    bells_and_ends,
    best_of,
    differences,
    has_one_peak,
    over_floor,
    said_of_tuned,
    verdict,
)
from armsyn.experiments.tables import Column, Table, Value, centimetres
from armsyn.motion import FloatArray

_DEGREES = 180 / math.pi
_ROW = Column("row", "row")
_DISTANCES = (
    _ROW,
    centimetres("held", "held"),
    Column("floors", "/ floor", ".3f"),
    centimetres("held_time_given", "time given"),
    Column("floors_time_given", "/ floor", ".3f"),
    centimetres("held_trimmed", "5 % cut"),
)
_POSTURES = (
    _ROW,
    Column("endpoint_m", "end, mm", ".3f", 1e3),
    Column("success", "success", ".1%"),
    centimetres("elbow", "elbow"),
    Column("swivel_rad", "swivel, deg", ".1f", _DEGREES),
    Column("direction_rad", "direction, deg", ".1f", _DEGREES),
)
_LOOKS = (
    _ROW,
    Column("time_to_peak", "time to peak", ".2f"),
    Column("peak_over_mean", "peak / mean", ".2f"),
    Column("one_peak", "one peak", ".0%"),
    Column("profile_r", "speed r", "+.2f"),
    Column("sparc", "SPARC", ".2f"),
    Column("log_time_ratio", "ln T", "+.2f"),
)
_DISTANCES_NOTE = (
    "Means over persons of the means over their reaches. held: held distance on the segments as"
    " cut, the movement time predicted; time given: the captured one instead; 5 % cut: both trimmed"
    " to onset and offset, time predicted. / floor: mean over persons of each distance over the"
    " human floor's own in the same column. References and bounds know reaches to the very target,"
    " so they do not compete."
)
_POSTURES_NOTE = (
    "end: from the hand's end to the target; success: that is 1 mm or less, no joint leaves its"
    " range, and the motion can be measured; elbow, swivel, direction (of upper arm and forearm):"
    " mean error over normalised time."
)
_LOOKS_NOTE = (
    "captured: the people themselves. one peak: share of reaches, the speed low-passed at 6 Hz and"
    " counted from the first frame to the last, not from onset to offset as the other measures;"
    " speed r: correlation with the person's mean speed profile;"
    " ln T: log of predicted over captured movement time."
)
_KINDS = {
    "reference": "reference, shown the target",
    "baseline": "baseline",
    "synergy": "synergies, as of the first paper",
    "latent": "latent motions, as of the second paper",
    "joined": "both papers joined",
    "bound": "bound, shown the very reach",
}


def rows_table(rows: Sequence[Row], missing: Mapping[str, str]) -> Table:
    """Say what each row is, and why some cannot be had here.

    Parameters
    ----------
    rows : sequence of Row
    missing : mapping of str to str
        By the keys of rows, why.

    Returns
    -------
    Table
    """
    columns = (
        _ROW,
        Column("kind", "kind"),
        Column("how", "how it predicts"),
        Column("tuned", "tuned in view of the judged reaches"),
    )
    lines: list[tuple[Value, ...]] = [
        (row.title, _KINDS[row.kind], missing.get(row.key) or row.what, row.tuned or None)
        for row in rows
    ]
    return Table("Rows", columns, lines)


def distances_table(outcomes: Outcomes) -> Table:
    """Set the held distances of every row side by side.

    Parameters
    ----------
    outcomes : mapping of str to Outcome
        Of one group of people and one protocol, the floor among them where there is one.

    Returns
    -------
    Table
    """
    rows: list[tuple[Value, ...]] = [
        (
            outcome.row.title,
            outcome.mean("held"),
            _finite(over_floor(outcome, outcomes)),
            outcome.mean("held_given"),
            _finite(over_floor(outcome, outcomes, "held_given")),
            _finite(outcome.mean("held_trimmed")),
        )
        for outcome in outcomes.values()
    ]
    return Table(_title(outcomes), _DISTANCES, rows, [_DISTANCES_NOTE])


def postures_table(outcomes: Outcomes) -> Table:
    """Set where reaches end and how the arm is held side by side."""
    keys = ("endpoint", "success", "elbow", "swivel", "direction")
    rows: list[tuple[Value, ...]] = [
        (outcome.row.title, *(_finite(outcome.mean(key)) for key in keys))
        for outcome in outcomes.values()
    ]
    return Table(f"{_title(outcomes)}: end and posture", _POSTURES, rows, [_POSTURES_NOTE])


def looks_table(outcomes: Outcomes, captured: Mapping[str, float]) -> Table:
    """Set speed profiles and movement times side by side.

    Parameters
    ----------
    outcomes : mapping of str to Outcome
    captured : mapping of str to float
        The people's own measures, by the keys of the columns.

    Returns
    -------
    Table
    """
    keys = [column.key for column in _LOOKS[1:]]
    rows: list[tuple[Value, ...]] = [("captured", *(_finite(captured[key]) for key in keys))]
    for outcome in outcomes.values():
        found = looks_of(outcome)
        rows.append((outcome.row.title, *(_finite(found[key]) for key in keys)))
    return Table(f"{_title(outcomes)}: speed and time", _LOOKS, rows, [_LOOKS_NOTE])


def captured_looks(people: People) -> dict[str, float]:
    """Return what `looks_table` shows of the people themselves."""
    found: dict[str, list[FloatArray]] = {}
    for subject in people.subjects:
        profile = people.profiles[subject]
        scores = [
            score(motion, motion, motion, motion.hand[-1], profile, in_range=True)
            for motion in (people.captured[row] for row in people.of(subject))
        ]
        for key, values in zip(MEASURES, np.array(scores).T, strict=True):
            found.setdefault(key, []).append(values)
    peaks = np.concatenate(found["speed_peaks"])
    means = {key: float(np.mean([part.mean() for part in parts])) for key, parts in found.items()}
    return means | {"one_peak": float((peaks == 1).mean()), "log_time_ratio": 0.0}


def looks_of(outcome: Outcome) -> dict[str, float]:
    """Return the means that `looks_table` shows of a row."""
    return {
        **{
            key: outcome.mean(key)
            for key in ("time_to_peak", "peak_over_mean", "profile_r", "sparc")
        },
        "one_peak": has_one_peak(outcome),
        "log_time_ratio": outcome.mean("log_time"),
    }


def persons_table(outcomes: Outcomes) -> Table:
    """Held distance of every row for each person."""
    subjects = next(iter(outcomes.values())).people.subjects
    columns = (_ROW, *(centimetres(subject, subject) for subject in subjects))
    rows: list[tuple[Value, ...]] = []
    for outcome in outcomes.values():
        by_subject = outcome.by_subject("held")
        rows.append((outcome.row.title, *(_finite(by_subject[subject]) for subject in subjects)))
    return Table(f"{_title(outcomes)}: held distance of each person", columns, rows)


def differences_table(outcomes: Outcomes, seed: int, one_peak: float) -> Table:
    """Set the best row against every other one that competes.

    Parameters
    ----------
    outcomes : mapping of str to Outcome
    seed : int
        Of the bootstrap.
    one_peak : float
        Share of the captured reaches whose hand speeds up once.

    Returns
    -------
    Table
        With a verdict from the figures.
    """
    best = best_of(outcomes)
    columns = (
        Column("against", "against"),
        centimetres("ahead_by", "ahead by"),
        centimetres("low", "from"),
        centimetres("high", "to"),
        Column("verdict", "it is"),
    )
    found = differences(outcomes, best, seed)
    rows: list[tuple[Value, ...]] = [
        (outcomes[key].row.title, *gap, gap.verdict) for key, gap in found.items()
    ]
    note = (
        f"Held distance, paired by target within a person; {LEVEL:.0%} bootstrap intervals, targets"
        " drawn again within each person. The best row was chosen on the same reaches, among those"
        " without constants tuned in view of them."
    )
    title = f"{_title(outcomes)}: best row ({best.row.title}) against the others"
    return Table(
        title,
        columns,
        rows,
        [note, verdict(outcomes, found), *said_of_tuned(outcomes), bells_and_ends(best, one_peak)],
    )


def targets_table(outcomes: Outcomes) -> Table:
    """Held distance and movement time of every row at every target of every person."""
    columns = (
        Column("who", "who"),
        Column("target", "target"),
        _ROW,
        Column("reaches", "reaches", ".0f"),
        centimetres("held", "held"),
        centimetres("held_time_given", "time given"),
        Column("log_time_ratio", "ln time ratio", "+.2f"),
    )
    rows: list[tuple[Value, ...]] = []
    for outcome in outcomes.values():
        people = outcome.people
        for subject in people.subjects:
            for place in people.places_of(subject):
                at = people.of(subject, place)
                means = [outcome.of(key)[at].mean() for key in ("held", "held_given", "log_time")]
                row = (subject, place, outcome.row.title, len(at))
                rows.append((*row, *(_finite(float(mean)) for mean in means)))
    return Table(f"{_title(outcomes)}: every target", columns, rows)


def times_table(groups: Sequence[Outcomes]) -> Table:
    """Milliseconds a predicted reach on this machine."""
    columns = (
        Column("who", "who"),
        _ROW,
        Column("seconds", "ms a reach", ".3f", 1e3),
    )
    rows: list[tuple[Value, ...]] = [
        (_title(outcomes), outcome.row.title, outcome.seconds)
        for outcomes in groups
        for outcome in outcomes.values()
    ]
    note = "Prediction only, all reaches of a fold at once; other work may have run beside it."
    return Table("Time to predict a reach", columns, rows, [note])


def _title(outcomes: Outcomes) -> str:
    first = next(iter(outcomes.values()))
    return f"{first.people.title}: {TITLES[first.protocol]}"


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
