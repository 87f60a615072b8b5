"""Formats of metrology, as programs write them that have nothing to do with their reader here."""

import numpy as np
import pytest

from surfaces.files import read

SurfaceTopography = pytest.importorskip("SurfaceTopography")
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
