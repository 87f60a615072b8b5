"""Grids of numbers as text: a line for each row of points, split by blanks, commas or semicolons.

The first line is the farthest row, as on a picture. Lines that begin with # are left out, and
`nan` is a point that was not measured.
"""

import warnings
from itertools import islice
from pathlib import Path

import numpy as np

from surfaces.files._scan import FileError, Scan, as_seen, check_size

SUFFIXES = (".txt", ".csv", ".dat", ".asc")
BYTES_PER_NUMBER = 2
"""At least: a digit, and what splits it from the next."""


def read(path: Path) -> Scan:
    """The grid, all of whose lines have as many numbers."""
    with open(path, encoding="utf-8-sig") as file:
        lines = (text for line in file if (text := line.strip()) and not text.startswith("#"))
        first = next(lines, None)
        if first is None:
            raise FileError("there is no line of numbers in it")
        split = next((c for c in ",;" if c in first), None)
        columns = len(first.split(split))
        if columns < 4 and len(list(islice(lines, 4))) == 4:
            raise FileError(f"its lines have {columns} numbers: rows of a grid are wanted")
    check_size(min(path.stat().st_size // BYTES_PER_NUMBER, _lines(path) * columns))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rows = np.loadtxt(path, delimiter=split, comments="#", ndmin=2, encoding="utf-8-sig")
    return Scan(as_seen(rows))


def _lines(path: Path) -> int:
    with open(path, "rb") as file:
        return sum(chunk.count(b"\n") for chunk in iter(lambda: file.read(1 << 20), b"")) + 1
