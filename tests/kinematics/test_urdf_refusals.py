"""What is refused as a URDF, in one line that names file and joint."""

import os
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armsyn.errors import DescriptionError
from armsyn.kinematics import load_urdf
from armsyn.kinematics.urdf import MAXIMUM_BYTES, parse_urdf
from tests.kinematics.robots import UrdfPart, urdf

GOOD = urdf(UrdfPart("a"), UrdfPart("b", xyz=(0.3, 0.0, 0.0)))
LAUGHS = """<?xml version="1.0"?>
<!DOCTYPE robot [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">]>
<robot name="&b;"><link name="base"/></robot>"""


def refused(
    text: str, says: str, base: str | None = None, tip: str | None = None
) -> DescriptionError:
    with pytest.raises(DescriptionError, match=says) as caught:
        parse_urdf(text, "robot.urdf", base, tip)
    message = str(caught.value)
    assert message.startswith("robot.urdf: ")
    assert "\n" not in message
    return caught.value


@pytest.mark.parametrize(
    ("part", "says"),
    [
        (UrdfPart("odd", "planar"), "joint odd: 'planar' joints are not supported"),
        (UrdfPart("odd", "floating"), "joint odd: 'floating' joints are not supported"),
        (UrdfPart("odd", "ball"), "joint odd: 'ball' joints are not supported"),
        (UrdfPart("odd", limit=None), "joint odd: a revolute joint needs a <limit>"),
        (UrdfPart("odd", "prismatic", limit=None), "joint odd: a prismatic joint needs a <limit>"),
        (UrdfPart("odd", inside='<mimic joint="a"/>'), "joint odd: it mimics joint a"),
        (UrdfPart("odd", limit=(1.0, -1.0)), "joint odd: lower limit 1 is not below upper -1"),
        (
            UrdfPart("odd", limit=(0.0, float("nan"))),
            "joint odd: upper of <limit> must be 1 finite",
        ),
        (UrdfPart("odd", limit=(-1e999, 1.0)), "joint odd: lower of <limit> must be 1 finite"),
        (UrdfPart("odd", xyz=(0.0, float("nan"), 0.0)), "joint odd: xyz of <origin> must be 3"),
        (UrdfPart("odd", rpy=(0.0, 0.0)), "joint odd: rpy of <origin> must be 3 finite"),
        (UrdfPart("odd", axis=(0.0, 0.0, 0.0)), "joint odd: its axis has no length"),
        (UrdfPart("odd", axis=("${x}", 0.0, 0.0)), "joint odd: xyz of <axis> must be 3"),
        (UrdfPart("a"), "two (links|joints) are named 'a"),
        (UrdfPart("odd", parent="nowhere"), "joint odd: there is no link 'nowhere'"),
    ],
)
def test_refused_joints_are_named(part: UrdfPart, says: str) -> None:
    refused(urdf(UrdfPart("a"), part), says)


def joint(name: str, parent: str, child: str, kind: str = "continuous") -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/>'
        f'<child link="{child}"/></joint>'
    )


@pytest.mark.parametrize(
    ("extra", "says"),
    [
        (
            joint("back", "b_link", "base"),
            "joint back: it is part of a loop of a_link, b_link, base",
        ),
        (
            joint("twice", "base", "b_link"),
            "joint twice: link b_link is already the child of joint b",
        ),
        (joint("self", "b_link", "b_link"), "joint self: link b_link is already the child"),
        ('<link name="lonely"/>', "2 links have no parent, one must: base, lonely"),
        (
            '<link name="c"/><link name="d"/>' + joint("x", "c", "d") + joint("y", "d", "c"),
            "joint y: it is part of a loop of c, d",
        ),
        ('<link name="lone"/>' + joint("x", "lone", "gone"), "joint x: there is no link 'gone'"),
        ("<link/>", "a link has no 'name'"),
        ('<joint type="fixed"/>', "a joint has no 'name'"),
        ('<joint name="x"/>', "joint x: has no 'type'"),
        (
            '<joint name="x" type="fixed"><child link="base"/></joint>',
            "joint x: it has no <parent>",
        ),
        (
            '<joint name="x" type="fixed"><parent link="base"/><child/></joint>',
            "joint x: its <child> has no 'link'",
        ),
    ],
)
def test_links_that_form_no_tree(extra: str, says: str) -> None:
    refused(GOOD.replace("</robot>", f"{extra}</robot>"), says)


def test_several_leaves_are_named() -> None:
    text = urdf(UrdfPart("a"), UrdfPart("b"), UrdfPart("c", parent="a_link"))
    refused(text, "2 links end a chain from base: name one as tip: b_link, c_link")
    many = urdf(UrdfPart("a"), *(UrdfPart(f"b{i}", parent="a_link") for i in range(20)))
    refused(many, "20 links end a chain from base.* and 8 more")


def test_base_and_tip_that_make_no_chain() -> None:
    refused(GOOD, "no link 'hand'; its links are base, a_link, b_link", tip="hand")
    refused(GOOD, "no link 'floor'", base="floor")
    refused(GOOD, "no chain leads from link b_link to link a_link", base="b_link", tip="a_link")
    refused(GOOD, "no moving joint between link base and link base", tip="base")
    refused(GOOD, "no moving joint between link b_link and link b_link", base="b_link")
    refused(urdf(UrdfPart("a", "fixed")), "no moving joint between link base and link a_link")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "is not well-formed XML"),
        ("hello", "is not well-formed XML"),
        (GOOD[: len(GOOD) // 2], "is not well-formed XML"),
        (GOOD.replace("<robot", "<robot &x;"), "is not well-formed XML"),
        ("<sdf version='1.6'/>", "is not a URDF: its root element is <sdf>"),
        ("<robot name='nothing'/>", "it has no links"),
        (LAUGHS, "it has a <!DOCTYPE declaration, which is not read"),
        (GOOD + "<!ENTITY x 'y'>", "it has a <!ENTITY declaration, which is not read"),
    ],
)
def test_texts_that_are_no_urdf(text: str, says: str) -> None:
    refused(text, says)


def test_line_ends_in_names_stay_out_of_messages() -> None:
    refused(
        GOOD.replace('name="a" type="revolute"', 'name="a&#10;b" type="ball"'), "joint a b: 'ball'"
    )


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    def says(content: bytes | None, message: str) -> None:
        file = tmp_path / "robot.urdf"
        if content is not None:
            file.write_bytes(content)
        with pytest.raises(DescriptionError, match=message) as caught:
            load_urdf(file)
        assert str(caught.value).startswith(f"{file}: ")

    says(None, "cannot be read: No such file or directory")
    says(b"\xff\xfe" + GOOD.encode("utf-16-le"), "is not UTF-8 text")
    says(GOOD.encode()[:-20] + b"\xe9</robot>", "is not UTF-8 text")
    says(b" " * (MAXIMUM_BYTES + 1), f"larger than {MAXIMUM_BYTES} bytes")
    with pytest.raises(DescriptionError, match="cannot be read: Is a directory"):
        load_urdf(tmp_path)


@pytest.mark.skipif(not os.path.exists("/dev/zero"), reason="no endless file here")  # noqa: PTH110
def test_an_endless_file_is_cut_off() -> None:
    with pytest.raises(DescriptionError, match="larger than"):
        load_urdf("/dev/zero")


def test_a_byte_order_mark_is_no_part_of_the_text(tmp_path: Path) -> None:
    file = tmp_path / "robot.urdf"
    file.write_bytes(b"\xef\xbb\xbf" + GOOD.encode())
    assert load_urdf(file).names == ("a", "b")


@settings(max_examples=100, deadline=None)
@given(start=st.integers(0, len(GOOD)), length=st.integers(0, 40), put=st.text(max_size=5))
def test_a_damaged_file_is_read_or_refused(start: int, length: int, put: str) -> None:
    text = GOOD[:start] + put + GOOD[start + length :]
    message = "robot.urdf: "
    try:
        parse_urdf(text, "robot.urdf")
    except DescriptionError as error:
        message = str(error)
    assert message.startswith("robot.urdf: ")
    assert len(message.splitlines()) == 1
