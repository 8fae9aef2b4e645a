"""Atlases: written and read back the same, refused by field where they are damaged."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from armsyn.arm import load_arm
from armsyn.errors import DescriptionError, InputError
from armsyn.planning.atlas import Atlas, AtlasFacts, Likeness, atlas_of, chain_hash
from armsyn.planning.atlas_file import load_atlas, save_atlas
from armsyn.planning.generation.variability import learn_variability
from armsyn.planning.predictor import learn_predictor
from tests.planning.people import made_examples

ARM = load_arm("hug_mp4", calibrated=False)
EXAMPLES = made_examples(noise=0.05)


@pytest.fixture(scope="module")
def atlas() -> Atlas:
    facts = AtlasFacts(
        arm=ARM.name,
        joint_names=ARM.joint_names,
        captures="made",
        sources=("made",),
        subjects=("made",),
        reaches=EXAMPLES.size,
        places=8,
        left_out={},
        repeats="made",
        inputs_sha256="0",
        chain_sha256=chain_hash(ARM.chain),
        seed=0,
        likeness=Likeness(("hand",), 0.0, 0.0, None, 0.0),
    )
    predictors = {kind: learn_predictor(kind, EXAMPLES) for kind in ("linear", "latent")}
    for field in ("map", "idw", "rbf", "gp", "nearest"):
        kind = "synergy" if field == "map" else f"synergy-{field}"
        predictors[kind] = learn_predictor(kind, EXAMPLES, model="C", ridge=0.1)
    return Atlas(facts, predictors, learn_variability(EXAMPLES, predictors["linear"]))


@pytest.fixture
def written(atlas: Atlas, tmp_path: Path) -> Path:
    path = tmp_path / "hug_mp4.atlas.json"
    save_atlas(path, atlas)
    return path


def test_what_is_read_predicts_what_was_written(atlas: Atlas, written: Path) -> None:
    read = load_atlas(written, ARM)
    assert read.facts == atlas.facts
    assert read.kinds == atlas.kinds
    for kind in atlas.kinds:
        assert read.predictor(kind).name == kind
        before, after = (
            one.predictor(kind).predict(EXAMPLES.starts, EXAMPLES.targets) for one in (atlas, read)
        )
        assert np.abs(before.angles - after.angles).max() < 2e-3, kind
        assert before.durations == pytest.approx(after.durations, rel=1e-4)
        assert after.reached.all()
    assert read.variability is not None
    assert atlas.variability is not None
    assert read.variability.modes == pytest.approx(atlas.variability.modes, abs=1e-4)


def test_what_is_read_is_written_as_the_same_bytes(written: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.atlas.json"
    save_atlas(again, load_atlas(written, ARM))
    twice = tmp_path / "twice.atlas.json"
    save_atlas(twice, load_atlas(again, ARM))
    assert twice.read_bytes() == again.read_bytes()


def test_it_is_found_beside_the_arm(written: Path) -> None:
    assert atlas_of(ARM, written.parent).facts.arm == "hug_mp4"
    with pytest.raises(DescriptionError, match=r"no human7\.atlas\.json"):
        atlas_of(load_arm("human7", calibrated=False), written.parent)


def test_an_unknown_kind_is_refused_by_name(atlas: Atlas) -> None:
    with pytest.raises(InputError, match=r"has no 'lenear', but linear.*did you mean 'linear'"):
        atlas.predictor("lenear")


def _drop(document: dict[str, Any]) -> None:
    del document["predictors"]["latent"]["components"]


def _add(document: dict[str, Any]) -> None:
    document["predictors"]["latent"]["more"] = 1


def _not_finite(document: dict[str, Any]) -> None:
    document["predictors"]["synergy"]["field"]["mean"]["values"][0] = "inf"


def _shape(document: dict[str, Any]) -> None:
    document["predictors"]["linear"]["motions"]["shape"] = [4, 7]


def _steps(document: dict[str, Any]) -> None:
    document["predictors"]["linear"]["motions"]["steps"] = "!"


def _other_class(document: dict[str, Any]) -> None:
    document["predictors"]["synergy"]["family"] = document["predictors"]["synergy"]["hull"]


def _no_class(document: dict[str, Any]) -> None:
    document["predictors"]["synergy"]["class"] = "os"


def _do_not_fit(document: dict[str, Any]) -> None:
    part = document["predictors"]["latent"]["deviations"]
    whole = part["shape"][0] * part["shape"][1]
    part["shape"] = [whole, 1]


def _schema(document: dict[str, Any]) -> None:
    document["schema"] = "armsyn-atlas-9"


def _kind(document: dict[str, Any]) -> None:
    document["predictors"]["linear"] = document["predictors"]["linear"]["hull"]


def _modes(document: dict[str, Any]) -> None:
    document["variability"]["times"] = {"shape": [1], "values": [0.1]}


def _arm(document: dict[str, Any]) -> None:
    document["facts"]["arm"] = "koch"


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (_drop, "predictors.latent: field 'components' of LatentPredictor is missing"),
        (_add, "predictors.latent: field 'more' of LatentPredictor is unknown"),
        (_not_finite, r"predictors.synergy.field.mean: expected a finite number, got 'inf'"),
        (_shape, r"predictors.linear.motions: 1616 values do not fill the shape \[4, 7\]"),
        (_steps, "predictors.linear.motions.steps: no 16-bit numbers"),
        (_other_class, "predictors.synergy.family: expected PhasedSynergies, got Hull"),
        (_no_class, "predictors.synergy: no model of"),
        (_do_not_fit, "predictors.latent: arrays do not fit each other"),
        (_schema, "armsyn-atlas-9"),
        (_kind, "predictors.linear: arrays do not fit|predictors.linear: expected"),
        (_modes, "variability: modes of shape"),
        (_arm, "of koch .* not of hug_mp4"),
    ],
)
def test_damage_is_told_by_field(
    written: Path, damage: Callable[[dict[str, Any]], None], said: str
) -> None:
    document = json.loads(written.read_text())
    damage(document)
    written.write_text(json.dumps(document))
    with pytest.raises(DescriptionError, match=said) as refused:
        load_atlas(written, ARM)
    assert str(written) in str(refused.value)
    assert "learn it again" in str(refused.value)


@pytest.mark.parametrize("part", [0, 0.3, 0.99])
def test_a_file_that_was_cut_off_is_refused(written: Path, part: float) -> None:
    content = written.read_bytes()
    written.write_bytes(content[: int(part * len(content))])
    with pytest.raises(DescriptionError):
        load_atlas(written, ARM)


def test_an_arm_whose_links_changed_is_refused(written: Path) -> None:
    elbow = replace(ARM.joint[3], xyz=(0.0, 0.0, -0.31))
    other = replace(ARM, joint=(*ARM.joint[:3], elbow))
    with pytest.raises(DescriptionError, match="no longer those it was learned on"):
        load_atlas(written, other)


def test_an_arm_whose_calibration_narrows_its_limits_may_use_it(written: Path) -> None:
    narrower = replace(ARM, joint=tuple(replace(j, upper=j.upper - 0.05) for j in ARM.joint))
    read = load_atlas(written, narrower)
    found = read.predictor("linear").predict(narrower.rest[None], EXAMPLES.targets[:1])
    assert (found.angles[0, -1] <= narrower.chain.upper + 1e-9).all()
