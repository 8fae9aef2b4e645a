"""Superposed stick figures of one reach: stills and animations."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from armsyn.errors import InputError
from armsyn.experiments.learned import FloatArray, Progress
from armsyn.experiments.pictures import CAPTURED, RAW, SYNERGY, figure, save

FRAMES_PER_SECOND = 25
HOLD_S = 0.6
_STYLES = ((CAPTURED, "-", 6.0), (RAW, ":", 2.0), (SYNERGY, "-", 2.5))
_LABELS = ("captured", "$S_A$", "$S_C$")
# Beside a right shoulder at the origin: neck, and down the back; for orientation only
_TRUNK = np.array([[0.0, 0.0, 0.0], [0.0, 0.18, 0.03], [0.0, 0.18, -0.5]])


class Figures(NamedTuple):
    """One reach three times.

    Attributes
    ----------
    name : str
        Of the reach.
    time : array, shape (frames,)
        s.
    captured, raw, synergy : array, shape (frames, landmarks, 3)
        m; shoulder first, hand last.
    """

    name: str
    time: FloatArray
    captured: FloatArray
    raw: FloatArray
    synergy: FloatArray

    @property
    def motions(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Captured, S_A, S_C."""
        return self.captured, self.raw, self.synergy


def draw_stills(figures: Figures, moments: Sequence[float], folder: Path, name: str) -> str:
    """Draw the figures side by side at some moments.

    Parameters
    ----------
    figures : Figures
    moments : sequence of float
        Shares of the reach's duration.
    folder : Path
    name : str
        Of the file, without suffix.

    Returns
    -------
    str
        The file's name.

    Raises
    ------
    InputError
        When it cannot be written.
    """
    drawn = figure(3.2 * len(moments), 4.0)
    drawn.suptitle(f"{figures.name}: captured (grey), $S_A$ (dotted), $S_C$ (blue)")
    for place, moment in enumerate(moments):
        axes = drawn.add_subplot(1, len(moments), place + 1, projection="3d")
        _draw(axes, figures, round(moment * (figures.time.size - 1)))
    return save(drawn, folder, f"{name}.png")


def animate(figures: Figures, folder: Path, name: str, on_progress: Progress) -> list[str]:
    """Animate the figures in real time, and hold the last posture for a moment.

    Parameters
    ----------
    figures : Figures
    folder : Path
    name : str
        Of the files, without suffix.
    on_progress : callable

    Returns
    -------
    list of str
        ``NAME.gif``, and ``NAME.mp4`` where ffmpeg is installed.

    Raises
    ------
    InputError
        When they cannot be written.
    """
    from matplotlib.animation import FFMpegWriter, PillowWriter  # noqa: PLC0415  heavy

    kinds: dict[str, type[PillowWriter] | type[FFMpegWriter]] = {"gif": PillowWriter}
    if FFMpegWriter.isAvailable():
        kinds["mp4"] = FFMpegWriter
    return [
        _film(kind(fps=FRAMES_PER_SECOND), figures, folder, f"{name}.{suffix}", on_progress)
        for suffix, kind in kinds.items()
    ]


def shown_frames(time: FloatArray) -> list[int]:
    """Return which of a motion's frames an animation in real time shows.

    Parameters
    ----------
    time : array, shape (frames,)
        s.

    Returns
    -------
    list of int
        The last one several times.
    """
    moments = np.arange(0.0, time[-1] + HOLD_S, 1.0 / FRAMES_PER_SECOND)
    frames = np.searchsorted(time, moments - 1e-9)
    return [int(frame) for frame in np.minimum(frames, time.size - 1)]


def _film(writer: Any, figures: Figures, folder: Path, file: str, on_progress: Progress) -> str:
    drawn = figure(4.6, 4.8)
    axes = drawn.add_subplot(projection="3d")
    frames = shown_frames(figures.time)
    try:
        # The writers choose the format by the name's suffix, so the name must be the right one
        with tempfile.TemporaryDirectory(dir=folder, prefix=".film.") as beside:
            temporary = Path(beside) / file
            with writer.saving(drawn, str(temporary), dpi=80):
                for number, frame in enumerate(frames):
                    axes.clear()
                    _draw(axes, figures, frame)
                    axes.legend(loc="upper right")
                    writer.grab_frame()
                    on_progress(file, number + 1, len(frames), "")
            temporary.replace(folder / file)
    except OSError as error:
        raise InputError(f"{folder / file}: cannot write it: {error.strerror or error}") from error
    return file


def _draw(axes: Any, figures: Figures, frame: int) -> None:
    axes.plot(*_TRUNK.T, "--", color="0.85", linewidth=2)
    for motion, (colour, dash, width), label in zip(figures.motions, _STYLES, _LABELS, strict=True):
        axes.plot(*motion[frame].T, dash, color=colour, linewidth=width, marker="o", label=label)
        axes.plot(*motion[: frame + 1, -1].T, "-", color=colour, linewidth=0.8)
    axes.plot(*figures.captured[-1, -1, :, None], "x", color="C3", markersize=8)
    points = np.concatenate([_TRUNK, figures.captured.reshape(-1, 3)])
    middle, half = _cube(points)
    for set_limits, centre in zip(
        (axes.set_xlim, axes.set_ylim, axes.set_zlim), middle, strict=True
    ):
        set_limits(centre - half, centre + half)
    axes.set_box_aspect((1, 1, 1), zoom=1.15)
    axes.view_init(elev=15, azim=-60)
    axes.set(xticklabels=[], yticklabels=[], zticklabels=[])
    axes.set_title(f"{figures.time[frame]:.2f} s")


def _cube(points: FloatArray) -> tuple[FloatArray, float]:
    """Centre and half the side of a cube around points, so that no axis is stretched."""
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2, float((high - low).max()) / 2
