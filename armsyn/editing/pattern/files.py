"""Motion models in files: an npz archive, or text: a JSON header with a CSV of components beside.

Both hold the same header (schema, figure, weights, examples, seed, hash of the inputs). In the
archive it is the text ``header`` beside the arrays ``mean`` and ``components``; as text,
``NAME.json`` is the header and ``NAME.components.csv`` has one row a frame and column of the pose
vector: ``frame,column,mean,component 1, ...``, numbers to the last bit.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

from armsyn.editing.figure import ChainFigure, Figure, SkeletonFigure
from armsyn.editing.pattern.model import MotionModel
from armsyn.errors import FormatError, InputError
from armsyn.kinematics.chain import Joint, SerialChain
from armsyn.kinematics.skeleton import Skeleton
from armsyn.motion.formats.archive import opened
from armsyn.motion.formats.files import check_size, replacing

FloatArray = NDArray[np.float64]
LARGEST_TEXT = 256 * 2**20
Triple = tuple[float, float, float]


class _SkeletonText(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="skeleton"):
    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets_m: tuple[Triple, ...]
    prerotations: tuple[tuple[Triple, Triple, Triple], ...]
    moving: tuple[int, ...]


class _JointText(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    name: str
    kind: Literal["revolute", "prismatic"]
    xyz: Triple
    rpy: Triple
    axis: Triple
    lower: float
    upper: float


class _ChainText(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="chain"):
    name: str
    joints: tuple[_JointText, ...]
    tip_xyz: Triple
    tip_rpy: Triple


class _Header(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    schema: Literal["armsyn-motion-model-1"]
    figure: _SkeletonText | _ChainText
    frames: int
    sigma: tuple[float, ...]
    radians_per_metre: float
    duration_s: float
    names: tuple[str, ...]
    examples: tuple[tuple[float, ...], ...]
    variance_shares: tuple[float, ...]
    left_out_m: tuple[float, ...]
    inputs_sha256: str
    seed: int


def save_model(path: Path | str, model: MotionModel) -> None:
    """Write a model; ``.npz`` is an archive, ``.json`` is text with ``.components.csv`` beside.

    Parameters
    ----------
    path : Path or str
    model : MotionModel

    Raises
    ------
    InputError
        Another suffix, or a place that cannot be written.
    """
    path = Path(path)
    header = msgspec.json.encode(_header(model))
    if path.suffix == ".npz":
        arrays = {"mean": model.mean, "components": model.components}
        with replacing(path) as temporary, temporary.open("wb") as file:
            np.savez(file, allow_pickle=False, header=np.array(header.decode()), **arrays)
    elif path.suffix == ".json":
        with replacing(_table(path)) as temporary:
            _write_table(temporary, model)
        with replacing(path) as temporary:
            temporary.write_bytes(msgspec.json.format(header) + b"\n")
    else:
        raise InputError(f"{path}: a model is kept as .npz or .json")


def load_model(path: Path | str) -> MotionModel:
    """Read a model that `save_model` wrote.

    Parameters
    ----------
    path : Path or str

    Returns
    -------
    MotionModel

    Raises
    ------
    FormatError
        Missing, damaged, or of another schema; one line with the file and what is wrong.
    """
    path = Path(path)
    try:
        if path.suffix == ".npz":
            with opened(path) as archive:
                header = msgspec.json.decode(archive.text("header"), type=_Header)
                mean, components = archive.numbers("mean"), archive.numbers("components")
            return _model(header, mean, components)
        if path.suffix == ".json":
            check_size(path, LARGEST_TEXT)
            header = msgspec.json.decode(path.read_bytes(), type=_Header)
            return _model(header, *_read_table(_table(path), header))
    except FormatError:
        raise
    except (msgspec.DecodeError, csv.Error, InputError, ValueError, OSError) as error:
        raise FormatError(f"{path}: not a motion model: {error}") from error
    raise FormatError(f"{path}: a model is kept as .npz or .json")


def _table(path: Path) -> Path:
    return path.with_suffix(".components.csv")


def _header(model: MotionModel) -> _Header:
    return _Header(
        schema="armsyn-motion-model-1",
        figure=_figure_text(model.figure),
        frames=model.frames,
        sigma=tuple(model.sigma.tolist()),
        radians_per_metre=model.radians_per_metre,
        duration_s=model.duration,
        names=model.names,
        examples=tuple(tuple(row) for row in model.examples.tolist()),
        variance_shares=tuple(model.shares.tolist()),
        left_out_m=tuple(model.left_out_m.tolist()),
        inputs_sha256=model.inputs_sha256,
        seed=model.seed,
    )


def _figure_text(figure: Figure) -> _SkeletonText | _ChainText:
    if isinstance(figure, SkeletonFigure):
        skeleton = figure.skeleton
        return _SkeletonText(
            skeleton.names,
            skeleton.parents,
            tuple(skeleton.offsets.tolist()),
            tuple(np.asarray(skeleton.prerotations).tolist()),
            figure.moving,
        )
    if isinstance(figure, ChainFigure):
        chain = figure.chain
        joints = tuple(_JointText(**vars(joint)) for joint in chain.joints)
        return _ChainText(figure.name, joints, chain.tip_xyz, chain.tip_rpy)
    raise InputError("only skeletons and serial chains are kept in files")


def _figure(text: _SkeletonText | _ChainText) -> Figure:
    if isinstance(text, _SkeletonText):
        offsets, turns = np.array(text.offsets_m), np.array(text.prerotations)
        if not all(0 < joint < len(text.names) for joint in text.moving):
            raise InputError(f"moving joints {text.moving} are not the skeleton's")
        return SkeletonFigure(Skeleton(text.names, text.parents, offsets, turns), text.moving)
    joints = tuple(Joint(**msgspec.structs.asdict(joint)) for joint in text.joints)
    return ChainFigure(SerialChain(joints, text.tip_xyz, text.tip_rpy), text.name)


def _model(header: _Header, mean: FloatArray, components: FloatArray) -> MotionModel:
    figure, m = _figure(header.figure), len(header.sigma)
    sigma, examples = np.array(header.sigma), np.array(header.examples)
    shapes = {
        "mean": (mean, (header.frames, figure.size)),
        "components": (components, (m, header.frames, figure.size)),
        "examples": (examples, (len(header.names), m)),
        "left_out_m": (np.array(header.left_out_m), (len(header.names),)),
    }
    for name, (values, shape) in shapes.items():
        if values.shape != shape or not np.isfinite(values).all():
            raise InputError(f"'{name}' has shape {values.shape}, expected finite {shape}")
    if not m or not (sigma > 0).all() or not header.radians_per_metre > 0 or header.frames < 2:
        raise InputError("standard deviations and the weight of lengths are positive")
    return MotionModel(
        figure,
        mean,
        components,
        sigma,
        header.radians_per_metre,
        header.duration_s,
        header.names,
        examples,
        np.array(header.variance_shares),
        np.array(header.left_out_m),
        header.inputs_sha256,
        header.seed,
    )


def _write_table(path: Path, model: MotionModel) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        ranks = [f"component {place + 1}" for place in range(model.size)]
        writer.writerow(["frame", "column", "mean", *ranks])
        for frame in range(model.frames):
            rows = np.concatenate([model.mean[None, frame], model.components[:, frame]]).T.tolist()
            for column, row in zip(model.figure.tree.columns, rows, strict=True):
                writer.writerow([frame, column, *row])


def _read_table(path: Path, header: _Header) -> tuple[FloatArray, FloatArray]:
    check_size(path, LARGEST_TEXT)
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file, strict=True))[1:]
    columns = _figure(header.figure).tree.columns
    places = [[str(frame), name] for frame in range(header.frames) for name in columns]
    if [row[:2] for row in rows] != places:
        raise InputError(f"{path.name} does not go through the frames and columns in order")
    numbers = np.array([row[2:] for row in rows], dtype=np.float64)
    m = len(header.sigma)
    table = numbers.reshape(header.frames, -1, 1 + m)
    return np.ascontiguousarray(table[..., 0]), np.ascontiguousarray(
        np.moveaxis(table[..., 1:], -1, 0)
    )
