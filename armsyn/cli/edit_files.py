"""What `armsyn edit apply` writes and says."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from armsyn.arm import ArmDescription
    from armsyn.editing import EditResult, MotionModel
    from armsyn.editing.report import Scored
    from armsyn.motion.body import BodyMotion


def check_outputs(options: dict[str, Any]) -> None:
    """Refuse places that cannot be written, before anything is solved.

    Raises
    ------
    InputError
    """
    from armsyn.cli.learn_plot import checked_plot
    from armsyn.errors import InputError

    if options["plot"] is not None:
        checked_plot(options["plot"])
    given = [options[key] for key in ("out", "latent", "page", "plot") if options[key] is not None]
    if len({path.resolve() for path in given}) < len(given):
        raise InputError("--out, --latent, --report and --plot need files of their own")
    check_places(given, [options["clip"], options["model_path"], options["scene"]])


def check_places(outputs: list[Path], inputs: Iterable[Path | str | None]) -> None:
    """Refuse outputs that cannot be written, or would replace what is read.

    Raises
    ------
    InputError
    """
    from armsyn.errors import InputError
    from armsyn.motion.formats import split_take

    read = {split_take(str(path))[0].resolve() for path in inputs if path is not None}
    for path in outputs:
        if not path.parent.is_dir():
            raise InputError(f"{path}: no folder {path.parent}")
        if path.resolve() in read:
            raise InputError(f"{path}: is read by this command: write to another file")
        try:
            with tempfile.TemporaryFile(dir=path.parent):
                pass
        except OSError as error:
            raise InputError(f"{path}: cannot write it: {error.strerror or error}") from error


def check_suffix(out: Path, arm: ArmDescription | None) -> None:
    """Refuse a format that a body's or an arm's clip is not written as.

    Raises
    ------
    InputError
    """
    from armsyn.errors import InputError

    known = (".bvh", ".npz", ".csv") if arm is None else (".npz", ".csv")
    if out.suffix.lower() not in known:
        raise InputError(f"{out}: an edited clip of this kind is written as {', '.join(known)}")


def write(
    result: EditResult,
    model: MotionModel,
    scored: Scored,
    bound: float,
    notes: list[str],
    options: dict[str, Any],
) -> None:
    """Write the edited clip and what else is asked for.

    Parameters
    ----------
    result : EditResult
    model : MotionModel
    scored : Scored
    bound : float
        Standard deviations beyond which an edit is refused unless forced.
    notes : list of str
        What the safety's check found; what else is to be said is added.
    options : dict
        Of the command.

    Raises
    ------
    InputError
        When a file cannot be written.
    """
    import json

    from armsyn.editing.page import write_page
    from armsyn.editing.pictures import save_picture
    from armsyn.editing.report import latent_as_dict
    from armsyn.motion.body import BodyMotion
    from armsyn.motion.formats import write_body, write_motion
    from armsyn.motion.formats.files import replacing

    out, clip = options["out"], result.clip
    if isinstance(clip, BodyMotion) and out.suffix.lower() != ".csv":
        write_body(out, _as_written(clip, result, out, notes))
    else:
        write_motion(out, clip.as_motion() if isinstance(clip, BodyMotion) else clip)
    if options["latent"] is not None:
        text = json.dumps(latent_as_dict(result, model), indent=1, allow_nan=False)
        with replacing(options["latent"]) as temporary:
            temporary.write_text(text + "\n", encoding="utf-8")
    if options["page"] is not None:
        write_page(options["page"], result, scored, bound, notes)
    if options["plot"] is not None:
        save_picture(options["plot"], result, bound)


def _as_written(clip: BodyMotion, result: EditResult, out: Path, notes: list[str]) -> BodyMotion:
    """A clip as its format takes it: BVH has one frame time."""
    from armsyn.editing import SkeletonFigure
    from armsyn.editing.sampling import evenly_sampled

    if out.suffix.lower() != ".bvh":
        return clip
    assert isinstance(result.figure, SkeletonFigure)  # noqa: S101 - of a body
    even = evenly_sampled(clip, result.figure)
    if even is not clip:
        notes.append(f"BVH has one frame time: {clip.frames} frames became {even.frames} even ones")
    return even


def tell(
    result: EditResult, scored: Scored, bound: float, notes: list[str], options: dict[str, Any]
) -> None:
    """Print an edit's figures, for people or as JSON; what to look at on standard error, too."""
    from armsyn.editing.cautions import edit_cautions
    from armsyn.editing.report import edit_as_dict, figure_rows

    cautions = edit_cautions(result, bound)
    for caution in cautions:
        click.echo(f"look: {caution}", err=True)
    written = {key: options[key] for key in ("out", "latent", "page", "plot")}
    if options["as_json"]:
        import json

        files = {key: None if path is None else str(path) for key, path in written.items()}
        said = {"cautions": cautions, "notes": notes, "files": files}
        document = edit_as_dict(result, scored) | said
        click.echo(json.dumps(document, indent=2, allow_nan=False))
        return
    for what, value in figure_rows(result):
        click.echo(f"{what}: {value}")
    if scored.score is None:
        click.echo(f"after against before: no score: {scored.refusal}")
    else:
        distance = 100 * scored.score.comparison.held_distance
        click.echo(f"after against before: held distance {distance:.2f} cm")
    for note in notes:
        click.echo(note)
    for path in filter(None, written.values()):
        click.echo(f"wrote {path}")
