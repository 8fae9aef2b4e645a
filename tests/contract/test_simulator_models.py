"""Which of the simulator's models a name, a firmware version and a protocol choose."""

from itertools import pairwise

import pytest

from firmware_sim.errors import RigError
from firmware_sim.firmware.world import build_world
from firmware_sim.rig.settings import ServoSettings
from firmware_sim.tables import MODEL_NAMES, find_model

MX = ("mx-28", "mx-64", "mx-106")
X330 = tuple(name for name in MODEL_NAMES if name[2:5] == "330")


@pytest.mark.parametrize("name", [*X330, "xl430-w250", "xm430-w350", "xh540-v150", *MX])
def test_layouts_cover_all_firmware_from_the_oldest_on(name: str) -> None:
    tops = {**dict.fromkeys(X330, (53, 52, 45)), **dict.fromkeys(MX, (42, 41))}
    seen = [find_model(name, firmware, 2) for firmware in tops.get(name, (45, 44, 41))]
    assert find_model(name, protocol=2) == seen[0]
    assert seen[0].last_firmware is None
    for newer, older in pairwise(seen):
        assert older.last_firmware == newer.first_firmware - 1 == older.firmware


@pytest.mark.parametrize(("firmware", "data_at"), [(53, 224), (200, 224), (52, 208), (46, 208)])
def test_firmware_moves_the_indirect_data_of_an_x330(firmware: int, data_at: int) -> None:
    model = find_model("XL330-M288", firmware)
    assert model.firmware == firmware
    assert model.table["Indirect Data 1"].address == data_at


@pytest.mark.parametrize(
    ("name", "firmware", "bits"),
    [
        ("xm430-w350", 45, 0b1101),
        ("xm430-w350", 44, 0b0101),
        ("xm430-w350", 41, 0b0001),
        ("xl330-m288", 46, 0b1101),
        ("xl330-m288", 45, 0b0101),
        ("mx-106", 40, 0b0001),
    ],
)
def test_firmware_brings_bits_of_the_drive_mode(name: str, firmware: int, bits: int) -> None:
    assert find_model(name, firmware, protocol=2).drive_mode_bits == bits


@pytest.mark.parametrize(
    ("name", "firmware", "knows"),
    [
        ("xm430-w350", 45, True),
        ("xm430-w350", 44, False),
        ("xl330-m288", 46, True),
        ("xl330-m288", 45, False),
        ("2xl430-w250", 45, False),
        ("2xc430-w250", 45, False),
        ("mx-64", 42, False),
    ],
)
def test_fast_reads_are_in_the_firmware_that_has_them(
    name: str, firmware: int, knows: bool
) -> None:
    assert find_model(name, firmware, 2).understands_fast_reads == knows


@pytest.mark.parametrize("name", MX)
def test_protocol_decides_which_firmware_an_mx_has(name: str) -> None:
    sold, first, second = (find_model(name, protocol=protocol) for protocol in (None, 1, 2))
    assert sold == first
    assert (first.protocol, first.family) == (1, "classic")
    assert (second.protocol, second.family) == (2, "x")
    assert second.number == first.number + 1
    assert first.motor == second.motor


def test_protocol_changes_no_x_series_model() -> None:
    assert find_model("xm430-w350", protocol=1) == find_model("xm430-w350")


@pytest.mark.parametrize(
    ("wanted", "field", "text"),
    [
        (("xm430-w35",), "model", "did you mean xm430-w350"),
        (("XL320",), "model", "did you mean xl-320"),
        (("servo",), "model", "use one of xl330-m077, "),
        (("xm430-w350", 37), "firmware", "use 38 to 255"),
        (("xm430-w350", 256), "firmware", "use 38 to 255"),
        (("xl330-m288", None, 1), "protocol", "does not speak protocol 1.0"),
        (("ax-12a", None, 2), "protocol", "does not speak protocol 2.0"),
    ],
)
def test_what_is_not_there_is_said(
    wanted: tuple[str, int | None, int | None], field: str, text: str
) -> None:
    with pytest.raises(RigError, match=text) as caught:
        find_model(*wanted)
    assert caught.value.field == field
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", MODEL_NAMES)
def test_every_name_finds_its_model(name: str) -> None:
    assert find_model(name).name == find_model(name.upper()).name == name


@pytest.mark.parametrize("firmware", [None, 44])
@pytest.mark.parametrize("name", [n for n in MODEL_NAMES if n[0] in "2x" and n != "xl-320"] + [*MX])
def test_every_servo_with_protocol_2_goes_where_it_is_told(name: str, firmware: int | None) -> None:
    model = find_model(name, firmware, protocol=2)
    world = build_world([ServoSettings(model, servo_id=1)])
    (servo,) = world.servos
    for register, value in (("Torque Enable", 1), ("Goal Position", 2100)):
        at = model.table[register]
        assert servo.write(at.address, value.to_bytes(at.size, "little")) == 0
    world.advance(1.5)
    _, identity = servo.read(0, 7)
    assert identity[:2] == model.number.to_bytes(2, "little")
    assert identity[6] == model.firmware
    _, position = servo.read(model.table["Present Position"].address, 4)
    assert abs(int.from_bytes(position, "little") - 2100) <= 12  # as the gains leave it
