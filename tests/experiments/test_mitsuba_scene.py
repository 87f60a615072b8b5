"""Mitsuba's scenes: its conventions, what is left out, and hostile files.

Expected figures are those that Mitsuba 3.9.1 shows of the same plugins.
"""

import numpy as np
import pytest

import msbsdf_cli as ms
from msbsdf_cli.experiments.recommend.scene_file import read_scene
from msbsdf_cli.experiments.recommend.scene_surface import SceneFileError
from surfaces.materials import Conductor, Dielectric


def read(tmp_path, body, name="scene.xml"):
    path = tmp_path / name
    path.write_text(f'<scene version="3.0.0">{body}</scene>')
    return read_scene(path)


def only(tmp_path, body):
    scene = read(tmp_path, body)
    assert scene.left_out == []
    (found,) = scene.surfaces
    return found


def test_what_a_scene_does_not_say_is_as_in_mitsuba(tmp_path):
    metal = only(tmp_path, '<bsdf type="roughconductor" id="m"/>')
    assert (metal.name, metal.material) == ("m", Conductor())
    assert metal.slopes == (ms.Beckmann(0.1, 0.1),)
    glass = only(tmp_path, '<bsdf type="roughdielectric"/>')
    assert glass.material.ior == pytest.approx(1.50418, abs=1e-5)


@pytest.mark.parametrize(
    ("entry", "material"),
    [
        (
            '<string name="material" value="Au"/>',
            Conductor(((0.143, 3.983), (0.3753, 2.386), (1.442, 1.603))),
        ),
        ('<string name="material" value="none"/>', Conductor()),
        ('<float name="eta" value="0.2"/><float name="k" value="3"/>', Conductor(((0.2, 3),))),
        (
            '<rgb name="eta" value="0.2, 0.3, 1"/><spectrum name="k" value="3"/>',
            Conductor(((0.2, 3), (0.3, 3), (1, 3))),
        ),
    ],
)
def test_metals(tmp_path, entry, material):
    body = f'<bsdf type="roughconductor"><float name="alpha" value="0.3"/>{entry}</bsdf>'
    found = only(tmp_path, body)
    assert found.material == material
    assert found.slopes == (ms.Beckmann(0.3, 0.3),)


def test_glass_of_two_roughnesses_in_water(tmp_path):
    found = only(
        tmp_path,
        '<bsdf type="roughdielectric"><string name="distribution" value="ggx"/>'
        '<float name="alpha_u" value="0.2"/><float name="alpha_v" value="0.4"/>'
        '<float name="int_ior" value="1.6"/><string name="ext_ior" value="water"/></bsdf>',
    )
    assert found.material == Dielectric(1.6 / 1.333)
    assert found.slopes == (ms.Ggx(0.2, 0.4),)


def principled(entries):
    return f'<bsdf type="principled" id="p">{entries}</bsdf>'


METAL = '<float name="metallic" value="1"/>'
GLASS = '<float name="spec_trans" value="1"/>'
WHITE = '<rgb name="base_color" value="1"/>'


def test_principled_metals(tmp_path):
    """Reflectances by Schlick's formula: at normal incidence, half way and grazing."""
    colour = '<rgb name="base_color" value="0.9, 0.5, 0"/>'
    rough = '<float name="roughness" value="0.6"/><float name="anisotropic" value="0.5"/>'
    found = only(tmp_path, principled(METAL + colour + rough))
    aspect = 0.55**0.5
    assert found.slopes == (ms.Ggx(0.36 / aspect, 0.36 * aspect),)
    material = found.material
    assert (material.name, material.channels, material.absorbs) == ("conductor", 3, True)
    expected = [[0.9, 0.9 + 0.1 / 32, 1], [0.5, 0.5 + 0.5 / 32, 1], [0, 1 / 32, 1]]
    cos_i = np.array([1, 0.5, 0])
    np.testing.assert_allclose(material.reflectance(cos_i), expected, atol=1e-15)
    assert only(tmp_path, principled(METAL + WHITE)).material == Conductor()
    # Walks follow it as they follow any metal.
    walked = ms.walk(ms.Smith(ms.Ggx(0.01, 0.01), material), ms.direction(0.0), 1000)
    assert walked.energy.sum() == pytest.approx(0.9, abs=0.001)


def test_principled_glass(tmp_path):
    clear = only(tmp_path, principled(GLASS + WHITE + '<float name="eta" value="1.33"/>'))
    assert (clear.material, clear.slopes) == (Dielectric(1.33), (ms.Ggx(0.25, 0.25),))
    scene = read(tmp_path, principled(GLASS + '<float name="specular" value="0.5"/>'))
    # Specular .5 is a reflectance of 4 %.
    assert ((scene.surfaces[0].material.ior - 1) / (scene.surfaces[0].material.ior + 1)) ** 2 == (
        pytest.approx(0.04)
    )
    assert scene.notes == [
        "p is judged as clear glass: what its base_color takes on each way through is left out."
    ]


@pytest.mark.parametrize(
    ("entries", "reason"),
    [
        ("", "metallic 0 and spec_trans 0, a mixture"),
        (
            '<float name="metallic" value="0.5"/>' + GLASS,
            "metallic 0.5 and spec_trans 1, a mixture",
        ),
        ('<texture name="metallic" type="bitmap"/>', "metallic is a texture"),
        (METAL + '<float name="clearcoat" value="0.1"/>', "clearcoat is a second lobe"),
        (METAL + '<float name="roughness" value="2"/>', "roughness is 2, not from 0 to 1"),
        (METAL + '<texture name="base_color" type="bitmap"/>', "base_color is a texture"),
        (METAL + '<rgb name="base_color" value="2"/>', "base_color is not from 0 to 1"),
        (METAL + '<float name="eta" value="0.5"/>', "eta is below 1"),
        (GLASS + '<float name="spec_tint" value="0.1"/>', "spec_tint is not of glass"),
        (GLASS + '<float name="eta" value="1"/>', "one index"),
    ],
)
def test_principled_mixtures_are_left_out(tmp_path, entries, reason):
    scene = read(tmp_path, principled(entries))
    assert scene.surfaces == []
    assert reason in scene.left_out[0][1]


def test_wrapped_and_referenced_surfaces_variables_and_includes(tmp_path):
    (tmp_path / "parts").mkdir()
    part = '<default name="a" value="0.9"/><bsdf type="$kind" id="inner"/>'
    (tmp_path / "parts" / "scene.xml").write_text(f"<scene>{part}</scene>")
    scene = read(
        tmp_path,
        '<default name="a" value="0.4"/><default name="kind" value="roughconductor"/>'
        '<include filename="parts/scene.xml"/>'
        '<bsdf type="twosided" id="outer"><bsdf type="bumpmap"><ref id="inner"/></bsdf></bsdf>'
        '<shape type="shapegroup"><shape type="sphere" id="ball"><bsdf type="mask">'
        '<bsdf type="roughconductor"><float name="alpha" value="$a"/></bsdf></bsdf></shape>'
        "</shape>",
    )
    assert [(s.name, s.slopes[0].alpha_x) for s in scene.surfaces] == [
        ("inner", 0.1),
        ("outer", 0.1),
        ("ball", 0.4),
    ]


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ('<bsdf type="diffuse"/>', "no roughness"),
        ('<bsdf type="roughplastic"/>', "roughplastic is no"),
        ('<bsdf type="principled"/>', "mixture"),
        ('<bsdf type="twosided"/>', "holds no surface"),
        ('<bsdf type="twosided" id="a"><ref id="a"/></bsdf>', "refers to itself"),
        (
            '<bsdf type="roughconductor"><texture name="alpha" type="bitmap"/></bsdf>',
            "alpha is a texture",
        ),
        ('<bsdf type="roughconductor"><float name="alpha" value="x"/></bsdf>', "no number"),
        ('<bsdf type="roughconductor"><float name="alpha" value="0"/></bsdf>', "above 0"),
        ('<bsdf type="roughconductor"><string name="material" value="Tin"/></bsdf>', "'Tin'"),
        ('<bsdf type="roughdielectric"><string name="int_ior" value="jam"/></bsdf>', "'jam'"),
        (
            '<bsdf type="roughconductor"><string name="distribution" value="phong"/></bsdf>',
            "phong",
        ),
    ],
)
def test_what_cannot_be_judged_is_listed_with_the_reason(tmp_path, body, reason):
    scene = read(tmp_path, body)
    assert scene.surfaces == []
    assert reason in scene.left_out[0][1]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "not XML"),
        ("<scene>", "not XML"),
        ("<html/>", "no Mitsuba scene"),
        ("<scene/>", "no bsdf"),
        ('<!DOCTYPE s [<!ENTITY a "b">]><scene>&a;</scene>', "document type"),
        ('<scene><include filename="/etc/hostname"/></scene>', "outside"),
        ('<scene><include filename="../scene.xml"/></scene>', "outside"),
        ('<scene><include filename="none.xml"/></scene>', "cannot be read"),
        ('<scene><include filename="scene.xml"/></scene>', "more than"),
        ('<scene><bsdf type="$who"/></scene>', "no value"),
    ],
)
def test_hostile_and_broken_files_get_a_sentence(tmp_path, text, words):
    path = tmp_path / "scene.xml"
    path.write_text(text)
    with pytest.raises(SceneFileError, match=words):
        read_scene(path)


def test_a_scene_nested_without_end_is_refused(tmp_path):
    deep = '<bsdf type="twosided">' * 20_000 + "</bsdf>" * 20_000
    scene = read(tmp_path, deep)
    assert scene.surfaces == []
