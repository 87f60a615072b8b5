"""Triangle meshes of heightfields: STL, PLY and OBJ.

Where the vertices are the points of a grid, they are taken as they are; else the mesh is sampled on
a grid, about one point for each vertex. A mesh that has two heights above one place is refused.
"""

import re
from pathlib import Path

import numpy as np

from surfaces.facet import Array
from surfaces.files._scan import MOST_POINTS, FileError, Scan, check_size

SUFFIXES = (".stl", ".ply", ".obj")
UNEVEN = 1e-3
"""Of a step: how far the vertices of a grid may be out of line, for single precision's sake."""

STL_HEADER, STL_TRIANGLE = 84, 50
"""Bytes."""


def read(path: Path) -> Scan:
    """The mesh's heights; the unit is the file's."""
    vertices, faces = _load(path)
    check_size(len(vertices))
    if not np.isfinite(vertices).all():
        raise FileError("it has vertices that are not finite")
    _refuse_overhangs(vertices, faces)
    return _grid(vertices) or _sampled(vertices, faces)


def _load(path: Path) -> tuple[Array, Array]:
    import trimesh

    kind = path.suffix.lower()[1:]
    with open(path, "rb") as file:
        start = file.read(4096)
        _check_counts(kind, start, path.stat().st_size)
        file.seek(0)
        try:
            # `process`: the same vertex of several triangles becomes one.
            mesh = trimesh.load_mesh(file, file_type=kind, process=True, skip_materials=True)
            vertices, faces = np.asarray(mesh.vertices, float), np.asarray(mesh.faces)
        except Exception as error:
            raise FileError(f"trimesh makes no mesh of it ({error})") from None
    if len(faces) == 0 or vertices.ndim != 2:
        raise FileError("it holds no triangles")
    return vertices, faces


def _check_counts(kind: str, start: bytes, size: int) -> None:
    """Refuse a header that promises what the file cannot hold, before memory is set aside."""
    counts = [int(n) for n in re.findall(rb"^element \w+ (\d{1,18})\s", start, re.MULTILINE)]
    if kind == "ply" and max(counts, default=0) > min(size, 4 * MOST_POINTS):
        raise FileError(f"its header promises {max(counts)} elements, and it has {size} bytes")
    if kind == "stl" and not start.lstrip().startswith(b"solid"):
        number = int.from_bytes(start[80:STL_HEADER], "little")
        if size != STL_HEADER + STL_TRIANGLE * number:
            raise FileError(
                f"its header promises {number} triangles, which are "
                f"{STL_HEADER + STL_TRIANGLE * number} bytes, and it has {size}"
            )


def _refuse_overhangs(vertices: Array, faces: Array) -> None:
    corners = vertices[faces]
    (ax, ay), (bx, by) = ((corners[:, k] - corners[:, 0])[:, :2].T for k in (1, 2))
    area = ax * by - ay * bx
    # Triangles seen from the side have rounding's sign.
    rounding = 1e-6 * np.abs(area).mean()
    up, down = np.count_nonzero(area > rounding), np.count_nonzero(area < -rounding)
    if min(up, down):
        raise FileError(
            f"{min(up, down)} of its {len(faces)} triangles face the other way than the rest: it "
            "overhangs, or is closed, and is no heightfield"
        )
    if max(up, down) == 0:
        raise FileError("it stands upright: no triangle of it is seen from above")


def _axis(x: Array) -> tuple[Array, float, int] | None:
    """Numbers of the places `x` on a grid, its step and its points; None if they are on none."""
    values = np.unique(x)
    # The gaps between rounded values of one place are far smaller than a step.
    gaps = np.diff(values)
    if gaps.size == 0:
        return None
    rough = gaps[gaps > gaps.max() / 2]
    number = round(float(values[-1] - values[0]) / float(rough.mean()))
    if not 0 < number < len(x):
        return None
    step = float(values[-1] - values[0]) / number
    place = (x - values[0]) / step
    index = np.rint(place).astype(np.int64)
    return None if np.abs(place - index).max() > UNEVEN else (index, step, number + 1)


def _grid(vertices: Array) -> Scan | None:
    """The vertices as a grid, if they are one."""
    along_x, along_y = _axis(vertices[:, 0]), _axis(vertices[:, 1])
    if along_x is None or along_y is None:
        return None
    (i, step_x, rows), (j, step_y, columns) = along_x, along_y
    if rows * columns != len(vertices):
        return None
    heights = np.full((rows, columns), np.nan)
    heights[i, j] = vertices[:, 2]
    return None if np.isnan(heights).any() else Scan(heights, (step_x, step_y))


def _sampled(vertices: Array, faces: Array) -> Scan:
    """Heights on a grid inside the mesh's rectangle; NaN where the mesh has a hole."""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    low, size = vertices[:, :2].min(axis=0), np.ptp(vertices[:, :2], axis=0)
    step = float(np.sqrt(size.prod() / len(vertices)))
    counts = np.maximum(size / step, 1).astype(int)
    check_size(*counts)
    x, y = (low[k] + (np.arange(counts[k]) + 0.5) * size[k] / counts[k] for k in (0, 1))
    # In units of the step about the origin, which single precision serves best.
    centre = np.append(low + size / 2, vertices[:, 2].mean())
    scene = EmbreeScene(robust=True)
    TriangleMesh(scene, ((vertices - centre) / step).astype(np.float32), faces.astype(np.int32))
    top = (vertices[:, 2].max() - centre[2]) / step + 1
    heights = np.full(tuple(counts), np.nan)
    for i, place in enumerate(x):
        o = np.empty((len(y), 3))
        o[:, 0], o[:, 1], o[:, 2] = (place - centre[0]) / step, (y - centre[1]) / step, top
        d = np.broadcast_to(np.array([0, 0, -1], np.float32), o.shape)
        hit = scene.run(o.astype(np.float32), np.ascontiguousarray(d), query="INTERSECT")
        met = np.flatnonzero(hit >= 0)
        heights[i, met] = _on_planes(vertices, faces[hit[met]], place, y[met])
    note = "its vertices are on no grid, and it was sampled on one, about a point for each vertex"
    return Scan(heights, (float(size[0] / counts[0]), float(size[1] / counts[1])), notes=(note,))


def _on_planes(vertices: Array, faces: Array, x: float, y: Array) -> Array:
    """Heights (n,) of the planes of triangles above places, in double precision."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    m = np.cross(b - a, c - a)
    return a[:, 2] - (m[:, 0] * (x - a[:, 0]) + m[:, 1] * (y - a[:, 1])) / m[:, 2]
