"""`armsyn motion segment`: the movements that motions hold, and which are usable reaches."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.choices import FiniteRange
from armsyn.cli.measuring import cutoff_option
from armsyn.cli.motion_options import reading_options

if TYPE_CHECKING:
    from rich.table import Table

    from armsyn.cli.motion_takes import Take
    from armsyn.motion import Motion
    from armsyn.motion.movements import Movement


@click.command()
@click.argument("source", metavar="FILE|SET")
@click.option(
    "--threshold",
    type=FiniteRange(0, 1, max_open=True),
    default=0.05,
    show_default=True,
    help="Share of a movement's peak speed at which it begins and ends.",
)
@click.option(
    "--landmark",
    metavar="NAME[+NAME]",
    help="Whose speed counts; A+B is the middle of both.  [default: hand, or a recording's last]",
)
@cutoff_option
@click.option("--least", type=float, default=0.25, show_default=True, help="m, that a reach spans.")
@click.option(
    "--peaks",
    type=click.IntRange(min=1),
    default=2,
    show_default=True,
    help="Most speed peaks of a reach that stand out by a tenth of the highest.",
)
@reading_options
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="FOLDER",
    help="Write every usable reach there as an .npz file.",
)
@click.option(
    "--plot", type=click.Path(path_type=Path, dir_okay=False), help="Plot speeds and movements."
)
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def segment(source: str, **options: Any) -> None:
    """Find the movements in motions, and say which are usable reaches.

    All takes of FILE are searched (FILE#TAKE or --take NAME: one), or a SET of captures, such as
    garza:all.

    A movement begins and ends where the hand's filtered speed crosses --threshold of that
    movement's peak; two are parted by a rest of 0.15 s, or where the hand turns back. What moves
    the hand by less than a tenth of the longest movement's path is none.

    A movement is a usable reach when it spans --least metres, has no more than --peaks speed peaks,
    begins below 0.25 and ends below 0.15 of its peak speed, and no landmark has a gap in it; else
    the reason stands beside it. Frames count from 0: the last at or before the onset, the first at
    or after the offset.
    """
    from armsyn.cli.motion_takes import all_takes
    from armsyn.errors import InputError
    from armsyn.motion.movements import ReachRule, find_movements
    from armsyn.motion.points import hand_of, position_of

    rule = ReachRule(displacement=options["least"], peaks=options["peaks"])
    several = sum(1 for _ in all_takes(source, options)) if options["plot"] is not None else 1
    if several > 1:
        raise InputError(f"{source}: {several} motions in it; --plot shows one: name it")
    rows: list[_Row] = []
    hands = set[str]()
    for take in all_takes(source, options):
        motion = _with_point(take, options["landmark"])
        hand = options["landmark"] or hand_of(motion, hand_last=take.hand_last)
        hands.add(hand)
        positions = position_of(motion, hand)
        found = find_movements(
            motion.time,
            positions,
            fraction=options["threshold"],
            cutoff=options["cutoff"],
        )
        ended = None if options["out"] is None else _ending_with(motion, hand)
        for number, movement in enumerate(found, 1):
            fault = rule.fault(movement, motion)
            usable = None if fault else ended
            cut = usable and usable.between(movement.first, movement.last)
            rows.append(_Row(take.name, number, movement, fault, cut))
    if options["plot"] is not None:
        from armsyn.cli.motion_segment_plot import plot_movements

        named = [(row.movement, row.fault) for row in rows]
        plot_movements(options["plot"], source, motion.time, positions, named, options)
    written = _write(options["out"], rows)
    _report(source, rows, options, hands, written)


def _with_point(take: Take, point: str | None) -> Motion:
    """Return the motion, or its skeleton's joints where a point is one of theirs."""
    if point is None or take.body is None:
        return take.motion
    names = take.body.skeleton.names
    of_body = {name.strip() for name in point.split("+")} <= set(names)
    return take.body.as_motion() if of_body and names != take.motion.landmark_names else take.motion


def _ending_with(motion: Motion, hand: str) -> Motion:
    """Return the motion with the hand as its last landmark, as who reads the file takes it."""
    import dataclasses

    import numpy as np

    from armsyn.motion.points import position_of

    names = motion.landmark_names
    if hand == names[-1] or motion.landmarks is None:
        return motion
    own = [hand] if hand in names else [name.strip() for name in hand.split("+")]
    kept = [column for column, name in enumerate(names) if name != hand]
    landmarks = [motion.landmarks[:, kept], position_of(motion, hand)[:, None]]
    filled = motion.filled
    if filled is not None:
        of_hand = filled[:, [names.index(name) for name in own]].any(axis=1, keepdims=True)
        filled = np.concatenate([filled[:, kept], of_hand], axis=1)
    return dataclasses.replace(
        motion,
        landmark_names=(*(names[column] for column in kept), hand),
        landmarks=np.concatenate(landmarks, axis=1),
        filled=filled,
    )


class _Row:
    """A movement as it is reported."""

    def __init__(
        self, name: str, number: int, movement: Movement, fault: str, cut: Motion | None
    ) -> None:
        self.name, self.number, self.movement, self.fault = name, number, movement, fault
        self.cut = cut  # what is written of it

    def as_dict(self) -> dict[str, Any]:
        one = self.movement
        return {
            **{"motion": self.name, "number": self.number},
            **{"onset_s": one.onset, "offset_s": one.offset, "duration_s": one.duration},
            **{"first_frame": one.first, "last_frame": one.last},
            **{"displacement_m": one.displacement, "path_m": one.path},
            **{"peak_speed_m_s": one.peak_speed, "time_to_peak": one.time_to_peak},
            **{"speed_peaks": one.peaks, "prominent_peaks": one.prominent_peaks},
            **{"onset_speed_fraction": one.onset_fraction},
            **{"offset_speed_fraction": one.offset_fraction},
            **{"usable": not self.fault, "reason": self.fault or None},
        }


def _write(folder: Path | None, rows: list[_Row]) -> list[str]:
    if folder is None:
        return []
    from armsyn.errors import InputError
    from armsyn.motion.formats import write_motion

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot make the folder: {error.strerror}") from error
    written = []
    names = _file_names(rows)
    for row in rows:
        if row.cut is not None:
            path = folder / f"{names[row.name]}-{row.number}.npz"
            write_motion(path, row.cut)
            written.append(str(path))
    return written


def _file_names(rows: list[_Row]) -> dict[str, str]:
    """Return a file's name of each take; takes that would have the same are numbered."""
    found: dict[str, str] = {}
    taken = set[str]()
    for name in dict.fromkeys(row.name for row in rows):
        plain, again = _file_name(name), 1
        found[name] = plain
        while found[name].casefold() in taken:
            again += 1
            found[name] = f"{plain}-{again}"
        taken.add(found[name].casefold())
    return found


def _file_name(name: str) -> str:
    """Of a take or a selection, without what a path could stumble over."""
    last = name.rsplit("/", maxsplit=1)[-1]
    return "".join(letter if letter.isalnum() or letter in "._-" else "-" for letter in last)


def _report(
    source: str, rows: list[_Row], options: dict[str, Any], hands: set[str], written: list[str]
) -> None:
    usable = sum(not row.fault for row in rows)
    if options["as_json"]:
        import json

        document = {
            "source": source,
            "landmark": sorted(hands),
            "threshold": options["threshold"],
            "cutoff_hz": options["cutoff"],
            "movements": [row.as_dict() for row in rows],
            "usable": usable,
            "written": written,
        }
        click.echo(json.dumps(document, indent=2, allow_nan=False))
        return
    from rich.console import Console

    # A file or a pipe has no width: let no name be folded there
    console = Console() if Console().is_terminal else Console(width=160)
    console.print(_table(rows))
    for row in rows:
        if row.fault:
            text = f"{_short(row.name)} movement {row.number} is not usable: {row.fault}"
            console.print(text, highlight=False, markup=False, soft_wrap=True)
    cutoff = "unfiltered" if options["cutoff"] is None else f"low-pass {options['cutoff']:g} Hz"
    console.print(
        f"{usable} of {len(rows)} movements are usable reaches; speed of"
        f" {', '.join(sorted(hands))}, {cutoff}, cut at {options['threshold']:g} of each peak",
        highlight=False,
        markup=False,
        soft_wrap=True,
    )
    if written:
        console.print(f"wrote {len(written)} files to {options['out']}", highlight=False)


def _short(name: str) -> str:
    """Of a take its own name: the file's is known to who named it."""
    return name.rsplit("/", maxsplit=1)[-1].rsplit("#", maxsplit=1)[-1]


def _table(rows: list[_Row]) -> Table:
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    several = len({row.name for row in rows}) > 1
    if several:
        table.add_column("motion", overflow="fold")
    for head in ("#", "frames", "from s", "to s", "span m", "peak m/s", "at", "peaks", "usable"):
        table.add_column(head, justify="right", no_wrap=True)
    for row in rows:
        one = row.movement
        cells = [_short(row.name)] if several else []
        table.add_row(
            *cells,
            *(str(row.number), f"{one.first}-{one.last}", f"{one.onset:.2f}", f"{one.offset:.2f}"),
            *(f"{one.displacement:.3f}", f"{one.peak_speed:.2f}", f"{one.time_to_peak:.2f}"),
            *(str(one.peaks), "no" if row.fault else "yes"),
        )
    return table
