"""What every chunk of `armsyn generate` says of a reach, whatever its format."""

from __future__ import annotations

from armsyn.motion.formats.episodes import Episode
from armsyn.motion.formats.options import Reading
from armsyn.motion.motion import Motion

Target = tuple[float, float, float]


def source_of(reach: str, arm: str) -> str:
    """Return where the motion of a reach comes from, for people.

    Parameters
    ----------
    reach : str
        Its index.
    arm : str
        The arm's name.
    """
    return f"reach {reach}, planned for {arm}"


def episode_of(
    motion: Motion,
    reach: str,
    *,
    arm: str,
    task: str,
    target: Target | None,
    evened: float = 0.0,
    swivel_m: float = 0.0,
) -> Episode:
    """Return a reach with what is known of it.

    Parameters
    ----------
    motion : Motion
        Of its source, see `source_of`.
    reach : str
        Its index.
    arm : str
        The arm's name; empty where a chunk of an older version does not say.
    task : str
        What it does, in words; empty likewise.
    target : 3-tuple of float or None
        Where it was to end, base frame, m.
    evened : float
        How much nearer it was brought to minimum jerk of every joint, 0 to 1.
    swivel_m : float
        By how much the elbow ends elsewhere than predicted, m.

    Returns
    -------
    Episode

    Raises
    ------
    FormatError
        When the target is not finite.
    """
    facts = {"arm": arm, "reach": reach} if arm else {"reach": reach}
    if evened or swivel_m:
        facts |= {"evened": f"{evened:g}", "swivel_m": f"{swivel_m:.4f}"}
    return Episode(motion, "planned", task, facts=facts, target=target)


def reading_of(episode: Episode) -> Reading:
    """Return a reach as its reader gives it, with what the chunk says of it."""
    said = {"reach": episode.facts["reach"], "kind": episode.kind}
    said |= {"arm": episode.facts.get("arm", ""), "task": episode.task}
    facts = {name: value for name, value in said.items() if value}
    return Reading(episode.motion, facts, episode=episode)
