"""What a file of heights comes to, and what is refused of any."""

from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from surfaces.facet import Array

MOST_POINTS = 1 << 26
"""8192 by 8192: half a gigabyte of heights, and far more than is ever traced at once."""


class FileError(ValueError):
    """A file that holds no heights that can be used; the message says why, without its name."""


@dataclass(frozen=True)
class Scan:
    """Heights as a file has them."""

    heights: Array
    """heights[i, j] at x = i step_x, y = j step_y; NaN where nothing was measured."""
    step: tuple[float, float] | None = None
    """Distance of the points along x and y, where the file says it."""
    unit: float | None = 1.0
    """Of the heights, in that of the step; None where the file has grey levels and no heights."""
    notes: tuple[str, ...] = ()
    """Sentences on what was made of the file."""


def check_size(*shape: int) -> None:
    """Refuse more points than are taken, before any of them is read. Raises FileError."""
    if np.prod(np.array(shape, object)) > MOST_POINTS:
        raise FileError(
            f"it says that it has {' x '.join(map(str, shape))} points; "
            f"at most {MOST_POINTS} are read"
        )


def extra(package: str, suffix: str) -> Any:
    """A package that not everybody has. Raises FileError with what to install."""
    try:
        return import_module(package)
    except ImportError:
        raise FileError(
            f"files {suffix} are read with {package}: `pip install 'msbsdf[metrology]'`"
        ) from None


def as_seen(rows: Array) -> Array:
    """Heights [i, j] from rows of points of which the first is the farthest, as on a picture: x
    goes to the right, and y up."""
    return np.ascontiguousarray(rows[::-1].T, float)
