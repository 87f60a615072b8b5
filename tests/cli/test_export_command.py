"""`msbsdf export`: what it writes, and what it refuses."""

import json
from importlib.util import find_spec

import numpy as np
import pytest
from command_line import msbsdf, refused

from msbsdf_cli.renderers.files import read_table


def test_a_mirror_is_exported(tmp_path):
    words = "--slopes", "ggx", "--alpha", "0.5", "--threads", "1", "--out", tmp_path / "it"
    result = msbsdf("export", *words)
    assert result.returncode == 0, result.stderr
    assert result.stdout.startswith("Up to theta 1.4 the table is off by ")
    content = read_table(tmp_path / "it" / "bsdf.npz")
    assert content["error"]["largest"] < 0.001
    assert content["values"].shape[1:] == (1, 1, 24, 24, 32)
    assert (tmp_path / "it" / "measured.bsdf").read_bytes()[:14] == b"tensor_file\0\1\0"
    with np.load(tmp_path / "it" / "albedo.npz") as file:
        assert file["directional"].shape == (32, 32)
    assert "static const float msbsdf_albedo[32][32]" in (tmp_path / "it/albedo.h").read_text()
    assert "off by" in json.loads((tmp_path / "it/run.json").read_text())["summary"]


def test_what_cannot_be_exported_is_refused(tmp_path):
    out = "--out", tmp_path / "it"
    glass = "--material", "dielectric", "--alpha", "1,0.1"
    assert "one roughness" in refused("export", *glass, *out)
    assert "1 channel or 3" in refused("export", "--eta-k", "1,2,3,4", *out)
    assert "student-t" in refused("export", "--slopes", "student-t", "--gamma", "3", *out)


@pytest.mark.skipif(find_spec("OpenEXR") is not None, reason="OpenEXR is installed")
def test_a_missing_extra_is_named(tmp_path):
    words = refused("export", "--exr", "--out", tmp_path / "it")
    assert "pip install 'msbsdf[exr]'" in words
