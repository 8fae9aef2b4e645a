"""Motion editing in the latent space (Carvalho, Boulic and Thalmann): learn a pattern, bend a clip.

    model = learn_model(load_clips("garza"), frames=50, variance=0.98)
    hand = Effector("JtWristRt")
    result = edit_motion(clip, model, [KeyFrame(hand, frame=-1, by=(0.0, 0.05, 0.0))])
    result.clip, result.residuals, result.largest_coefficient

A clip is a `BodyMotion` (whole bodies) or a `Motion` with angles (an arm's, with a `ChainFigure`).
"""

from armsyn.editing.clips import is_clip_selection, load_clips
from armsyn.editing.constraints import (
    Constraint,
    Key,
    KeyFrame,
    KeyTrajectory,
    Orientation,
    Pin,
)
from armsyn.editing.editor import Editor, edit_in_joint_space, edit_motion
from armsyn.editing.feet import FootMotion
from armsyn.editing.figure import ChainFigure, Clip, Effector, Figure, SkeletonFigure, figure_of
from armsyn.editing.pattern.files import load_model, save_model
from armsyn.editing.pattern.learning import learn_model
from armsyn.editing.pattern.model import MotionModel
from armsyn.editing.result import EditResult, Residual
from armsyn.editing.sharing import retargeted
from armsyn.editing.solving import SolverOptions
from armsyn.editing.splines import KochanekBartels, ease

__all__ = [
    "ChainFigure",
    "Clip",
    "Constraint",
    "EditResult",
    "Editor",
    "Effector",
    "Figure",
    "FootMotion",
    "Key",
    "KeyFrame",
    "KeyTrajectory",
    "KochanekBartels",
    "MotionModel",
    "Orientation",
    "Pin",
    "Residual",
    "SkeletonFigure",
    "SolverOptions",
    "ease",
    "edit_in_joint_space",
    "edit_motion",
    "figure_of",
    "is_clip_selection",
    "learn_model",
    "load_clips",
    "load_model",
    "retargeted",
    "save_model",
]
