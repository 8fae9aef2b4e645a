"""Source written instead of arithmetic done: the same numbers, fewer operations."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from armsyn.kernels.expressions import Source, Value

NUMBERS = st.sampled_from([0.0, 1.0, -1.0, 0.5, -0.3]) | st.floats(-3, 3)


# ruff: noqa: S307 - what is evaluated was written here


def evaluated(source: Source, value: Value, **variables: float) -> float:
    for line in source.needed_for([value]):
        variables[line.name] = eval(line.expression, {"math": math}, variables)
    return float(eval(value.text, {}, variables))


@st.composite
def formulas(draw: st.DrawFn, depth: int = 4) -> str:
    """Random sums, differences and products of variables and numbers, as Python."""
    if depth == 0 or draw(st.booleans()):
        return draw(st.sampled_from(["x", "y", "z"]) | NUMBERS.map("N({!r})".format))
    left, right = draw(formulas(depth - 1)), draw(formulas(depth - 1))
    sign = draw(st.sampled_from(["", "-"]))
    return f"({sign}{left} {draw(st.sampled_from('+-*'))} {right})"


@given(formulas(), st.tuples(*[st.floats(-2, 2)] * 3))
def test_what_is_written_is_what_was_meant(formula: str, point: tuple[float, ...]) -> None:
    plain = dict(zip("xyz", point, strict=True))
    expected = eval(formula, {"N": float}, plain)
    source = Source()
    value = eval(formula, {"N": source.number}, {name: source.value(name) for name in plain})
    assert math.isclose(evaluated(source, value, **plain), expected, rel_tol=1e-12, abs_tol=1e-12)


def test_zeros_ones_signs_and_repetitions_cost_nothing() -> None:
    source = Source()
    x, y, one, none = source.value("x"), source.value("y"), source.number(1), source.number(0)
    assert (x * one, x + none, x * none, x - x) == (x, x, none, none)
    minus = -x
    assert (x * -one, -minus) == (minus, x)
    assert source.lines == []
    assert x * y == y * x
    assert x + y == y + x
    assert minus * (-y) == x * y
    assert [line.kind for line in source.lines] == ["*", "+"]


def test_matrices_of_values_multiply_as_matrices_do() -> None:
    source = Source()
    quarter = np.vectorize(source.number, otypes=[object])([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    vector = np.array([source.value(name) for name in "xyz"])
    assert [value.text for value in quarter @ vector] == ["-y", "x", "z"]
    assert source.lines == []
    length = source.call("math.sqrt", vector @ vector)
    assert evaluated(source, length, x=2.0, y=3.0, z=6.0) == 7.0


def test_only_what_is_needed_is_kept() -> None:
    source = Source()
    x, y = source.value("x"), source.value("y")
    wanted = x + y
    _ = x * y
    assert [line.kind for line in source.needed_for([wanted])] == ["+"]
