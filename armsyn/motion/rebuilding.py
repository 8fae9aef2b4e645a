"""Landmarks on segments of other lengths: what is left to compare are the arms' directions.

A robot's segments rebuilt on human lengths leave nothing of the difference in build, where scaling
by the total length leaves that of their proportions.
"""

from __future__ import annotations

import numpy as np

from armsyn.errors import CaptureError, InputError
from armsyn.motion.motion import FloatArray


def segment_lengths(landmarks: FloatArray) -> FloatArray:
    """Return the distances from each landmark to the next.

    Parameters
    ----------
    landmarks : array, shape (frames, landmarks, 3)
        m, in the order of the chain.

    Returns
    -------
    array, shape (landmarks - 1,)
        m, the median over the frames.
    """
    return np.asarray(np.median(np.linalg.norm(np.diff(landmarks, axis=1), axis=2), axis=0))


def rebuild_segments(landmarks: FloatArray, lengths: FloatArray) -> FloatArray:
    """Keep every segment's direction, give it another length.

    Parameters
    ----------
    landmarks : array, shape (frames, landmarks, 3)
        m; the first landmark stays where it is.
    lengths : array, shape (landmarks - 1,)
        m; NaN for a segment that keeps its own in every frame.

    Returns
    -------
    array, shape (frames, landmarks, 3)
        m.

    Raises
    ------
    InputError
        When the lengths do not fit the landmarks.
    CaptureError
        When two landmarks coincide: there is no direction between them.
    """
    segments = np.diff(landmarks, axis=1)
    if lengths.shape != segments.shape[1:2]:
        raise InputError(f"{lengths.size} lengths do not fit {segments.shape[1]} segments")
    kept = np.isnan(lengths)[:, None]
    own = np.where(kept, 1.0, np.linalg.norm(segments, axis=2, keepdims=True))
    if (own < 1e-9).any():
        frame, segment = (int(index) for index in np.argwhere(own[..., 0] < 1e-9)[0])
        raise CaptureError(
            f"landmarks {segment + 1} and {segment + 2} coincide at frame {frame}: their segment"
            " has no direction"
        )
    longer = np.where(kept, 1.0, lengths[:, None])
    ends = landmarks[:, :1] + np.cumsum(segments / own * longer, axis=1)
    return np.concatenate([landmarks[:, :1], ends], axis=1)
