"""Formats of metrology, as programs write them that have nothing to do with their reader here."""

import numpy as np
import pytest

from surfaces.describe import describe
from surfaces.files import read
from surfaces.heightfield import all_waves, synthesise
from surfaces.patch import Patch

pytest.importorskip("SurfaceTopography")
sdfio, x3pio = pytest.importorskip("sdfio"), pytest.importorskip("x3pio")

STEP = (2e-6, 3e-6)
WRITERS = {".x3p": x3pio, ".sdf": sdfio}


@pytest.fixture(scope="module")
def heights():
    x, y = (2 * np.pi * np.arange(n)[:, None] / n for n in (24, 36))
    return 4e-6 * (np.sin(x + 0.3) + np.cos(2 * y.T + x) * np.cos(x))


@pytest.mark.parametrize("suffix", [".x3p", ".sdf"])
def test_what_is_read_is_what_was_written(suffix, heights, tmp_path):
    path = tmp_path / f"scan{suffix}"
    holed = heights.copy()
    holed[5, 7] = np.nan
    # Rows along x, of growing y.
    WRITERS[suffix].write(path, holed.T, x_scale=STEP[0], y_scale=STEP[1])
    scan = read(path)
    np.testing.assert_allclose(scan.step, STEP, rtol=1e-6)
    known = np.isfinite(holed)
    np.testing.assert_allclose(scan.heights[known], heights[known], atol=1e-11)
    assert "1 of 864 points were missing" in scan.notes[-1]


def test_instruments_by_another_reader_of_the_same_file(heights, tmp_path):
    """An older revision of X3P, which both readers know."""
    from surfaces.files import instruments

    path = tmp_path / "scan.x3p"
    options = {"revision": x3pio.Revision.ISO5436_2000}
    x3pio.write(path, heights.T, x_scale=STEP[0], y_scale=STEP[1], **options)
    scan = instruments.read(path)
    np.testing.assert_allclose(scan.step, STEP, rtol=1e-6)
    np.testing.assert_allclose(scan.heights, read(path).heights, atol=1e-11)


def test_damaged_files_are_refused(heights, tmp_path):
    x3pio.write(tmp_path / "scan.x3p", heights.T, x_scale=STEP[0], y_scale=STEP[1])
    content = (tmp_path / "scan.x3p").read_bytes()
    for suffix in (".x3p", ".sdf", ".sur", ".plux", ".gwy", ".opd"):
        path = tmp_path / f"damaged{suffix}"
        for damaged in (content[: len(content) // 2], b"", b"no surface at all" * 9):
            path.write_bytes(damaged)
            with pytest.raises(ValueError, match=rf"damaged\{suffix}"):
                read(path)


def test_parameters_of_iso_25178_by_others():
    """By surfalize; a skewed surface."""
    surfalize = pytest.importorskip("surfalize")
    rough = synthesise(all_waves(16, np.random.default_rng(1)), 16, 8)
    step = (2e-6, 2e-6)
    patch = Patch(np.exp(0.4 * rough[:, :100]), step)
    mine = {row.quantity: row.value for row in describe(patch).rows}
    other = surfalize.Surface(patch.heights.T - patch.heights.mean(), *step)
    for name in ("Sa", "Sq", "Ssk", "Sku"):
        assert mine[name.lower()] == pytest.approx(getattr(other, name)(), rel=1e-9), name
    # Slopes along one side of the patch are those of one facet more.
    assert mine["sdq"] == pytest.approx(other.Sdq(), rel=0.01)
