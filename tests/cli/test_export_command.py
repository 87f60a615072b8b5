"""`msbsdf export`: what it writes, and what it refuses."""

import json

import numpy as np
from command_line import msbsdf, refused

from msbsdf_cli.renderers.files import read_table


def test_a_mirror_is_exported(tmp_path):
    words = "--slopes", "ggx", "--alpha", "0.5", "--threads", "1", "--out", tmp_path / "it"
    result = msbsdf("export", *words)
    assert result.returncode == 0, result.stderr
    assert result.stdout.startswith("Up to theta 1.4 the table is off by 0.00")
    assert read_table(tmp_path / "it" / "bsdf.npz")["interpolation_error"] < 0.01
    with np.load(tmp_path / "it" / "albedo.npz") as file:
        assert file["directional"].shape == (32, 32)
    assert "static const float msbsdf_albedo[32][32]" in (tmp_path / "it/albedo.h").read_text()
    assert "off by" in json.loads((tmp_path / "it/run.json").read_text())["summary"]


def test_what_cannot_be_exported_is_refused(tmp_path):
    out = "--out", tmp_path / "it"
    assert "one side" in refused("export", "--material", "dielectric", *out)
    assert "one roughness" in refused("export", "--alpha", "1,0.1", *out)
    assert "student-t" in refused("export", "--slopes", "student-t", "--gamma", "3", *out)
