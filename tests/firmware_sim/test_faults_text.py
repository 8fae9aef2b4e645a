"""Faults out of text and TOML: what is taken, and how the rest is refused."""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from firmware_sim.errors import FaultError
from firmware_sim.faults.argument import Argument, ArgumentError
from firmware_sim.faults.parsing import parse_fault
from firmware_sim.faults.registry import KINDS, list_faults
from firmware_sim.faults.scenario import (
    FILE_SIZE_CAP,
    ScenarioError,
    check_seed,
    parse_scenario,
    read_scenario,
)
from firmware_sim.faults.spec import FaultKind
from tests.firmware_sim.faults_bench import FaultBench

T = TypeVar("T")


def test_a_fault_has_the_arguments_given_and_the_defaults_of_the_others() -> None:
    spec = parse_fault("crc-error:id=3,probability=0.01,after=2,for=1.5")
    assert spec.kind.name == "crc-error"
    assert spec.servo_id == 3
    assert spec.number("probability") == 0.01
    assert spec.number("bits") == 1
    assert spec.optional("for") == 1.5
    assert spec.optional("count") is None
    assert spec.begin(start=100.0, now=107.0) == 109.0


def test_at_counts_from_the_start_and_never_lies_in_the_past() -> None:
    spec = parse_fault("reboot:at=5")
    assert spec.begin(start=100.0, now=100.0) == 105.0
    assert spec.begin(start=100.0, now=107.0) == 107.0


@pytest.mark.parametrize(
    ("text", "field", "words"),
    [
        ("crc-eror", "name", "crc-error"),
        ("", "name", "no fault ''"),
        ("crc-error:", "name", "no argument behind the colon"),
        ("crc-error:probabilty=1", "probabilty", "probability"),
        ("crc-error:id", "id", "not of the form key=value"),
        ("crc-error:id=3,id=4", "id", "given twice"),
        ("crc-error:id=253", "id", "a whole number from 0 to 252"),
        ("crc-error:id=1.5", "id", "a whole number"),
        ("crc-error:id=-1", "id", "a whole number"),
        ("crc-error:probability=1.1", "probability", "a number from 0 to 1"),
        ("crc-error:for=nan", "for", "a number"),
        ("crc-error:for=inf", "for", "a number"),
        ("crc-error:for=\u0663", "for", "a number"),
        ("crc-error:for=1_0", "for", "a number"),
        ("crc-error:for=0", "for", "0.001"),
        ("crc-error:for=1e99", "for", "a number"),
        ("crc-error:at=1,after=1", "after", "at or after, not both"),
        ("crc-error:to=everybody", "to", "one of client, servos"),
        ("noise:bytes=99999999999999999999", "bytes", "a whole number"),
        ("missing-servo", "id", "needs id"),
        ("duplicate-id:id=1", "as", "needs as"),
        ("unplugged:id=1", "id", "takes no argument 'id'"),
        ("x" * 2000, "name", "at most 1000"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(text: str, field: str, words: str) -> None:
    with pytest.raises(ArgumentError) as caught:
        parse_fault(text)
    assert caught.value.field == field
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300
    assert caught.value.exit_status == 2


_ALPHABET = st.characters(codec="utf-8")
_NAMES = st.sampled_from(sorted(KINDS)) | st.text(_ALPHABET, max_size=20)
_FIELDS = st.sampled_from(["id", "at", "for", "count", "probability", "to", "bytes"]) | st.text(
    _ALPHABET, max_size=8
)
_VALUES = st.floats().map(str) | st.integers().map(str) | st.text(_ALPHABET, max_size=12)
_TEXTS = st.builds(
    lambda name, arguments: f"{name}:" + ",".join(f"{key}={value}" for key, value in arguments),
    _NAMES,
    st.lists(st.tuples(_FIELDS, _VALUES), max_size=4),
)


@given(_TEXTS | st.text(_ALPHABET, max_size=50))
@example("crc-error:for=1e5")
@example("noise:bytes=²")
@example("noise:bytes=٣")
@example("a:b:c=d=e,,")
def test_hostile_text_is_a_fault_or_one_line(text: str) -> None:
    result = _outcome(lambda: parse_fault(text))
    if isinstance(result, str):
        assert len(result.splitlines()) == 1
        assert result.isprintable()
    else:
        assert parse_fault(result.text).given == result.given


def _outcome(act: Callable[[], T]) -> T | str:
    """What comes of it, or the one line that refuses it."""
    try:
        return act()
    except FaultError as error:
        return str(error)


@st.composite
def _whole_faults(draw: st.DrawFn) -> str:
    """A fault with any of its arguments, each within its bounds."""
    kind = KINDS[draw(st.sampled_from(sorted(KINDS)))]
    parts = []
    for argument in kind.all_arguments.values():
        if argument.name == "after":
            continue
        needed = argument.required or (argument.name == "id" and kind.needs_servo)
        if needed or draw(st.booleans()):
            parts.append(f"{argument.name}={draw(_value_of(argument))}")
    return f"{kind.name}:{','.join(parts)}" if parts else kind.name


def _value_of(argument: Argument) -> st.SearchStrategy[object]:
    if argument.choices:
        return st.sampled_from(argument.choices)
    if argument.whole:
        return st.integers(round(argument.low), round(argument.high))
    return st.floats(argument.low, argument.high).map(lambda value: f"{value:.12f}")


@given(_whole_faults())
def test_every_fault_takes_every_value_it_says_it_takes(text: str) -> None:
    spec = parse_fault(text)
    assert parse_fault(spec.text).given == spec.given


@pytest.mark.parametrize("kind", KINDS.values(), ids=lambda kind: kind.name)
def test_the_list_names_each_fault_with_its_row_and_arguments(kind: FaultKind) -> None:
    lines = list_faults().splitlines()
    rows = ", ".join(map(str, kind.rows))
    at = next(n for n, line in enumerate(lines) if line.startswith(f"{kind.name} [{rows}]: "))
    for argument, line in zip(kind.arguments, lines[at + 1 :], strict=False):
        assert line.strip().startswith(f"{argument.name}: ")
        assert argument.unit in line


def test_every_row_of_the_bus_and_of_servos_has_a_fault() -> None:
    on_the_bus_or_in_a_servo = {*range(1, 11), *range(12, 21), 24, 25, 35, 40}
    assert {row for kind in KINDS.values() for row in kind.rows} == on_the_bus_or_in_a_servo


def test_a_scenario_says_what_and_when(tmp_path: Path) -> None:
    file = tmp_path / "scenario.toml"
    file.write_text(
        'seed = 7\n[[fault]]\nname = "reboot"\nat = 2\nid = 3\n'
        '[[fault]]\nname = "noise"\nplace = "after"\n'
    )
    scenario = read_scenario(file)
    assert scenario.seed == 7
    assert [spec.text for spec in scenario.faults] == ["reboot:at=2,id=3", "noise:place=after"]


def test_an_empty_scenario_is_one() -> None:
    assert parse_scenario(b"", "x.toml").faults == ()


@pytest.mark.parametrize(
    ("content", "table", "field", "words"),
    [
        ("seed = -1", 0, "seed", "seed"),
        ("seed = true", 0, "seed", "seed"),
        ("seed = 1.0", 0, "seed", "seed"),
        ("sed = 1", 0, "sed", "unknown field 'sed'"),
        ("fault = 3", 0, "fault", "[[fault]]"),
        ("[fault]\nname='reboot'", 0, "fault", "[[fault]]"),
        ("fault = [3]", 1, "", "table 1: is not a table"),
        ("[[fault]]\nat = 1", 1, "name", "table 1: needs the field 'name'"),
        ("[[fault]]\nname = 3", 1, "name", "table 1: needs the field 'name'"),
        (
            "[[fault]]\nname = 'rebot'",
            1,
            "name",
            "table 1: no fault 'rebot' (did you mean reboot?)",
        ),
        ("[[fault]]\nname='reboot'\n[[fault]]\nname='reboot'\nat='1'", 2, "at", "table 2: "),
        ("[[fault]]\nname='reboot'\nat=nan", 1, "at", "at=nan"),
        ("[[fault]]\nname='reboot'\nat=true", 1, "at", "at=True"),
        ("[[fault]]\nname='reboot'\nid=1.0", 1, "id", "id=1.0"),
        ("[[fault]]\nname='reboot'\nwhen=1", 1, "when", "takes no argument 'when'"),
        ("[[fault]]\nname='reboot'\nid=" + "9" * 5000, 0, "", "is not TOML"),
        ("[[fault]]\nname='reboot'\nid=0x" + "9" * 5000, 1, "id", "id=a huge number"),
        ("[[fault]\n", 0, "", "is not TOML"),
        ("x = " + "[" * 5000, 0, "", "is not TOML"),
    ],
)
def test_a_malformed_scenario_is_refused_with_file_table_and_field(
    content: str, table: int, field: str, words: str
) -> None:
    with pytest.raises(ScenarioError) as caught:
        parse_scenario(content.encode(), "bad.toml")
    error = caught.value
    assert (error.file, error.table, error.field) == ("bad.toml", table, field)
    assert words in str(error)
    assert str(error).startswith("bad.toml")
    assert len(str(error).splitlines()) == 1


def test_scenarios_have_a_size_and_a_number_of_faults(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="at most 1000"):
        parse_scenario(b"[[fault]]\nname='reboot'\n" * 1001, "long.toml")
    large = tmp_path / "large.toml"
    large.write_bytes(b"#" * (FILE_SIZE_CAP + 1))
    with pytest.raises(ScenarioError, match="larger than"):
        read_scenario(large)
    with pytest.raises(ScenarioError, match="cannot be read"):
        read_scenario(tmp_path)
    with pytest.raises(ScenarioError, match="is not TOML"):
        parse_scenario(b"\xff\xfe", "binary.toml")


@given(st.binary(max_size=200) | st.text(_ALPHABET, max_size=200).map(str.encode))
def test_hostile_files_are_scenarios_or_one_line(content: bytes) -> None:
    result = _outcome(lambda: parse_scenario(content, "any.toml"))
    if isinstance(result, str):
        assert len(result.splitlines()) == 1
    else:
        assert len(result.faults) == len(tomllib.loads(content.decode()).get("fault", []))


@pytest.mark.parametrize("seed", [-1, 2**63])
def test_seeds_have_bounds(seed: int) -> None:
    assert check_seed(2**63 - 1) == 2**63 - 1
    with pytest.raises(FaultError, match="a seed goes from 0"):
        check_seed(seed)


def test_a_scenarios_fault_for_a_servo_that_is_not_there_names_its_table() -> None:
    faults = parse_scenario(b"[[fault]]\nname='reboot'\n[[fault]]\nname='reboot'\nid=9\n", "s.toml")
    with pytest.raises(FaultError, match=r"s\.toml: \[\[fault\]\] table 2: reboot: no servo 9"):
        FaultBench().simulation.inject(faults.faults[1])
