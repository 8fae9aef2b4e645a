"""Text files read line by line, within bounds: their size, their lines, their numbers."""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NoReturn

import numpy as np

from armsyn.errors import FormatError
from armsyn.motion.formats.files import check_size
from armsyn.motion.motion import FloatArray

LARGEST_FILE = 256 * 2**20
LONGEST_LINE = 2**20
"""Bytes: a thousand joints of six channels with 20 digits are an eighth of it."""

GAPS = frozenset({"", "nan"})
"""What a cell of a table says, lower case, where nothing was measured."""


class Lines:
    """The lines of a text file, with the number of the last one read for messages.

    Parameters
    ----------
    path : Path
        UTF-8, with or without a byte order mark; lines end with LF or CRLF.

    Raises
    ------
    FormatError
        When it is missing, empty or larger than `LARGEST_FILE`.
    """

    def __init__(self, path: Path) -> None:
        check_size(path, LARGEST_FILE)
        self.path = path
        self.number = 0
        self._read = self._lines()

    def __iter__(self) -> Iterator[str]:
        return self._read

    def _lines(self) -> Iterator[str]:
        try:
            with self.path.open("rb") as file:
                while line := file.readline(LONGEST_LINE):
                    self.number += 1
                    if len(line) == LONGEST_LINE:
                        self.fail(f"longer than {LONGEST_LINE} bytes")
                    try:
                        yield line.decode("utf-8-sig" if self.number == 1 else "utf-8")
                    except UnicodeDecodeError as error:
                        self.fail(f"byte {error.start} is not UTF-8 text")
        except OSError as error:
            raise FormatError(f"{self.path}: cannot read it: {error.strerror}") from error

    def close(self) -> None:
        """Close the file before its end."""
        self._read.close()  # type: ignore[attr-defined]  # it is a generator

    def next(self, wanted: str) -> str:
        """Return the next line.

        Raises
        ------
        FormatError
            When there is none: the message says what was wanted.
        """
        line = next(self._read, None)
        if line is None:
            raise FormatError(f"{self.path}: line {self.number + 1}: the file was cut: no {wanted}")
        return line

    def fail(self, what: str) -> NoReturn:
        """Raise what is wrong with the last line read."""
        raise FormatError(f"{self.path}: line {self.number}: {what}")

    def numbers(self, cells: Sequence[str]) -> list[float]:
        """Return finite numbers.

        Raises
        ------
        FormatError
            When one is not a finite number.
        """
        try:
            values = list(map(float, cells))
        except ValueError:
            values = [math.nan]
        # float() also takes '1_000' and the digits of other scripts
        text = "".join(cells)
        if not math.isfinite(sum(values)) or not text.isascii() or "_" in text:
            for cell in cells:
                if not is_number(cell):
                    self.fail(f"'{cell[:40]}' is not a finite number")
        return values

    def numbers_or_gaps(self, cells: Sequence[str]) -> list[float]:
        """Return finite numbers; NaN for an empty cell or ``nan``.

        Raises
        ------
        FormatError
            When a cell is neither.
        """
        gaps = [cell.strip().lower() in GAPS for cell in cells]
        if not any(gaps):
            return self.numbers(cells)
        filled = ["0" if gap else cell for cell, gap in zip(cells, gaps, strict=True)]
        values = zip(self.numbers(filled), gaps, strict=True)
        return [math.nan if gap else value for value, gap in values]

    def rows(self, width: int, most: int) -> FloatArray:
        """Return all further lines as rows of numbers separated by blanks; blank lines are none.

        They are parsed a block at a time by numpy, and one by one only where that fails, to say
        which line is wrong.

        Parameters
        ----------
        width : int
            Numbers a row.
        most : int
            Rows that are allowed.

        Returns
        -------
        array, shape (rows, width)

        Raises
        ------
        FormatError
            When a row has another count of numbers or one that is not finite, or there are more
            rows, or fewer than two.
        """
        values = array("d")
        block: list[tuple[int, str]] = []
        held = 0
        for line in self:
            if line.isspace():
                continue
            block.append((self.number, line))
            held += len(line)
            if len(values) // max(width, 1) + len(block) > most:
                self.fail(f"more than the {most} frames that there should be")
            if held > LONGEST_LINE:
                values.extend(self._block(block, width))
                block, held = [], 0
        values.extend(self._block(block, width))
        return self.table(values, width)

    def _block(self, block: list[tuple[int, str]], width: int) -> array[float]:
        if not block:
            return array("d")
        try:
            numbers = np.loadtxt([line for _, line in block], comments=None, ndmin=2)
        except ValueError:
            numbers = np.empty((0, 0))
        if numbers.shape == (len(block), width) and np.isfinite(numbers).all():
            return array("d", numbers.tobytes())
        values = array("d")
        for number, line in block:
            self.number, cells = number, line.split()
            if len(cells) != width:
                self.fail(f"{len(cells)} numbers, expected {width}")
            values.extend(self.numbers(cells))
        return values

    def table(self, values: array[float], width: int) -> FloatArray:
        """Return the numbers of all rows as an array, shape (rows, width).

        Raises
        ------
        FormatError
            When there are fewer than two rows: no motion.
        """
        if len(values) < 2 * width or width == 0:
            raise FormatError(
                f"{self.path}: line {self.number + 1}: the file was cut: fewer than two frames"
            )
        return np.frombuffer(values, dtype=np.float64).reshape(-1, width)

    def whole(self, cell: str, most: int) -> int:
        """Return a whole number from 0 to `most`.

        Raises
        ------
        FormatError
            When it is none, or greater.
        """
        if not (cell.isascii() and cell.isdigit() and len(cell) < 19) or int(cell) > most:
            self.fail(f"'{cell[:40]}' is not a whole number up to {most}")
        return int(cell)


def is_number(cell: str) -> bool:
    """Return whether a cell is a finite number, written in ASCII without underscores."""
    if not cell.isascii() or "_" in cell:
        return False
    try:
        return math.isfinite(float(cell))
    except ValueError:
        return False
