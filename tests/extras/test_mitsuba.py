"""Scenes as Mitsuba itself reads them. Needs `pip install '.[mitsuba]'`; `.ci/run` has it."""

import numpy as np
import pytest

from msbsdf_cli.experiments.recommend.mitsuba_scene import MEDIA, METALS
from msbsdf_cli.experiments.recommend.scene_file import read_scene

mi = pytest.importorskip("mitsuba")
mi.set_variant("scalar_rgb")

NUMBERS = (
    "",
    '<float name="alpha" value="0.3"/>',
    '<string name="distribution" value="ggx"/><float name="alpha" value="0.2"/>',
    '<float name="alpha_u" value="0.2"/><float name="alpha_v" value="0.4"/>',
)


def both(tmp_path, body):
    """The surface as it is read here, and Mitsuba's parameters and words of it."""
    path = tmp_path / "scene.xml"
    path.write_text(f'<scene version="3.0.0">{body}</scene>')
    (mine,) = read_scene(path).surfaces
    plugin = mi.load_string(body.replace("<bsdf ", '<bsdf version="3.0.0" ', 1))
    return mine, mi.traverse(plugin), str(plugin)


def value(parameters, *names):
    """The first of the parameters that is there."""
    name = next(n for n in (*(f"{n}.value" for n in names), *names) if n in parameters)
    return np.ravel(parameters[name])


@pytest.mark.parametrize("kind", ["roughconductor", "roughdielectric"])
@pytest.mark.parametrize("numbers", NUMBERS)
def test_roughness_and_distribution(tmp_path, kind, numbers):
    mine, parameters, words = both(tmp_path, f'<bsdf type="{kind}">{numbers}</bsdf>')
    (slopes,) = mine.slopes
    assert f"distribution = {slopes.name}" in words
    assert slopes.alpha_x == pytest.approx(value(parameters, "alpha_u", "alpha")[0])
    assert slopes.alpha_y == pytest.approx(value(parameters, "alpha_v", "alpha")[0])


def test_glass_without_a_word(tmp_path):
    mine, parameters, _ = both(tmp_path, '<bsdf type="roughdielectric"/>')
    assert mine.material.ior == pytest.approx(value(parameters, "eta")[0], rel=1e-6)


@pytest.mark.parametrize("name", sorted(MEDIA))
def test_media(tmp_path, name):
    outside = "air" if name == "vacuum" else "vacuum"
    body = (
        f'<bsdf type="roughdielectric"><string name="int_ior" value="{name}"/>'
        f'<string name="ext_ior" value="{outside}"/></bsdf>'
    )
    mine, parameters, _ = both(tmp_path, body)
    assert mine.material.ior == pytest.approx(value(parameters, "eta")[0], rel=1e-6)


@pytest.mark.parametrize("name", sorted(METALS))
def test_metals(tmp_path, name):
    body = f'<bsdf type="roughconductor"><string name="material" value="{name}"/></bsdf>'
    mine, parameters, _ = both(tmp_path, body)
    theirs = np.array([value(parameters, n) for n in ("eta", "k")]).T
    np.testing.assert_allclose(mine.material.eta_k, theirs, rtol=1e-3)


def test_a_mirror(tmp_path):
    mine, parameters, _ = both(tmp_path, '<bsdf type="roughconductor"/>')
    assert not mine.material.absorbs
    assert (value(parameters, "eta")[0], value(parameters, "k")[0]) == (0, 1)
