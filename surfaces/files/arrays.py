"""NumPy's files: an array of heights (.npy), or the only one among several (.npz).

Headers are read before anything else, and nothing is unpickled, so that a file can neither run
code nor ask for more memory than it is allowed.
"""

import zipfile
from pathlib import Path
from typing import IO, Any

import numpy as np

from surfaces.facet import Array
from surfaces.files._scan import FileError, Scan, check_size

SUFFIXES = (".npy", ".npz")
STEP = "step"
"""Name of an array in an .npz file that holds the distance of the points, one for all or two."""


def read(path: Path) -> Scan:
    """heights[i, j] as the array has them."""
    with open(path, "rb") as file:
        if path.suffix.lower() == ".npy":
            return Scan(_array(file, path.stat().st_size))
        return _archive(file)


def _archive(file: IO[bytes]) -> Scan:
    with zipfile.ZipFile(file) as archive:
        members = {m.filename.removesuffix(".npy"): m for m in archive.infolist()}
        shapes = {}
        for name, member in members.items():
            with archive.open(member) as stream:
                shapes[name] = _header(stream)[0]
        grids = [name for name, shape in shapes.items() if len(shape) == 2]
        if len(grids) != 1:
            raise FileError(
                f"its arrays {_listed(shapes)} are of the shapes {_listed(shapes.values())}: one "
                "of two dimensions is wanted, the heights"
            )
        found = {
            name: _member(archive, members[name])
            for name in (grids[0], STEP)
            if name in members and np.prod(shapes[name], dtype=object) > 0
        }
    step = found.get(STEP)
    if step is not None and step.size not in (1, 2):
        raise FileError(f"its array `{STEP}` has {step.size} values: one or two are wanted")
    pair = None if step is None else (float(step.flat[0]), float(step.flat[-1]))
    return Scan(found[grids[0]], pair)


def _member(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> Array:
    with archive.open(member) as stream:
        return _array(stream, member.file_size)


def _array(stream: IO[bytes], size: int) -> Array:
    """The array of a stream of so many bytes, as floats."""
    shape, fortran, dtype, header = _header(stream)
    if len(shape) <= 2:
        check_size(*shape)
    expected = header + int(np.prod(shape, dtype=object)) * dtype.itemsize
    if size != expected:
        raise FileError(
            f"its header promises {expected} bytes, and it has {size}: it is cut or damaged"
        )
    data = np.frombuffer(stream.read(expected - header), dtype)
    return data.reshape(shape, order="F" if fortran else "C").astype(float, order="C")


def _header(stream: IO[bytes]) -> tuple[tuple[int, ...], bool, Any, int]:
    """Shape, order, type and the header's length. Raises FileError where it is not of numbers."""
    version = np.lib.format.read_magic(stream)
    reader = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }.get(version)
    if reader is None:
        raise FileError(f"it is of version {version} of its format, which has no heights")
    shape, fortran, dtype = reader(stream)
    if dtype.hasobject:
        raise FileError("it holds Python objects, which are never unpickled here")
    if dtype.kind not in "fiu":
        raise FileError(f"its values are of the type {dtype}: real numbers are wanted")
    return shape, fortran, dtype, stream.tell()


def _listed(values: Any) -> str:
    words = [str(v) for v in values]
    return ", ".join(words[:5]) + (", ..." if len(words) > 5 else "")
