"""Files of motions as the episodes of an export: recordings with what was commanded."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from armsyn.cli.motion_takes import Take, all_takes

if TYPE_CHECKING:
    from armsyn.motion import Motion
    from armsyn.motion.formats import Episode

_PLANNED = ("planned for ", "predicted for ")
"""How the source of a plan begins."""


def episodes_in(
    sources: Iterable[str],
    options: dict[str, Any],
    task: str,
    change: Callable[[Motion], Motion],
) -> Iterator[Episode]:
    """Give the motions of files or sets of captures as episodes, one by one.

    Parameters
    ----------
    sources : iterable of str
        FILE (all its motions), FILE#TAKE, or a selection of captures.
    options : dict
        With the values of `armsyn.cli.motion_options.reading_options`.
    task : str
        What the motions do, in words.
    change : callable
        Applied to every motion: gaps filled, resampled.

    Yields
    ------
    Episode

    Raises
    ------
    FormatError, CaptureError, InputError
        When one cannot be read so.
    """
    for source in sources:
        for take in all_takes(source, options):
            yield _episode(take, task, change)


def _episode(take: Take, task: str, change: Callable[[Motion], Motion]) -> Episode:
    from armsyn.motion.formats import Episode, split_take

    path, _ = split_take(take.name)
    motion, suffix = take.motion, path.suffix.lower()
    changed = change(motion)
    if take.episode is not None:
        return _with(take.episode, changed, task)
    if motion.angles is not None:
        if suffix == ".npz" and _is_recording(path):
            return _recorded(path, motion, changed, task)
        if suffix == ".csv":
            recorded = _recorded_in_csv(path, motion, changed, task)
            if recorded is not None:
                return recorded
    planned = motion.source.startswith(_PLANNED)
    return Episode(changed, "planned" if planned else "motion", task, facts=take.facts)


def _with(found: Episode, changed: Motion, task: str) -> Episode:
    """Return an episode with its motion changed, and all that stands beside it likewise."""
    import dataclasses

    motion = found.motion
    return dataclasses.replace(
        found,
        motion=changed,
        task=task or found.task,
        commanded=None if found.commanded is None else _at(motion, found.commanded, changed),
        velocity=None if found.velocity is None else _at(motion, found.velocity, changed),
        rate_hz=found.rate_hz if changed is motion else None,
    )


def _is_recording(path: Path) -> bool:
    from armsyn.motion.formats.archive import opened

    with opened(path) as archive:
        return "commanded_rad" in archive.keys


def _recorded(path: Path, motion: Motion, changed: Motion, task: str) -> Episode:
    import numpy as np

    from armsyn.driver.recording_load import load_recording
    from armsyn.motion.formats import Episode

    recording = load_recording(path)
    facts = {
        **{"arm": recording.arm, "port": recording.port},
        "simulated": "yes" if recording.simulated else "no",
        "ending": recording.ending.name.lower(),
        "description_sha256": recording.description_sha256,
        "driver_version": recording.driver_version,
    }
    observed = bool(np.isnan(recording.commanded_rad).all())
    return Episode(
        changed,
        "observed" if observed else "recorded",
        task,
        None if observed else _at(motion, recording.commanded_rad, changed),
        _at(motion, recording.velocity_rad_s, changed),
        facts,
        recording.rate_hz if changed is motion else None,
        recording.target_m,
    )


def _recorded_in_csv(path: Path, motion: Motion, changed: Motion, task: str) -> Episode | None:
    """Of a table, which has no facts but in its source; None when nothing was commanded in it."""
    import numpy as np

    from armsyn.driver.recording_load import read_commanded
    from armsyn.motion.formats import Episode

    commanded = read_commanded(path, motion.joint_names)
    if commanded is None or commanded.shape != (motion.frames, len(motion.joint_names)):
        return None
    if np.isnan(commanded).all():
        return Episode(changed, "observed", task)
    return Episode(changed, "recorded", task, _at(motion, commanded, changed))


def _at(motion: Motion, values: Any, changed: Motion) -> Any:
    """Values of a motion's frames at the times that it has been brought to."""
    from armsyn.motion.resample import interpolate

    return values if changed is motion else interpolate(motion.time, values, changed.time)
