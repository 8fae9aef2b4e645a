"""The fixtures for other projects' tests, as pytest finds them there."""

import os
import sys

import pytest

pytest_plugins = ["pytester"]

PROJECT = """
import serial

PING = b"\\xff\\xff\\xfd\\x00\\x01\\x03\\x00\\x01\\x19\\x4e"


def test_a_real_port(dynamixel_simulator):
    servos = dynamixel_simulator("xm430-w350:1", baud=1_000_000, seed=3)
    with serial.Serial(servos.port, 1_000_000, timeout=2.0) as client:
        client.write(PING)
        assert len(client.read(14)) == 14
        number = servos.inject("lost-replies:id=1")
        client.timeout = 0.2
        client.write(PING)
        assert client.read(14) == b""
        assert [strike["fault"] for strike in servos.strikes()] == ["lost-replies"]
        servos.clear(str(number))
        client.timeout = 2.0
        client.write(PING)
        assert len(client.read(14)) == 14
        assert [servo["id"] for servo in servos.status()["servos"]] == [1]
    assert servos.stop() == 0
    assert "lost-replies strikes" in servos.trace


def test_two_at_once_and_unplugged(dynamixel_simulator):
    first = dynamixel_simulator("xm430-w350:1")
    second = dynamixel_simulator("ax-12a:1", "ax-12a:2", baud=57_600)
    assert first.port != second.port
    first.inject("unplugged:for=0.05")
    while first.status()["unplugged"]:
        pass
    with serial.Serial(first.link, 57_600, timeout=2.0) as client:
        client.write(PING)
        assert len(client.read(14)) == 14


def test_a_stepped_clock(stepped_bus):
    bus = stepped_bus("ax-12a:1", faults=["lost-replies:count=1"])
    ping = b"\\xff\\xff\\x01\\x02\\x01\\xfb"
    assert bus.exchange(ping) == b""
    bus.clock.advance(0.5)
    assert bus.exchange(ping) == b"\\xff\\xff\\x01\\x02\\x00\\xfc"


def test_both_protocols_on_a_stepped_clock(stepped_bus):
    bus = stepped_bus("mx-28:1", baud=1_000_000, protocol=2, gap_rule=False)
    assert len(bus.exchange(PING)) == 14
"""


def test_another_projects_tests(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, sys.path)))
    pytester.makepyfile(PROJECT)
    arguments = ("-p", "firmware_sim.pytest_plugin", "-p", "no:cacheprovider")
    result = pytester.runpytest_subprocess(*arguments, timeout=200)
    result.assert_outcomes(passed=4)


def test_they_are_listed_with_their_first_line(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, sys.path)))
    result = pytester.runpytest_subprocess(
        "-p", "firmware_sim.pytest_plugin", "--fixtures", timeout=60
    )
    result.stdout.fnmatch_lines(["dynamixel_simulator*", "*Start simulators*", "stepped_bus*"])


def test_pytest_finds_it_by_itself(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Through the entry point that the package installs."""
    monkeypatch.delenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", raising=False)
    monkeypatch.delenv("PYTEST_PLUGINS", raising=False)
    pytester.makepyfile("def test_it(stepped_bus):\n    assert stepped_bus('ax-12a:1').bus\n")
    result = pytester.runpytest_subprocess("-p", "no:cacheprovider", timeout=100)
    result.assert_outcomes(passed=1)
