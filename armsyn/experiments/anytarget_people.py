"""Who is predicted in the experiment `anytarget`, and from which of their reaches."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from armsyn.arm import load_arm
from armsyn.motion import FloatArray, Motion
from armsyn.motion.captures import load_captures
from armsyn.motion.resample import interpolate
from armsyn.motion.retargeting import retarget
from armsyn.planning.examples import PHASE, Examples, examples_of_people, examples_on_arm
from armsyn.scoring.human_likeness import How, relative_speed
from armsyn.scoring.repeats import HUG_MP

RATE_HZ = 100.0
"""Least rate of predicted motions."""
Protocol = Literal["target", "subject"]
Rows = tuple[int, ...]


@dataclass(frozen=True, eq=False)
class People:
    """Captured reaches of one or several persons on one chain.

    Parameters
    ----------
    title : str
    examples : Examples
        Every reach, over normalised time from its first captured frame to its last.
    captured : tuple of Motion
        The same reaches as cut, with landmarks: what predictions are scored against.
    rows : tuple of int
        Which of the chain's positions the landmarks are, the hand (-1) last.
    teachers : Examples or None
        Other persons' reaches on the same chain, to learn from where persons are left out.
    arm : str or None
        Name of the arm whose chain it is, where what it would drive is to be scored.
    """

    title: str
    examples: Examples
    captured: tuple[Motion, ...]
    rows: tuple[int, ...]
    teachers: Examples | None = None
    arm: str | None = None

    @cached_property
    def subjects(self) -> list[str]:
        """Everybody once."""
        return list(dict.fromkeys(self.examples.subjects))

    @cached_property
    def lessons(self) -> Examples:
        """Everything that may be learned from: the reaches themselves, then the teachers'."""
        return self.examples if self.teachers is None else joined([self.examples, self.teachers])

    @cached_property
    def profiles(self) -> dict[str, FloatArray]:
        """Mean speed profile of each person, over its mean, shape (101,)."""
        return {
            subject: np.mean(
                [relative_speed(self.captured[row], How()) for row in self.of(subject)], axis=0
            )
            for subject in self.subjects
        }

    def of(self, subject: str, place: str | None = None) -> list[int]:
        """Rows of a person's reaches, all or those to one target."""
        examples = self.examples
        return [
            row
            for row, (who, where) in enumerate(zip(examples.subjects, examples.places, strict=True))
            if who == subject and place in (None, where)
        ]

    def places_of(self, subject: str) -> list[str]:
        """A person's targets, once each."""
        return list(dict.fromkeys(self.examples.places[row] for row in self.of(subject)))

    def only(self, tests: Rows, train: Rows) -> People:
        """Return the reaches to be predicted, then those to learn from, without their motions."""
        examples = self.lessons.only([*tests, *train])
        return People(self.title, examples, tuple(self.captured[row] for row in tests), self.rows)

    def motion(self, row: int, angles: FloatArray, duration: float) -> Motion:
        """Turn a prediction of a reach into a motion with the captured one's landmarks and rate.

        Parameters
        ----------
        row : int
            The captured reach that it is to be set beside.
        angles : array, shape (101, n)
            Over normalised time.
        duration : float
            s.

        Returns
        -------
        Motion
        """
        captured = self.captured[row]
        frames = round(duration * max(captured.rate, RATE_HZ))
        time = np.linspace(0.0, duration, max(frames, 1) + 1)
        path = interpolate(PHASE * duration, angles, time)
        return Motion(
            time=time,
            landmark_names=captured.landmark_names,
            landmarks=self.examples.chain.positions(path)[:, list(self.rows)],
            source=f"predicted for {captured.source}",
        )


class Fold(NamedTuple):
    """Reaches that are predicted by what was learned from others."""

    subject: str
    tests: Rows
    train: Rows


def folds(people: People, protocol: Protocol) -> list[Fold]:
    """Leave out each target of each person, or each person.

    Parameters
    ----------
    people : People
    protocol : {"target", "subject"}
        target: a person's reaches to one target are predicted by the same person's to all others.
        subject: all of a person's reaches, by everybody else's.

    Returns
    -------
    list of Fold
    """
    found = []
    for subject in people.subjects:
        own = people.of(subject)
        if protocol == "subject":
            others = set(range(people.lessons.size)) - set(own)
            found.append(Fold(subject, tuple(own), tuple(sorted(others))))
            continue
        for place in people.places_of(subject):
            tests = people.of(subject, place)
            found.append(Fold(subject, tuple(tests), tuple(row for row in own if row not in tests)))
    return found


def load_hug_mp(subjects: Sequence[str], at_most: int | None = None) -> People:
    """Load the seated reaches from rest, as they were cut.

    Parameters
    ----------
    subjects : sequence of str
        Such as S01.
    at_most : int or None
        Only so many to each target, the first of the table.

    Returns
    -------
    People

    Raises
    ------
    CaptureError, FormatError
        Captures that are not there, or damaged.
    """
    each = [examples_of_people(subject, "segment") for subject in subjects]
    captured = {
        capture.name: capture.motion
        for subject in subjects
        for capture in load_captures(f"hug_mp:{subject}:all")
    }
    everything = joined(each)
    kept = everything.only(_first_of_each(everything, at_most))
    motions = tuple(captured[name] for name in kept.names)
    return People("HuG-MP", kept, motions, HUG_MP.rows)


def load_garza(at_most: int | None = None) -> People:
    """Load the free reaches, put on the human-like arm of seven joints by their landmarks.

    Parameters
    ----------
    at_most : int or None
        Only so many reaches, the first of the table.

    Returns
    -------
    People
        The captured motions are the landmarks as laid on the arm's own links.

    Raises
    ------
    CaptureError, FormatError, DescriptionError
        Captures that are not there, or a damaged capture or description.
    """
    return dataclasses.replace(_on_arm("human7", at_most), arm="human7")


def _on_arm(name: str, at_most: int | None) -> People:
    arm = load_arm(name, calibrated=False)
    captures = load_captures("garza")[:at_most]
    examples = examples_on_arm(arm, captures, "segment")
    motions = tuple(retarget(capture.motion, arm) for capture in captures)
    return People("garza", examples, motions, arm.landmark_frames)


def load_garza_taught(teachers: Examples, at_most: int | None = None) -> People:
    """Load the free reaches on the arm of four joints, to be predicted by what its people do.

    Parameters
    ----------
    teachers : Examples
        Of HuG-MP.
    at_most : int or None
        Only so many reaches, the first of the table.

    Returns
    -------
    People

    Raises
    ------
    CaptureError, FormatError, DescriptionError
        As `load_garza`.
    """
    return dataclasses.replace(
        _on_arm("hug_mp4", at_most), title="garza, 4 joints", teachers=teachers
    )


def joined(parts: Sequence[Examples]) -> Examples:
    """Return the examples of several persons on one chain, one after another."""
    return Examples(
        parts[0].chain,
        names=tuple(name for part in parts for name in part.names),
        subjects=tuple(subject for part in parts for subject in part.subjects),
        places=tuple(place for part in parts for place in part.places),
        angles=np.concatenate([part.angles for part in parts]),
        durations=np.concatenate([part.durations for part in parts]),
        targets=np.concatenate([part.targets for part in parts]),
    )


def _first_of_each(examples: Examples, at_most: int | None) -> list[int]:
    """Rows of the first so many reaches of each person to each target."""
    owners = list(zip(examples.subjects, examples.places, strict=True))
    return [
        row
        for row, owner in enumerate(owners)
        if at_most is None or owners[:row].count(owner) < at_most
    ]
