"""The table of servos on a terminal: what it says, how it fits, and that it is in nobody's way."""

import io
import json
import os
import pty
import select
import subprocess
import sys
import time
from pathlib import Path

import pytest
import serial
from rich.console import Console

from firmware_sim.command.live_table import COLUMNS, draw, show
from firmware_sim.command.readings import Reader
from firmware_sim.command.table_feed import TableFeed
from firmware_sim.firmware.world import build_world
from firmware_sim.rig.settings import parse_servo
from firmware_sim.wire.packet import build_packet

ROW = ["7", "xm430-w350", "position", "on", "2048", "2100", "1.4 rpm", "-13 mA"]
ROW += ["25 °C", "12 V", "overload", "500", "[crc-error]"]


def picture(width: int, **changes: object) -> str:
    document = {"title": "on /dev/pts/3", "rows": [ROW], "note": "", **changes}
    console = Console(file=io.StringIO(), width=width, color_system=None)
    console.print(draw(document, width))
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


def test_a_wide_terminal_shows_everything() -> None:
    text = picture(130)
    for said in (*ROW, *(name for name, _ in COLUMNS), "on /dev/pts/3"):
        assert said in text


def test_a_terminal_of_80_columns_shows_what_matters_whole() -> None:
    text = picture(80)
    assert max(map(len, text.splitlines())) <= 80
    for said in ("xm430-w350", "on", "2048", "2100", "overload", "500"):
        assert said in text
    assert "25 °C" not in text


def test_what_is_wrong_stands_below() -> None:
    assert "disk full" in picture(100, note="disk full")


def test_of_more_servos_than_fit_the_others_are_counted() -> None:
    document = {"title": "", "rows": [ROW] * 30, "note": "disk full"}
    console = Console(file=io.StringIO(), width=130, color_system=None)
    console.print(draw(document, 130, 24))
    assert isinstance(console.file, io.StringIO)
    text = console.file.getvalue()
    assert text.count("xm430-w350") == 18
    assert "and 12 more servos; disk full" in text
    assert text.count("\n") <= 24


def test_each_line_that_arrives_is_drawn() -> None:
    lines = [json.dumps({"title": f"table {n}", "rows": [ROW], "note": ""}) for n in range(2)]
    console = Console(file=io.StringIO(), width=120, force_terminal=True, color_system=None)
    show(io.StringIO("\n".join(lines) + "\n"), console)
    assert isinstance(console.file, io.StringIO)
    assert "table 0" in console.file.getvalue()
    assert "table 1" in console.file.getvalue()


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("xm430-w350:1", ["position", "off", "2048", "0", "0 rpm", "0 mA", "25 °C", "12 V", ""]),
        ("ax-12a:2", ["joint", "off"]),
        ("mx-28:3", ["joint", "off"]),
        ("xl-320:4", ["joint", "off"]),
    ],
)
def test_every_family_can_be_read(name: str, says: list[str]) -> None:
    world = build_world([parse_servo(name)])
    model, _, servo_id = name.partition(":")
    reading = Reader(world.servos[0]).take()
    assert reading[:2] == [servo_id, model]
    assert len(reading) == len(COLUMNS) - 2
    if len(says) > 2:
        assert reading[2:5] + reading[6:] == says[:3] + says[4:]
    else:
        assert reading[2:4] == says
        assert reading[4] in ("512", "2048")
    assert all(reading[place] for place in (4, 5, 6, 7, 8, 9))


def test_a_table_nobody_draws_is_given_up_without_a_word(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", "/bin/false")
    servos = build_world([parse_servo("xm430-w350:1")]).servos
    feed = TableFeed(servos, str, lambda _: 0, lambda _: [], str)
    now = 0.0
    while feed.next_due < float("inf"):
        feed.work(now)
        now += 0.25
        time.sleep(0.001)
        assert now < 5_000
    feed.close()


def test_on_a_terminal_the_command_draws_the_servos_and_serves_meanwhile(tmp_path: Path) -> None:
    screen, terminal = pty.openpty()
    link = tmp_path / "arm"
    command = [sys.executable, "-m", "firmware_sim", "--servo", "xm430-w350:1", "xl330-m288:2"]
    process = subprocess.Popen(
        [*command, "--link", str(link), "--exit-with-stdin"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=terminal,
        env={**os.environ, "TERM": "xterm", "COLUMNS": "120", "LINES": "24"},
    )
    os.close(terminal)
    try:
        assert process.stdout is not None
        assert process.stdin is not None
        assert process.stdout.readline().startswith(b"/dev/pts/")
        with serial.Serial(str(link), 57_600, timeout=2.0) as client:
            client.write(build_packet(1, 0x01))
            assert len(client.read(14)) == 14
        shown = read_until(screen, b"xl330-m288 ")
        assert b"pkt/s" in shown
        process.stdin.close()
        drain(screen, process)
        assert process.wait(10) == 0
    finally:
        process.kill()
        process.wait()
        if process.stdout is not None:
            process.stdout.close()
        os.close(screen)


def read_until(screen: int, wanted: bytes) -> bytes:
    shown = b""
    while wanted not in shown:
        assert select.select([screen], [], [], 20.0)[0], shown
        shown += os.read(screen, 65_536)
    return shown


def drain(screen: int, process: subprocess.Popen[bytes]) -> None:
    """Take what is still drawn, as a terminal does, until the process has ended."""
    deadline = time.monotonic() + 20.0
    while process.poll() is None:
        assert time.monotonic() < deadline
        if select.select([screen], [], [], 0.05)[0]:
            try:
                os.read(screen, 65_536)
            except OSError:  # its last writer is gone
                return
