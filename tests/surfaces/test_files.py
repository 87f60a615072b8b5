"""Files of heights: what is read is what was written, and what is hostile is refused."""

import io
import sys
import zipfile

import numpy as np
import pytest
from PIL import Image

import msbsdf_cli as ms
from surfaces.field import HeightField
from surfaces.files import EXTRAS, FORMATS, read
from surfaces.files._missing import filled

STEP = (2e-6, 3e-6)


@pytest.fixture(scope="module")
def heights():
    """A periodic surface of 24 x 36 points, some micrometres high."""
    x, y = (2 * np.pi * np.arange(n)[:, None] / n for n in (24, 36))
    return 4e-6 * (np.sin(x + 0.3) + np.cos(2 * y.T) * np.cos(x))


def levels(heights, bits):
    low, unit = heights.min(), np.ptp(heights) / (2**bits - 1)
    return np.rint((heights - low) / unit).T[::-1], unit


def write(path, heights, step=STEP):
    """Write heights as the suffix says; what else `read` needs, and the file's precision."""
    suffix, size = path.suffix, np.ptp(heights)
    said = {"step": step}
    if suffix == ".npy":
        np.save(path, heights)
        return said, 0
    if suffix == ".npz":
        np.savez_compressed(path, z=heights, step=step, comment=np.zeros(3))
        return {}, 0
    if suffix == ".csv":
        np.savetxt(path, heights.T[::-1], delimiter=",")
        return said, 1e-15
    if suffix in (".txt", ".dat", ".asc"):
        np.savetxt(path, heights.T[::-1], header="heights in metres")
        return said, 1e-15
    if suffix in (".png", ".tif"):
        grey, unit = levels(heights, 16)
        Image.fromarray(grey.astype(np.uint16)).save(path)
        return said | {"height_unit": unit}, unit
    if suffix == ".tiff":
        Image.fromarray(heights.T[::-1].astype(np.float32)).save(path)
        return said, 1e-7 * size
    import trimesh

    from surfaces.surface import faces

    x, y = np.meshgrid(*(np.arange(n) * s for n, s in zip(heights.shape, step, strict=True)))
    points = np.stack([x.T, y.T, heights], axis=-1).reshape(-1, 3)
    trimesh.Trimesh(points * 1e6, faces(*heights.shape), process=False).export(path)
    return {}, 1e-6


MINE = sorted(suffix for suffix, module in FORMATS.items() if module not in EXTRAS)


@pytest.mark.parametrize("suffix", MINE)
def test_what_is_read_is_what_was_written(suffix, heights, tmp_path):
    path = tmp_path / f"scan{suffix}"
    said, precision = write(path, heights)
    scan = read(path, **said)
    unit = 1e6 if suffix in (".stl", ".ply", ".obj") else 1.0
    np.testing.assert_allclose(scan.step, np.array(STEP) * unit, rtol=1e-5)
    assert scan.heights.shape == heights.shape
    apart = scan.heights - heights * unit
    apart -= apart.mean() if suffix in (".png", ".tif") else 0
    # Half a level either way where heights are levels, and where the lowest of them begins.
    assert np.abs(apart).max() <= precision * 1.01 + 1e-12 * unit


@pytest.fixture(scope="module")
def traced():
    """A periodic field of 72 x 64 points and unequal steps, and its light."""
    square = HeightField.random(alpha=0.7, seed=3, extent=8, cells=9)
    field = HeightField(square.heights[:, :64] * 1e-6, (square.step[0] * 1e-6, 0.25e-6))
    return field, light(field)


def light(field):
    wi = ms.direction(theta=1.0, phi=0.4)
    return ms.simulate(field, ms.Conductor(), wi, rays=32_000, seed=1)


@pytest.mark.parametrize("suffix", [".npy", ".png", ".tif", ".tiff", ".stl", ".ply"])
def test_light_is_that_of_the_field_that_was_written(suffix, traced, tmp_path):
    """The same rays; of 32000, single precision and 65536 levels send a few another way, which
    the error of a difference of so few counts bounds."""
    field, truth = traced
    path = tmp_path / f"scan{suffix}"
    said, _ = write(path, field.heights, field.step)
    read_again = light(HeightField.load(path, **said, periodic=True))
    moved = np.abs(read_again.energy - truth.energy)
    assert moved.max() <= (0 if suffix == ".npy" else 4 * np.sqrt(32) / 32_000)
    assert np.all(moved <= truth.energy_stderr)


def test_an_oblong_period_is_traced_as_a_square_one():
    """Three periods along x are the same surface as one."""
    square = HeightField.random(alpha=0.7, seed=5, extent=8, cells=8)
    oblong = HeightField(np.tile(square.heights, (3, 1)), square.step)
    square = HeightField(square.heights, square.step)
    wi, n = ms.direction(theta=1.4, phi=0.4), 64_000
    a, b = (ms.simulate(f, ms.Conductor(), wi, rays=n, seed=1).energy for f in (square, oblong))
    noise = np.sqrt(2 * a * (1 - a) / n + 2 / n**2)
    assert np.all(np.abs(a - b) < 4 * noise)


def test_a_field_continues_in_its_period_or_by_its_mirror_images(heights, tmp_path):
    path = tmp_path / "scan.npy"
    np.save(path, heights)
    field = HeightField.load(path, step=STEP, periodic=True)
    np.testing.assert_allclose(field.heights, heights - heights.mean(), atol=1e-20)
    tilted = heights + 0.1 * np.arange(24)[:, None] * STEP[0]
    np.save(path, tilted)
    field = HeightField.load(path, step=STEP)
    plane = tilted - field.heights
    assert np.abs(np.diff(plane, 2, axis=0)).max() < 1e-18
    mesh = field.surface.heights
    assert mesh.shape == (46, 70)
    np.testing.assert_array_equal(mesh[1:23], mesh[:23:-1])
    assert field.piece(3, 16) == (3, 64)
    # A mesh of a whole period has its first points at its end once more.
    np.save(path, np.pad(heights, ((0, 1), (0, 1)), mode="wrap"))
    field = HeightField.load(path, step=STEP, periodic=True)
    assert field.heights.shape == heights.shape
    assert "repeat the first" in field.notes[0]


def test_the_form_is_taken_out():
    from surfaces.levelling import levelled

    x, y = np.meshgrid(np.linspace(3, 4, 30), np.linspace(-2, 9, 50), indexing="ij")
    form = 1e3 + 2 * x - y + 0.3 * x * y - 0.2 * x * x * y + y**3 / 7
    assert np.abs(levelled(form, 3)).max() < 1e-10
    assert np.abs(levelled(form, 2)).max() > 0.1
    with pytest.raises(ValueError, match="degree is 9"):
        levelled(form, 9)


def test_missing_points_are_filled_as_by_a_film(tmp_path):
    """A harmonic function is its own film; what is left of a plane is the plane, at edges too."""
    x, y = np.meshgrid(np.linspace(0, 1, 40), np.linspace(0, 1, 50), indexing="ij")
    harmonic = x * x - y * y + x
    holed = harmonic.copy()
    holed[10:16, 20:30] = np.nan
    holed[30, 40] = np.nan
    full, notes = filled(holed)
    # The second differences of the two squares cancel only where the steps are alike.
    assert np.abs(full - harmonic).max() < 0.01
    assert "61 of 2000 points were missing" in notes[0]
    x_only, _ = filled(np.where(np.isnan(holed), np.nan, 2 + 0 * x))
    np.testing.assert_allclose(x_only, 2)
    holed[:8] = np.nan
    with pytest.raises(ValueError, match="461 of its 2000 points are missing, more than the 10%"):
        filled(holed)
    np.save(tmp_path / "scan.npy", holed)
    with pytest.raises(ValueError, match="missing"):
        HeightField.load(tmp_path / "scan.npy", step=1.0)


def test_a_mesh_whose_vertices_are_on_no_grid_is_sampled(tmp_path):
    import trimesh
    from scipy.spatial import Delaunay

    rng = np.random.default_rng(3)
    corners = np.array([[0, 0], [0, 1], [1, 0], [1, 1.0]])
    xy = np.concatenate([corners, rng.random((4000, 2))])
    z = np.sin(3 * xy[:, 0]) * xy[:, 1]
    triangles = Delaunay(xy).simplices
    mesh = trimesh.Trimesh(np.column_stack([xy, z]), triangles, process=False)
    mesh.export(tmp_path / "scan.ply")
    scan = read(tmp_path / "scan.ply")
    n, m = scan.heights.shape
    assert 3500 < n * m < 4500
    x, y = (np.arange(n) + 0.5) * scan.step[0], (np.arange(m) + 0.5) * scan.step[1]
    # Flat triangles of side 1/50 under a curvature of 9; those at the rim are long.
    apart = np.abs(scan.heights - np.sin(3 * x[:, None]) * y)
    assert apart.max() < 0.02
    assert apart.mean() < 0.0005
    assert "on no grid" in scan.notes[0]


def overhanging():
    import trimesh

    return trimesh.creation.icosphere(2)


def zipped(name, content):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, content)
    return out.getvalue()


def npy(heights, **more):
    out = io.BytesIO()
    np.save(out, heights, **more)
    return out.getvalue()


def header(shape):
    out = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        out, {"descr": "<f8", "fortran_order": False, "shape": shape}
    )
    return out.getvalue()


class Evil:
    def __reduce__(self):
        return (exec, ("raise SystemExit('executed')",))


def png(size=(8, 8)):
    out = io.BytesIO()
    Image.new("RGB", size).save(out, "PNG")
    return out.getvalue()


def huge_png():
    """One whose header promises 10000 x 12000 pixels."""
    import struct
    import zlib

    def chunk(body):
        return struct.pack(">I", len(body) - 4) + body + struct.pack(">I", zlib.crc32(body))

    head = b"IHDR" + struct.pack(">IIBBBBB", 10000, 12000, 16, 0, 0, 0, 0)
    return png()[:8] + chunk(head) + chunk(b"IDAT" + zlib.compress(bytes(99))) + chunk(b"IEND")


GOOD = npy(np.random.default_rng(0).random((16, 16)))
HOSTILE = {
    "truncated.npy": (GOOD[:-9], "cut or damaged"),
    "longer.npy": (GOOD + b"x", "cut or damaged"),
    "huge.npy": (header((10**6, 10**6)), "1000000 x 1000000 points"),
    "negative.npy": (header((-4, -4)), "cut or damaged"),
    "nan.npy": (npy(np.full((8, 8), np.nan)), "64 of its 64 points are missing"),
    "inf.npy": (npy(np.where(np.eye(8), np.inf, 1.0)), "8 of its heights are infinite"),
    "row.npy": (npy(np.ones((1, 50))), "1 x 50"),
    "line.npy": (npy(np.ones(50)), "its heights are 50"),
    "constant.npy": (npy(np.full((8, 8), 3.0)), "all its heights are 3"),
    "complex.npy": (npy(np.ones((8, 8), complex)), "real numbers are wanted"),
    "pickled.npy": (npy(np.array([[Evil()] * 8] * 8)), "never unpickled"),
    "pickled.npz": (zipped("a.npy", npy(np.array([[Evil()] * 8] * 8))), "never unpickled"),
    "bomb.npz": (zipped("a.npy", header((10**5, 10**5)) + bytes(10**7)), "100000 x 100000 points"),
    "liar.npz": (zipped("a.npy", header((8, 8)) + bytes(10**7)), "cut or damaged"),
    "several.npz": (zipped("a.npy", npy(np.ones(3))), "one of two dimensions is wanted"),
    "cut.npz": (zipped("a.npy", GOOD)[:-40], "cannot be read"),
    "picture.npy": (png(), "its content is that of a .png file"),
    "array.png": (GOOD, "its content is that of a .npy file"),
    "array.txt": (GOOD, "its content is that of a .npy file"),
    "noise.npz": (b"\x00\x01" * 50, "its content is of another kind"),
    "colour.png": (png(), "mode RGB"),
    "cut.png": (png()[:-30], "cannot be read"),
    "huge.png": (huge_png(), "10000 x 12000 points"),
    "empty.tif": (b"", "it is empty"),
    "words.txt": (b"these are\nno heights\n" * 9, "rows of a grid"),
    "ragged.csv": (b"1,2,3,4\n1,2,3\n1,2,3,4\n1,2,3,4\n", "cannot be read"),
    "binary.txt": (bytes(range(256)) * 9, "cannot be read"),
    "comments.txt": (b"# nothing\n" * 9, "no line of numbers"),
    "points.txt": (b"0 0 1\n" * 50, "3 numbers: rows of a grid"),
    "cut.stl": (bytes(80) + b"\xff\xff\xff\x7f" + bytes(100), "promises 2147483647 triangles"),
    "cut.ply": (b"ply\nformat ascii 1.0\nelement vertex 99999999\nend_header\n", "99999999 elem"),
    "words.obj": (b"these are no vertices\n", "no mesh of it|no triangles"),
    "words.stl": (b"solid of nothing\n", "no mesh of it|no triangles"),
    "word.docx": (b"x", "not from '.docx'"),
    "none": (b"x", "not from ''"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_what_is_hostile_is_refused_in_a_sentence(name, tmp_path):
    content, said = HOSTILE[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ValueError, match=said) as refusal:
        HeightField.load(tmp_path / name, step=1.0, height_unit=1.0)
    assert str(tmp_path / name) in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_overhangs_are_refused_with_a_count(tmp_path):
    overhanging().export(tmp_path / "ball.ply")
    with pytest.raises(ValueError, match="152 of its 320 triangles face the other way"):
        read(tmp_path / "ball.ply")


def test_what_the_file_does_not_say_is_asked_for(heights, tmp_path):
    np.save(tmp_path / "a.npy", heights)
    with pytest.raises(ValueError, match="give the step"):
        read(tmp_path / "a.npy")
    with pytest.raises(ValueError, match="the step is -1"):
        read(tmp_path / "a.npy", step=-1)
    Image.fromarray(levels(heights, 8)[0].astype(np.uint8)).save(tmp_path / "a.png")
    with pytest.raises(ValueError, match="give the height unit"):
        read(tmp_path / "a.png", step=1.0)
    with pytest.raises(ValueError, match="the height unit is 0"):
        read(tmp_path / "a.png", step=1.0, height_unit=0)
    assert "256 grey levels" in read(tmp_path / "a.png", step=1.0, height_unit=1.0).notes[0]
    with pytest.raises(ValueError, match="No such file"):
        read(tmp_path / "b.npy")


@pytest.mark.parametrize(
    ("suffix", "package"), [("sur", "SurfaceTopography"), ("x3p", "x3pio"), ("sdf", "sdfio")]
)
def test_formats_of_instruments_need_their_packages(suffix, package, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    (tmp_path / f"a.{suffix}").write_bytes(b"x" * 100)
    with pytest.raises(ValueError, match=rf"{package}: `pip install 'msbsdf\[metrology\]'`"):
        read(tmp_path / f"a.{suffix}")
