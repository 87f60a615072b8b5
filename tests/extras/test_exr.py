"""Pictures in OpenEXR, read back. Needs `pip install '.[exr]'`; `.ci/run` has it."""

import numpy as np
import pytest
from command_line import msbsdf

from msbsdf_cli.renderers.albedos import albedos
from msbsdf_cli.renderers.exr import write_exr
from msbsdf_cli.smith.slopes import Ggx

OpenEXR = pytest.importorskip("OpenEXR")


def read(path, *names):
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    assert set(channels) == set(names)
    return np.stack([channels[name].pixels for name in names], axis=-1)


def test_a_picture_comes_back(tmp_path):
    image = np.random.default_rng(0).random((5, 7, 3)) * 100 - 1
    write_exr(tmp_path / "it.exr", image)
    found = read(tmp_path / "it.exr", "R", "G", "B")
    assert found.dtype == np.float32
    np.testing.assert_array_equal(found, image.astype(np.float32))


def test_channels_have_names(tmp_path):
    image = np.arange(12, dtype=float).reshape(2, 3, 2)
    write_exr(tmp_path / "it.exr", image, ("first", "second"))
    np.testing.assert_array_equal(read(tmp_path / "it.exr", "first", "second"), image)
    with pytest.raises(ValueError, match="no channels R, G, B"):
        write_exr(tmp_path / "it.exr", image)


def test_export_writes_albedos(tmp_path):
    words = "--slopes", "ggx", "--alpha", "1", "--exr", "--threads", "1", "--out", tmp_path / "it"
    result = msbsdf("export", *words)
    assert result.returncode == 0, result.stderr
    directional, mean = albedos(Ggx(1, 1))
    found = read(tmp_path / "it" / "albedo.exr", "directional", "mean")
    np.testing.assert_allclose(found[..., 0], directional, rtol=1e-6)
    np.testing.assert_allclose(found[:, 5, 1], mean, rtol=1e-6)
