"""What people have heights in: a file for each family of formats.

A module has SUFFIXES and `read`, which returns a `Scan`, or raises FileError with a reason. A
format is known by its suffix, and the content must agree.
"""

from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import Any

import numpy as np

from surfaces.files._missing import filled
from surfaces.files._scan import FileError, Scan

FORMATS = {
    suffix: module.name
    for module in iter_modules(__path__)
    if not module.name.startswith("_")
    for suffix in import_module(f"{__name__}.{module.name}").SUFFIXES
}
"""Module of each suffix."""

MAGIC = {
    b"\x93NUMPY": (".npy",),
    b"PK\x03\x04": (".npz",),
    b"\x89PNG\r\n\x1a\n": (".png",),
    b"II*\x00": (".tif", ".tiff"),
    b"MM\x00*": (".tif", ".tiff"),
    b"ply": (".ply",),
}
"""What files begin with, and the suffixes that they then have."""

EXTRAS = ("instruments", "standards")
"""Modules that need packages beside the project's own."""

LONGEST = 1 << 32
"""Bytes of a file that is looked into."""


def read(
    path: str | Path,
    step: float | tuple[float, float] | None = None,
    height_unit: float | None = None,
) -> Scan:
    """The heights of a file and the distance of their points, in one unit, and without gaps.

    `step` is the distance of the points along x and y, and `height_unit` what a height of 1, or one
    grey level, is in the unit of `step`; each is wanted where the file does not say it, and
    replaces what it says. Raises ValueError, with a sentence, for what cannot be used.
    """
    path = Path(path)
    try:
        scan = _module(path).read(path)
        heights, notes = filled(_checked(scan.heights))
        unit = _unit(scan, height_unit)
        return Scan(heights * unit, _step(scan, step), 1.0, (*scan.notes, *notes))
    except FileError as error:
        raise ValueError(f"{path}: {error}.") from None
    except Exception as error:
        # Readers raise whatever comes of a damaged file: of struct, zlib, syntax, memory, ...
        reason = (str(error) or type(error).__name__).splitlines()[0].rstrip(".")
        kind = path.suffix.lower()
        raise ValueError(f"{path} cannot be read as a {kind} file: {reason}.") from None


def _module(path: Path) -> Any:
    """What reads a file. Raises FileError where its suffix or content is of no format."""
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise FileError(f"heights are read from {', '.join(sorted(FORMATS))}, not from {suffix!r}")
    with open(path, "rb") as file:
        start = file.read(16)
    if not start:
        raise FileError("it is empty")
    if path.stat().st_size > LONGEST:
        raise FileError(f"it has {path.stat().st_size} bytes; at most {LONGEST} are read")
    # Instruments have formats that are archives or pictures inside.
    known = {s for suffixes in MAGIC.values() for s in suffixes}
    found = next((s for magic, s in MAGIC.items() if start.startswith(magic)), None)
    if suffix in known and suffix not in (found or ()):
        raise FileError(f"its content is {_words(found)}, and not that of a {suffix} file")
    if found and suffix not in known and FORMATS[suffix] not in EXTRAS:
        raise FileError(f"its content is {_words(found)}, and not that of a {suffix} file")
    return import_module(f"{__name__}.{FORMATS[suffix]}")


def _words(suffixes: tuple[str, ...] | None) -> str:
    return f"that of a {suffixes[0]} file" if suffixes else "of another kind"


def _checked(heights: Any) -> Any:
    if heights.ndim != 2 or min(heights.shape) < 4:
        shape = " x ".join(map(str, heights.shape))
        raise FileError(f"its heights are {shape}: a grid of at least 4 x 4 points is wanted")
    if np.isinf(heights).any():
        raise FileError(f"{np.count_nonzero(np.isinf(heights))} of its heights are infinite")
    known = heights[~np.isnan(heights)]
    if known.size and known.min() == known.max():
        raise FileError(f"all its heights are {known[0]:g}: a surface without roughness")
    return heights


def _unit(scan: Scan, height_unit: float | None) -> float:
    if height_unit is None and scan.unit is None:
        raise FileError(
            "it has grey levels, and does not say how high one is: give the height unit in that of "
            "the step, on the command line --height-unit, such as 2nm, or a number of metres"
        )
    unit = (scan.unit or 1.0) if height_unit is None else height_unit
    if not 0 < unit < np.inf:
        raise FileError(f"the height unit is {unit}: a finite number above 0 is wanted")
    return unit


def _step(scan: Scan, step: float | tuple[float, float] | None) -> tuple[float, float]:
    if step is None and scan.step is None:
        raise FileError(
            "it does not say how far its points are apart: give the step along x and y in the unit "
            "of the heights, on the command line --step, such as 2um, or a number of metres"
        )
    given = np.array(scan.step if step is None else step, float).ravel()
    if given.size not in (1, 2) or not all(0 < s < np.inf for s in given):
        raise FileError(
            f"the step is {step or scan.step}: one or two finite numbers above 0 are wanted"
        )
    return float(given[0]), float(given[-1])
