"""Small vector pictures of speeds and bands, for a page."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from armsyn.motion import FloatArray
from armsyn.motion.filtering import hand_speed
from armsyn.scoring.bands import Band
from armsyn.scoring.human_likeness import relative_speed
from armsyn.scoring.measures import ProfileMeasures
from armsyn.scoring.profile import minimum_jerk_speed
from armsyn.scoring.score import Score

_WIDTH, _HEIGHT, _LEFT, _BOTTOM, _TOP = 520.0, 300.0, 44.0, 40.0, 12.0


class _Frame(NamedTuple):
    """Axes from the origin to a largest x and y."""

    x: float
    y: float

    def at(self, x: float, y: float) -> str:
        across = _LEFT + (_WIDTH - _LEFT - 10) * x / self.x
        down = _HEIGHT - _BOTTOM - (_HEIGHT - _BOTTOM - _TOP) * y / self.y
        return f"{across:.1f},{down:.1f}"

    def line(self, x: FloatArray, y: FloatArray, style: str) -> str:
        points = " ".join(self.at(*pair) for pair in zip(x.tolist(), y.tolist(), strict=True))
        return f'<polyline points="{points}" fill="none" {style}/>'

    def area(self, x: FloatArray, low: FloatArray, high: FloatArray) -> str:
        x, y = np.concatenate([x, x[::-1]]), np.concatenate([low, high[::-1]])
        points = " ".join(self.at(*pair) for pair in zip(x.tolist(), y.tolist(), strict=True))
        return f'<polygon points="{points}" fill="var(--band)"/>'

    def axes(self, x_label: str, y_label: str) -> str:
        parts = []
        for value in _ticks(self.x):
            x, y = self.at(value, 0).split(",")
            parts.append(f'<text x="{x}" y="{float(y) + 16}" text-anchor="middle">{value:g}</text>')
        for value in _ticks(self.y):
            x, y = self.at(0, value).split(",")
            right = self.at(self.x, value).split(",")[0]
            parts.append(f'<line x1="{x}" y1="{y}" x2="{right}" y2="{y}" stroke="#e5e5e5"/>')
            parts.append(
                f'<text x="{float(x) - 6}" y="{float(y) + 4}" text-anchor="end">{value:g}</text>'
            )
        parts.append(
            f'<text x="{_WIDTH / 2}" y="{_HEIGHT - 6}" text-anchor="middle">{x_label}</text>'
        )
        parts.append(
            f'<text transform="translate(12 {_HEIGHT / 2}) rotate(-90)" text-anchor="middle">'
            f"{y_label}</text>"
        )
        return "".join(parts)


def relative_speeds(score: Score) -> str:
    """Return both hands' speeds over their means, over normalised time, on the band.

    Parameters
    ----------
    score : Score

    Returns
    -------
    str
        A figure of HTML.
    """
    phase = np.linspace(0.0, 1.0, 101)
    captured, other = (relative_speed(m, score.how) for m in (score.captured, score.other))
    rows = [captured, other, *([] if score.bands is None else score.bands.speed)]
    frame = _Frame(1.0, 1.08 * max(float(row.max()) for row in rows))
    parts = [frame.axes("time, of movement time", "speed / mean speed")]
    caption = "dotted: minimum jerk"
    if score.bands is not None:
        low, median, high = score.bands.speed
        parts = [frame.area(phase, low, high), *parts]
        parts.append(frame.line(phase, median, 'stroke="#8793a3" stroke-width="1.5"'))
        caption = f"grey: median and 5-95 % of {score.bands.reaches} captures; {caption}"
    parts.append(
        frame.line(phase, minimum_jerk_speed(phase), 'stroke="#999" stroke-dasharray="1 4"')
    )
    parts.append(frame.line(phase, captured, 'stroke="var(--captured)" stroke-width="2.5"'))
    parts.append(frame.line(phase, other, 'stroke="var(--other)" stroke-width="2.5"'))
    return _figure(parts, f"Shape: {caption}")


def speeds_in_time(score: Score) -> str:
    """Return both hands' speeds from their onsets.

    Parameters
    ----------
    score : Score

    Returns
    -------
    str
        A figure of HTML.
    """
    comparison = score.comparison
    curves = []
    for motion, profile, colour in (
        (score.captured, comparison.captured_profile, "var(--captured)"),
        (score.other, comparison.other_profile, "var(--other)"),
    ):
        whole = hand_speed(motion.time, motion.hand, cutoff=profile.cutoff, rate=profile.rate)
        inside = _around(whole.time, profile)
        curves.append((whole.time[inside] - profile.onset, whole.speed[inside], colour))
    frame = _Frame(
        max(float(time[-1]) for time, _, _ in curves),
        1.08 * max(float(speed.max()) for _, speed, _ in curves),
    )
    parts = [frame.axes("time from onset, s", "hand speed, m/s")]
    parts += [
        frame.line(time, speed, f'stroke="{colour}" stroke-width="2.5"')
        for time, speed, colour in curves
    ]
    return _figure(parts, "As measured, from onset to offset")


def _around(time: FloatArray, profile: ProfileMeasures) -> np.ndarray:
    return np.asarray((time >= profile.onset - 1e-9) & (time <= profile.offset + 1e-9))


def _figure(parts: list[str], caption: str) -> str:
    return (
        f'<figure><svg viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}" role="img">{"".join(parts)}</svg>'
        f"<figcaption>{caption}</figcaption></figure>"
    )


def band_strip(band: Band, captured: float, other: float) -> str:
    """Return a strip with the band, its median and both values on it.

    Parameters
    ----------
    band : Band
    captured, other : float
        NaN for none.

    Returns
    -------
    str
        SVG.
    """
    values = [v for v in (band.low, band.high, captured, other) if math.isfinite(v)]
    low, high = min(values), max(values)
    span = high - low or 1.0

    def x(value: float) -> float:
        return 8 + 144 * (value - low) / span

    parts = [
        f'<rect x="{x(band.low):.1f}" y="6" height="10" fill="var(--band)"'
        f' width="{max(x(band.high) - x(band.low), 1):.1f}"/>',
        f'<line x1="{x(band.median):.1f}" x2="{x(band.median):.1f}" y1="4" y2="18" stroke="#667"/>',
    ]
    for value, colour in ((captured, "var(--captured)"), (other, "var(--other)")):
        if math.isfinite(value):
            parts.append(f'<circle cx="{x(value):.1f}" cy="11" r="4" fill="{colour}"/>')
    return f'<svg viewBox="0 0 160 22">{"".join(parts)}</svg>'


def _ticks(largest: float) -> list[float]:
    """Return round numbers from 0 to at most the largest, about five."""
    step = 10.0 ** math.floor(math.log10(largest / 4))
    step *= next(factor for factor in (1, 2, 5, 10) if largest / (step * factor) <= 6)
    return [round(step * count, 10) for count in range(int(largest / step + 1e-9) + 1)]
