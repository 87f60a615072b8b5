"""Scenes as Mitsuba itself reads them. Needs `pip install '.[mitsuba]'`; `.ci/run` has it."""

import numpy as np
import pytest

from msbsdf_cli.experiments.recommend.mitsuba_names import MEDIA, METALS
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


PLACES = [((0.3, 0.1), (-0.5, 0.2)), ((0.6, -0.5), (-0.1, -0.3)), ((0.1, 0.85), (0.2, -0.4))]
"""Horizontal parts of wi and wo."""


def shown(body, sign=1):
    """Mitsuba's BSDF x cosine in `PLACES`, wo on the other side where `sign` is -1, (places, 3)."""
    plugin = mi.load_string(body.replace("<bsdf ", '<bsdf version="3.0.0" ', 1))
    found = []
    for wi, wo in PLACES:
        si = mi.SurfaceInteraction3f()
        si.wi = mi.Vector3f(*wi, np.sqrt(1 - np.dot(wi, wi)))
        out = mi.Vector3f(*wo, sign * np.sqrt(1 - np.dot(wo, wo)))
        found.append(np.ravel(plugin.eval(mi.BSDFContext(), si, out)))
    return np.array(found)


def of_alpha(kind, slopes, more=""):
    """A plugin of GGX slopes in Mitsuba's words for them."""
    alphas = f'<float name="alpha_u" value="{slopes.alpha_x!r}"/>'
    alphas += f'<float name="alpha_v" value="{slopes.alpha_y!r}"/>'
    ggx = '<string name="distribution" value="ggx"/>'
    return f'<bsdf type="{kind}">{ggx}{alphas}{more}</bsdf>'


@pytest.mark.parametrize(("roughness", "anisotropic"), [(0.6, 0), (0.7, 0.8), (0.01, 0)])
def test_principled_metals_are_rough_conductors_of_schlick(tmp_path, roughness, anisotropic):
    body = (
        '<bsdf type="principled"><float name="metallic" value="1"/>'
        '<rgb name="base_color" value="0.9, 0.5, 0.1"/>'
        f'<float name="roughness" value="{roughness}"/>'
        f'<float name="anisotropic" value="{anisotropic}"/></bsdf>'
    )
    mine, _, _ = both(tmp_path, body)
    mirror = shown(of_alpha("roughconductor", mine.slopes[0]))
    wi, wo = (np.array(side) for side in zip(*PLACES, strict=True))
    wi, wo = (np.column_stack([w, np.sqrt(1 - (w**2).sum(axis=1))]) for w in (wi, wo))
    cos_i = np.linalg.norm(wi + wo, axis=1) / 2
    # Mitsuba computes in single precision.
    expected = mirror * mine.material.reflectance(cos_i).T
    np.testing.assert_allclose(shown(body), expected, rtol=2e-4, atol=1e-12)


@pytest.mark.parametrize("index", ['"eta" value="1.3"', '"specular" value="0.8"', ""])
def test_principled_glass_is_rough_glass(tmp_path, index):
    more = f"<float name={index}/>" if index else ""
    body = (
        '<bsdf type="principled"><float name="spec_trans" value="1"/>'
        f'<rgb name="base_color" value="1, 1, 1"/>{more}</bsdf>'
    )
    mine, _, _ = both(tmp_path, body)
    ior = f'<float name="int_ior" value="{mine.material.ior!r}"/><float name="ext_ior" value="1"/>'
    glass = of_alpha("roughdielectric", mine.slopes[0], ior)
    for sign in (1, -1):
        np.testing.assert_allclose(shown(body, sign), shown(glass, sign), rtol=2e-4, atol=1e-12)
        assert shown(glass, sign).max() > 0
