"""Arithmetic written down instead of done: straight-line source, folded and counted.

Values are numbers known when the source is written, or names of local variables. What is known
is worked out at once, products with 0 and 1 vanish, signs are carried along until a sum takes
them, and nothing is computed twice. Arrays of values (numpy, ``dtype=object``) multiply as
matrices do, so formulas read as formulas.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple


class Line(NamedTuple):
    """One assignment: the variable, the expression, the variables in it, what kind it is."""

    name: str
    expression: str
    operands: tuple[str, ...]
    kind: str


@dataclass
class Source:
    """Straight-line source as it grows; `lines` holds every assignment in order."""

    lines: list[Line] = field(default_factory=list)
    _known: dict[str, str] = field(default_factory=dict)

    def value(self, name: str) -> Value:
        """Return a variable that the surrounding source defines."""
        return Value(self, name, 1.0)

    def number(self, number: float) -> Value:
        """Return a number known now."""
        return Value(self, "", float(number))

    def assign(self, expression: str, operands: tuple[str, ...], kind: str) -> Value:
        """Write an assignment, unless the same expression has a name already."""
        name = self._known.get(expression)
        if name is None:
            name = self._known[expression] = f"v{len(self.lines)}"
            self.lines.append(Line(name, expression, operands, kind))
        return self.value(name)

    def load(self, place: str) -> Value:
        """Read an array's element, once."""
        return self.assign(place, (), "load")

    def call(self, function: str, *arguments: Value) -> Value:
        """Write a call."""
        named = ", ".join(argument.text for argument in arguments)
        return self.assign(f"{function}({named})", tuple(a.name for a in arguments), function)

    def needed_for(self, results: list[Value]) -> list[Line]:
        """Return the lines that `results` depend on, in order."""
        wanted = {result.name for result in results}
        kept = []
        for line in reversed(self.lines):
            if line.name in wanted:
                kept.append(line)
                wanted.update(line.operands)
        return kept[::-1]


@dataclass(frozen=True)
class Value:
    """A number (`name` is empty) or a variable times a sign.

    Parameters
    ----------
    source : Source
        Where arithmetic with it is written.
    name : str
    factor : float
        The number itself, or 1 or -1.
    """

    source: Source
    name: str
    factor: float

    @property
    def text(self) -> str:
        """The value as source."""
        if not self.name:
            return repr(self.factor)
        return self.name if self.factor > 0 else f"-{self.name}"

    @property
    def is_zero(self) -> bool:
        """Whether it is known to be zero."""
        return not self.name and self.factor == 0.0

    def __neg__(self) -> Value:
        return Value(self.source, self.name, -self.factor)

    def __sub__(self, other: Value) -> Value:
        return self + -other

    def __add__(self, other: Value) -> Value:
        if not (self.name or other.name):
            return self.source.number(self.factor + other.factor)
        if self.is_zero or other.is_zero:
            return other if self.is_zero else self
        if self.name == other.name and self.factor == -other.factor:
            return self.source.number(0.0)
        if self.factor < 0:
            return -(-self + -other) if other.factor < 0 else other + self
        left, right = sorted((self.text, other.text))
        written = f"{self.text} - {(-other).text}" if other.factor < 0 else f"{left} + {right}"
        return self.source.assign(written, (self.name, other.name), "+")

    def __mul__(self, other: Value) -> Value:
        if not (self.name or other.name):
            return self.source.number(self.factor * other.factor)
        if self.is_zero or other.is_zero:
            return self.source.number(0.0)
        for one, another in ((self, other), (other, self)):
            if not one.name and abs(one.factor) == 1.0:
                return another if one.factor > 0 else -another
        left, right = sorted((_magnitude(self), _magnitude(other)))
        product = self.source.assign(f"{left} * {right}", (self.name, other.name), "*")
        return product if self.factor * other.factor > 0 else -product

    def __truediv__(self, other: Value) -> Value:
        return self.source.assign(f"{self.text} / {other.text}", (self.name, other.name), "/")


def _magnitude(value: Value) -> str:
    return value.name or repr(abs(value.factor))
