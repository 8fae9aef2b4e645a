"""Shapes in descriptions: what is judged, what is not, and what is refused."""

import numpy as np
import pytest

from armsyn.arm import arm_names, load_arm
from armsyn.arm.link import STAND_IN_RADIUS
from armsyn.errors import DescriptionError, InputError
from armsyn.safety import check_collision, closest
from tests.safety.shaped import arm_of, capsule, everything, joint, two_links

TABLE = '[[plane]]\nname = "table"\npoint = [0.0, 0.0, -0.1]\nnormal = [0.0, 0.0, 2.0]\n'
TIP_OF_THREE = "[0.3, 0.0, 0.0]"


def three(top: str = "", *shapes: str) -> list[tuple[str, str]]:
    """Pairs that are judged of three links of 0.3 m, straight at rest; shapes of the middle one."""
    arm = arm_of(
        joint("one", "[0.0, 0.0, 1.0]"),
        joint("two", "[0.0, 0.0, 1.0]", "[0.3, 0.0, 0.0]", *shapes),
        joint("three", "[0.0, 0.0, 1.0]", "[0.3, 0.0, 0.0]"),
        top=top,
        tip=TIP_OF_THREE,
    )
    return list(arm.solids.names)


def test_links_next_to_each_other_are_not_judged() -> None:
    assert three() == [("one", "three")]


def test_links_without_shapes_make_no_neighbours() -> None:
    assert three("", "shape = []") == []  # now the first and the last are next to each other


def test_links_that_one_joint_alone_moves_are_left_to_its_limits() -> None:
    """A roll between two links moves a capsule about its axis nowhere, and another one does."""
    tables = [
        joint("one", "[0.0, 0.0, 1.0]"),
        joint("two", "[0.0, 0.0, 1.0]", "[0.3, 0.0, 0.0]"),
        joint("roll", "[1.0, 0.0, 0.0]", "[0.3, 0.0, 0.0]"),
    ]
    assert arm_of(*tables, tip=TIP_OF_THREE).solids.names == ()
    assert arm_of(*tables, tip="[0.3, 0.1, 0.0]").solids.names == (("one", "roll"),)


def test_pairs_can_be_left_out() -> None:
    assert three('collision_ignore = [["three", "one"]]') == []


def test_a_stand_in_reaches_from_joint_to_joint() -> None:
    arm = arm_of(
        TABLE,
        joint("one", "[0.0, 1.0, 0.0]"),
        joint("two", "[0.0, 1.0, 0.0]", "[0.3, 0.0, 0.0]"),
        tip=TIP_OF_THREE,
    )
    angle = np.array([0.2, 0.0])  # both links down by 0.2 rad: the tip is the nearest
    expected = 0.1 - 0.6 * np.sin(0.2) - STAND_IN_RADIUS
    found = closest(angle, arm)
    assert found is not None
    assert found.distance == pytest.approx(expected)
    assert (found.first, found.second, found.frame) == ("two", "table", 0)


def test_stand_ins_that_touch_at_rest_are_not_judged() -> None:
    tables = [
        joint("one", "[0.0, 0.0, 1.0]"),
        joint("two", "[0.0, 1.0, 0.0]", "[0.2, 0.0, 0.0]"),
        joint("three", "[0.0, 0.0, 1.0]", "[0.03, 0.0, 0.0]"),
        joint("four", "[0.0, 1.0, 0.0]", "[0.2, 0.0, 0.0]"),
    ]
    arm = arm_of(*tables, tip=TIP_OF_THREE)
    assert arm.solids.unjudged == (("one", "three"),)
    assert arm.solids.names == (("one", "four"), ("two", "four"))
    shaped = [tables[0], capsule("[0.0, 0.0, 0.0]", "[0.2, 0.0, 0.0]", 0.02), tables[1]]
    shaped += [tables[2], capsule("[0.0, 0.0, 0.0]", "[0.2, 0.0, 0.0]", 0.02), tables[3]]
    with pytest.raises(InputError, match=r"made: at its rest posture one is 0\.010 m inside three"):
        _ = arm_of(*shaped, tip=TIP_OF_THREE).solids


def test_a_table_in_the_resting_arm_is_refused() -> None:
    with pytest.raises(InputError, match=r"upper is 0\.010 m inside table: mend their shapes, or"):
        _ = two_links("", TABLE.replace("-0.1", "-0.01"), joint("z", "[1.0, 0.0, 0.0]")).solids


def test_what_no_joint_moves_is_not_judged() -> None:
    base = capsule("[0.0, 0.0, -0.4]", "[0.0, 0.0, -0.3]", 0.05, "base_shape")
    arm = arm_of(
        TABLE,
        base,
        joint("pan", "[0.0, 0.0, 1.0]"),
        capsule("[0.0, 0.0, -0.095]", "[0.0, 0.0, 0.0]", 0.02),  # stands on the table
        joint("lift", "[0.0, 1.0, 0.0]"),
        tip="[0.2, 0.0, 0.0]",
    )
    assert arm.solids.names == (("base", "lift"), ("lift", "table"))


@pytest.mark.parametrize(
    ("change", "error"),
    [
        (("radius = 0.02", "radius = 0.0"), r"Expected `float` > 0.0.*shape"),
        (("radius = 0.02", "radius = nan"), r"Expected `float` > 0.0.*shape"),
        (("radius = 0.02", "radius = inf"), r"joint upper: shape: radius must be finite"),
        (("from = [0.0, 0.0, 0.0]", "from = [0.0, inf, 0.0]"), r"shape: start must be finite"),
        (("to = [0.3", "two = [0.3"), r"unknown field `two`|missing required field `to`"),
        (("normal = [0.0, 0.0, 2.0]", "normal = [0.0, 0.0, 0.0]"), r"plane table: its normal has"),
        (("normal = [0.0, 0.0, 2.0]", "normal = [0.0, 0.0, nan]"), r"plane table: normal must be"),
        (('name = "table"', 'name = "upper"'), r"'upper' names two of"),
        (('name = "table"', 'name = "base"'), r"'base' names two of"),
        (("[[plane]]", "[[plain]]"), r"unknown field `plain`"),
    ],
)
def test_what_is_refused(change: tuple[str, str], error: str) -> None:
    tables = [
        TABLE,
        joint("upper", "[0.0, 0.0, 1.0]"),
        capsule("[0.0, 0.0, 0.0]", "[0.3, 0.0, 0.0]", 0.02),
    ]
    assert any(change[0] in table for table in tables)
    arm_of(*tables)
    with pytest.raises(DescriptionError, match=error) as caught:
        arm_of(*(table.replace(*change) for table in tables))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("pair", "error"),
    [
        ('["upper", "tabel"]', "'tabel' is no joint, plane or box, and not 'base'"),
        ('["upper", "upper"]', "'upper' stands beside itself"),
        ('["upper"]', "Expected `array` of length 2"),
    ],
)
def test_pairs_that_are_none(pair: str, error: str) -> None:
    with pytest.raises(DescriptionError, match=error):
        two_links(f"collision_ignore = [{pair}]")


@pytest.mark.parametrize("size", ["[0.1, 0.0, 0.1]", "[0.1, -0.1, 0.1]", "[0.1, 0.1]"])
def test_boxes_without_a_size(size: str) -> None:
    with pytest.raises(DescriptionError, match="box"):
        two_links("", f'[[box]]\nname = "b"\ncentre = [1.0, 1.0, 1.0]\nsize = {size}\n')


def test_slower_arms_fill_the_same() -> None:
    arm = everything()
    q = 0.1 * np.ones((1, 4))
    np.testing.assert_array_equal(arm.slowed(3.0).solids.clearances(q), arm.solids.clearances(q))


@pytest.mark.parametrize("name", arm_names())
def test_arms_of_the_project_rest_freely(name: str) -> None:
    arm = load_arm(name)
    assert check_collision(arm.rest[None], arm) is None
    assert (arm.solids.at_rest >= 0.0).all()


@pytest.mark.parametrize(
    ("name", "posture", "pair"),
    [  # by the arms' geometry: an elbow bent across the trunk, hands in tables
        ("human7", [0.0, 0.0, 1.57, 1.57, 0.0, 0.0, 0.0], {"base", "forearm_pronation"}),
        ("human7", [0.0, 0.0, 1.57, 2.2, 0.0, 0.0, 0.0], {"base", "wrist_deviation"}),
        ("openmanipulator_x", [0.0, 1.4, 0.3, 0.0], {"joint4", "table"}),
        ("koch", [0.0, -1.57, 0.0, 0.0, 0.0], {"wrist_roll", "table"}),
    ],
)
def test_postures_that_touch(name: str, posture: list[float], pair: set[str]) -> None:
    arm = load_arm(name)
    found = [
        names
        for names, clearance in zip(
            arm.solids.names, arm.solids.clearances(np.array([posture]))[0], strict=True
        )
        if clearance < 0.0
    ]
    assert pair in [set(names) for names in found]
