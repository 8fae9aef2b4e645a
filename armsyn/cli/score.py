"""`armsyn score`: compare a motion with a captured one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.measuring import measuring_options
from armsyn.cli.motion_sources import load_motion

if TYPE_CHECKING:
    from armsyn.motion import Motion
    from armsyn.motion.base_transform import BaseTransform
    from armsyn.scoring.bands import Bands
    from armsyn.scoring.joint_map import JointMap
    from armsyn.scoring.score import Score

_FILE = click.Path(dir_okay=False, path_type=Path)


@click.command()
@click.argument("captured", metavar="A")
@click.argument("other", metavar="B")
@click.option("--bands", type=_FILE, help="Place both in these bands, of `armsyn bands`.")
@click.option(
    "--movement",
    type=click.IntRange(min=1),
    help="Which movement of B, in time's order  [default: the fastest]",
)
@click.option(
    "--movement-a",
    type=click.IntRange(min=1),
    help="Which movement of A  [default: the fastest]",
)
@click.option(
    "--align",
    nargs=2,
    metavar="POSES_A POSES_B",
    help="Bring B to A's base by one transform, fitted to the same calibration poses in both.",
)
@click.option(
    "--map",
    "joint_map",
    multiple=True,
    metavar="A=B",
    help="Compare A's landmark with B's of another name; once for each, the hand last.",
)
@click.option(
    "--segments",
    type=click.Choice(["rebuilt", "given"]),
    default="rebuilt",
    show_default=True,
    help="B's segments of another length on A's lengths, or as they are.",
)
@measuring_options
@click.option("--html", type=_FILE, help="Write one page: motions to turn, and all figures.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def score(**options: Any) -> None:
    """Score motion B against the captured (or reference) motion A.

    Each is a file (a recording of `armsyn reach --record`, .csv, .npz, .c3d, .bvh, ...;
    FILE#TAKE for one of several) or one captured reach, such as garza:ForwardHigh or
    hug_mp:S01:1.1.1:R-1. Both need landmark positions; the last one is the hand.

    The held distance is the headline. Where A is a captured reach whose person repeated it, it is
    also set over the human floor, what the person's other repeats predict of it.
    """
    from armsyn.scoring.joint_map import checked_joint_map
    from armsyn.scoring.score import Settings, score_as_dict, score_motions

    joint_map = checked_joint_map(options["joint_map"])
    captured, other = load_motion(options["captured"]), load_motion(options["other"])
    settings = Settings(
        cutoff=options["cutoff"],
        fraction=options["cut"],
        rebuild=options["segments"] == "rebuilt",
        transform=_transform(options, joint_map, (captured[1], other[1])),
        joint_map=joint_map,
        captured_movement=options["movement_a"],
        movement=options["movement"],
        bands=_bands(options["bands"]),
    )
    found = score_motions(captured, other, settings)
    if options["html"] is not None:
        from armsyn.scoring.page import write_page

        write_page(options["html"], found)
    if options["as_json"]:
        import json

        click.echo(json.dumps(score_as_dict(found), indent=2, allow_nan=False))
        return
    _print(found)
    if options["html"] is not None:
        click.echo(f"page: {options['html']}")


def _bands(path: Path | None) -> Bands | None:
    from armsyn.scoring.bands_file import load_bands

    return None if path is None else load_bands(path)


def _transform(
    options: dict[str, Any], joint_map: JointMap, scored: tuple[Motion, Motion]
) -> BaseTransform | None:
    if options["align"] is None:
        return None
    from armsyn.motion.base_transform import check_poses, fit_base_transform
    from armsyn.scoring.joint_map import mapped

    (_, poses), (_, other_poses) = (load_motion(text) for text in options["align"])
    check_poses((poses, other_poses), scored)
    return fit_base_transform(
        mapped(poses, joint_map, other=False), mapped(other_poses, joint_map, other=True)
    )


def _print(found: Score) -> None:
    from rich.console import Console

    from armsyn.scoring.report import alignment, segments
    from armsyn.scoring.tables import distance_table, likeness_table

    comparison = found.comparison
    console = Console()

    def say(text: str) -> None:
        console.print(text, highlight=False, markup=False)

    say(f"A {found.captured_name}: {comparison.captured_source}")
    say(f"B {found.other_name}: {comparison.other_source}")
    console.print(distance_table(comparison), likeness_table(found))
    for label, profile, which, option in (
        ("A", comparison.captured_profile, found.captured_movement, "--movement-a"),
        ("B", comparison.other_profile, found.other_movement, "--movement"),
    ):
        several = f", movement {which.number} of {which.of}: {option} N picks another"
        say(
            f"{label}: moves from {profile.onset:.2f} to {profile.offset:.2f} s"
            + (several if which.of > 1 else "")
        )
    pairs = zip(comparison.landmarks, comparison.other_landmarks, strict=True)
    say("landmarks: " + ", ".join(a if a == b else f"{a} (B: {b})" for a, b in pairs))
    say(f"segments: {segments(comparison)}; alignment: {alignment(comparison)}")
    if comparison.left_out:
        say(f"landmarks in only one of them: {', '.join(comparison.left_out)}")
