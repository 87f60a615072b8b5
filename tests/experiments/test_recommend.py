"""Recommendations: scene files, errors against an independent dear run, choices."""

import numpy as np
import pytest

import msbsdf_cli as ms
from msbsdf_cli.experiments.recommend import sheet
from msbsdf_cli.experiments.recommend.candidates import (
    cases,
    compensated,
    single_bound,
    truncated,
)
from msbsdf_cli.experiments.recommend.choice import CHOSEN, CLOSE, TOO_FAR, recommend
from msbsdf_cli.experiments.recommend.scene_file import SceneFileError, SceneSurface, read_scene
from surfaces.materials import Conductor, Dielectric, Diffuse

GOLD = Conductor.named("gold", rgb=True)


MIRROR, HALF = Conductor(), (ms.Ggx(0.5, 0.5),)


def surface(material=MIRROR, slopes=HALF, theta=(0.0, 1.0)):
    return SceneSurface("it", material, slopes, theta)


def scene(tmp_path, text):
    path = tmp_path / "scene.toml"
    path.write_text(text)
    return read_scene(path).surfaces


def test_a_scene_is_read(tmp_path):
    found = scene(
        tmp_path,
        """
        roughness = "perceptual"
        [[surface]]
        name = "tap"
        material = "conductor"
        metal = "gold"
        slopes = "ggx"
        alpha = [0.5, 1]
        theta = [0, "60deg"]
        weight = 2
        [[surface]]
        name = "glass"
        material = "dielectric"
        alpha_x = 0.5
        alpha_y = 0.4
        """,
    )
    tap, glass = found
    assert tap.material == GOLD
    np.testing.assert_allclose([s.alpha_x for s in tap.slopes], [0.25, 0.5, 1])
    np.testing.assert_allclose(tap.theta, [0, np.pi / 3])
    assert tap.weight == 2
    assert glass.material == Dielectric(1.5)
    assert glass.slopes == (ms.Beckmann(0.25, 0.4**2),)


ONE = '[[surface]]\nname = "a"\nmaterial = "conductor"\nalpha = 0.5\n'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "no \\[\\[surface"),
        ("surface = 3", "no \\[\\[surface"),
        ("not toml", "not TOML"),
        ("colour = 1\n" + ONE, "'colour' is not known"),
        ('roughness = "glossy"\n' + ONE, "glossy"),
        (ONE + ONE, "two surfaces"),
        (ONE + "ior = 1.5\n", "'ior' is not known of conductor"),
        (ONE.replace("conductor", "wood"), "'wood' is not a material"),
        (ONE.replace("0.5", "-1"), "alpha"),
        (ONE.replace("0.5", "[0.5, 0.1]"), "alpha"),
        (ONE.replace("0.5", "true"), "numbers"),
        (ONE.replace("0.5", "nan"), "finite"),
        (ONE + "theta = 1.6\n", "1.6"),
        (ONE + "theta = []\n", "empty"),
        (ONE + "weight = 0\n", "weight"),
        (ONE + 'slopes = "student-t"\n', "gamma is missing"),
        (ONE + "gamma = 3\n", "gamma"),
        (ONE + "alpha_x = 1\nalpha_y = 1\n", "either alpha"),
        (ONE + 'metal = "cheese"\n', "cheese"),
        ("a = " + "[" * 2000, "TOML"),
    ],
)
def test_what_is_no_scene_is_refused_in_words(tmp_path, text, words):
    with pytest.raises(SceneFileError, match=words):
        scene(tmp_path, text)


def test_files_that_cannot_be_read_are_refused(tmp_path):
    with pytest.raises(SceneFileError, match="cannot be read"):
        read_scene(tmp_path / "none.toml")
    (tmp_path / "huge.toml").write_text("#" * 2_000_000)
    with pytest.raises(SceneFileError, match="larger"):
        read_scene(tmp_path / "huge.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(SceneFileError, match="not TOML"):
        read_scene(tmp_path / "bytes.toml")


@pytest.mark.parametrize("material", [Conductor(), Dielectric(1.5), Diffuse()])
def test_errors_of_few_bounces_are_the_energy_that_walks_have_later(material):
    """By long walks, at the angle that is named."""
    found = truncated(cases(surface(material)))
    for n in (1, 2, 3):
        mine = found[n - 1]
        assert mine.bounces == n
        result = ms.walk(ms.Smith(ms.Ggx(0.5, 0.5), material), ms.direction(mine.theta), 400_000)
        later = 1 - result.energy[:n].sum()
        stderr = np.sqrt(later * (1 - later) / 400_000)
        assert abs(mine.error - later) < 4 * stderr + mine.uncertainty
    assert (found[-1].error, found[-1].bounces) == (0, 0)
    # The mean number of facets of walks from the angle where they are most.
    assert found[-1].facets == pytest.approx(max(_bounces(material)), rel=0.01)


def _bounces(material):
    model = ms.Smith(ms.Ggx(0.5, 0.5), material)
    return [ms.walk(model, ms.direction(t), 400_000).bounces_mean for t in (0.0, 1.0)]


@pytest.mark.parametrize("material", [Conductor(), GOLD, Diffuse((0.5,)), Dielectric(1.5)])
@pytest.mark.parametrize("alpha", [0.05, 0.8])
def test_the_bound_of_single_scattering_is_one(material, alpha):
    it = surface(material, (ms.Ggx(alpha, alpha),), (0.0, 0.7, 1.4))
    bound, error = single_bound(it), truncated(cases(it))[0]
    assert error.error <= bound.error + bound.uncertainty
    if not material.absorbs:
        assert bound.error == pytest.approx(error.error, abs=1e-4)


def test_compensation_is_judged_by_its_lobe():
    """Against a sum over other directions, 24 x 48 of the midpoint rule, and walks' own lobe."""
    it = surface(Conductor(), (ms.Ggx(0.8, 0.8),), (1.0,))
    (mine,) = (c for c in compensated(cases(it)) if c.method == "energy-compensated")
    cos = (np.arange(24) + 0.5) / 24
    phi = 2 * np.pi * np.arange(48) / 48
    sin = np.sqrt(1 - cos**2)
    wo = np.array(
        [np.outer(sin, np.cos(phi)).ravel(), np.outer(sin, np.sin(phi)).ravel(), np.repeat(cos, 48)]
    )
    from msbsdf_cli.methods.registry import METHODS

    rng, wi = np.random.default_rng(0), ms.direction(1.0)
    lobes = [
        METHODS[name](ms.Ggx(0.8, 0.8), Conductor(), 1).evaluate(wi, wo, 200_000, rng).value[0, 1]
        for name in ("energy-compensated", "walk-low-variance")
    ]
    apart = np.abs(lobes[0] - lobes[1]).sum() / 2 * 2 * np.pi / wo.shape[1]
    assert mine.error == pytest.approx(apart, rel=0.05)


def test_the_cheapest_within_the_tolerance_is_chosen():
    smooth = surface(slopes=(ms.Ggx(0.02, 0.02),), theta=(0.0, 0.5))
    rough = surface(slopes=(ms.Ggx(0.5, 0.5),))
    easy, hard = recommend([smooth, rough], 0.01, 1, True)
    assert [c.method for c in easy.candidates] == ["single"], "no work on what is dearer"
    assert easy.chosen is easy.candidates[0]
    at = hard.verdicts.index(CHOSEN)
    assert set(hard.verdicts[:at]) <= {TOO_FAR, CLOSE}
    assert all(c.error > 0.005 for c in hard.candidates[:at])
    assert hard.chosen.error + hard.chosen.uncertainty <= 0.01
    facets = [c.facets for c in hard.candidates]
    assert facets == sorted(facets)


def test_the_sheet_says_what_walks_say():
    (material,) = (m for m in sheet.MATERIALS if isinstance(m, Diffuse))
    it = SceneSurface("diffuse", material, (ms.Ggx(0.4, 0.4),), (0.5,))
    found = sheet.entries(it)
    result = ms.walk(ms.Smith(ms.Ggx(0.4, 0.4), material), ms.direction(0.5), 400_000, orders=10)
    later = 1 - np.cumsum(result.energy.sum(axis=1))
    assert [e.tolerance for e in found] == [0.1, 0.01, 0.001]
    for e in found:
        # 400000 walks know .001 to 5 %.
        assert later[e.bounces - 1] < 1.2 * e.tolerance
        assert e.bounces == 1 or later[e.bounces - 2] > 0.8 * e.tolerance
        assert e.error == pytest.approx(later[e.bounces - 1], rel=0.2)
    assert found[0].perceptual == pytest.approx(np.sqrt(0.4))


def test_what_cannot_be_judged_says_why():
    (found,) = recommend([surface(slopes=(ms.Ggx(1e-3, 1.0),))], 1e-4, 1, True)
    assert found.chosen is None
    assert "memory" in found.reason
