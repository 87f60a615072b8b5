"""Recommendations: scene files, errors against an independent dear run, choices."""

import numpy as np
import pytest

import msbsdf_cli as ms
from msbsdf_cli.experiments.recommend import sheet
from msbsdf_cli.experiments.recommend.apart import Apart, Place
from msbsdf_cli.experiments.recommend.candidates import (
    Candidate,
    compensated,
    single_bound,
    truncated,
)
from msbsdf_cli.experiments.recommend.cases import cases
from msbsdf_cli.experiments.recommend.choice import (
    CHOSEN,
    CLOSE,
    NEAREST,
    NOT_NEEDED,
    TOO_FAR,
    Wanted,
    judged,
    recommend,
)
from msbsdf_cli.experiments.recommend.light import channels
from msbsdf_cli.experiments.recommend.mitsuba_bsdf import Schlick
from msbsdf_cli.experiments.recommend.scene_file import read_scene
from msbsdf_cli.experiments.recommend.scene_surface import SceneFileError, SceneSurface
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.plots.sheet import draw_sheet
from msbsdf_cli.statistics.colour import albedo_difference
from surfaces.materials import Conductor, Dielectric, Diffuse

GOLD = Conductor.named("gold", rgb=True)


MIRROR, HALF = Conductor(), (ms.Ggx(0.5, 0.5),)


def surface(material=MIRROR, slopes=HALF, theta=(0.0, 1.0)):
    return SceneSurface("it", material, slopes, theta)


def scene(tmp_path, text):
    path = tmp_path / "scene.toml"
    path.write_text(text)
    return read_scene(path)


def test_a_scene_is_read(tmp_path):
    found = scene(
        tmp_path,
        """
        roughness = "perceptual"
        tolerance = 0.02
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
    tap, glass = found.surfaces
    assert found.tolerance == 0.02
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
        (ONE + 'theta = "60"\n', "60deg"),
        (ONE + 'theta = ["90deg"]\n', "below 90 degrees"),
        ("tolerance = 1\n" + ONE, "tolerance"),
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
    found = truncated(cases(surface(material)), 0)
    for n in (1, 2, 3):
        mine = found[n - 1]
        assert mine.bounces == n
        result = ms.walk(
            ms.Smith(ms.Ggx(0.5, 0.5), material), ms.direction(mine.place.theta), 400_000
        )
        later = 1 - result.energy[:n].sum()
        stderr = np.sqrt(later * (1 - later) / 400_000)
        assert abs(mine.error - later) < 4 * stderr + mine.bound - mine.error
    assert (found[-1].error, found[-1].bounces) == (0, 0)
    # The mean number of facets of walks from the angle where they are most.
    assert found[-1].facets == pytest.approx(max(_bounces(material)), rel=0.01)


def _bounces(material):
    model = ms.Smith(ms.Ggx(0.5, 0.5), material)
    return [ms.walk(model, ms.direction(t), 400_000).bounces_mean for t in (0.0, 1.0)]


def test_colour_differences_are_those_of_walks():
    """Each channel walked by itself; gold is darker and paler without its later bounces."""
    it = surface(GOLD, (ms.Ggx(0.8, 0.8),), (0.5,))
    found = truncated(cases(it), 0.01)
    energy = []
    for one in channels(GOLD):
        result = ms.walk(ms.Smith(ms.Ggx(0.8, 0.8), one), ms.direction(0.5), 400_000, orders=10)
        energy.append(result.energy.sum(axis=1))
    total = np.sum(energy, axis=1)
    for n in (1, 2, 3):
        expected = albedo_difference(np.array([e[:n].sum() for e in energy]), total)
        # Energies of 400000 walks are known to .001 of a channel, which moves a colour by .1.
        assert found[n - 1].colour == pytest.approx(expected, abs=0.1)
    assert found[0].colour > 4
    assert np.isnan(truncated(cases(surface()), 0.01)[0].colour), "a single channel has no colour"


def test_a_loose_tolerance_still_keeps_colours():
    """Of gold of roughness .5 single scattering is 12 % off, and 3 in colour."""
    it = surface(GOLD, (ms.Beckmann(0.5, 0.5),), (1.0,))
    (by_colour,), (blind,) = (
        recommend([it], Wanted(0.15, colour), 0, 1, True) for colour in (1.0, 10.0)
    )
    assert blind.chosen.bounces == 1
    assert by_colour.chosen.method != "single"
    assert by_colour.chosen.colour <= 1 < by_colour.candidates[0].colour
    single = next(c for c in by_colour.candidates if c.bounces == 1)
    assert single.albedo < 0.15 < single.error


@pytest.mark.parametrize(
    "material", [Conductor(), GOLD, Diffuse((0.5,)), Dielectric(1.5), Schlick(f0=(0.9, 0.5, 0.0))]
)
@pytest.mark.parametrize("alpha", [0.1, 0.8])
def test_the_bound_of_single_scattering_is_one(material, alpha):
    it = surface(material, (ms.Ggx(alpha, alpha),), (0.0, 0.7, 1.4))
    bound, error = single_bound(it, 0.01), truncated(cases(it), 0.01)[0]
    assert error.error <= bound.bound
    assert not error.colour > bound.colour
    if not material.absorbs:
        assert bound.error == pytest.approx(error.error, abs=1e-4)


def test_two_roughnesses_are_seen_along_both():
    """The worse azimuth of a brushed mirror is found, whichever way it is brushed."""
    along, across = ms.Beckmann(0.1, 0.8), ms.Beckmann(0.8, 0.1)
    found = [truncated(cases(surface(slopes=(s,), theta=(1.0,))), 0)[0] for s in (along, across)]
    assert found[0].error == pytest.approx(found[1].error, rel=1e-3)
    later = [
        1 - ms.walk(ms.Smith(along, Conductor()), ms.direction(1.0, phi), 400_000).energy[0].sum()
        for phi in (0.0, np.pi / 2)
    ]
    # A binomial's five standard deviations.
    assert found[0].error == pytest.approx(max(later), abs=0.003)
    assert max(later) > 1.2 * min(later)
    assert found[0].place.phi != found[1].place.phi


def test_compensation_is_judged_by_its_lobe():
    """Against a sum over other directions, 20 x 40 of the midpoint rule, and walks' own lobe."""
    slopes, wi = ms.Ggx(1.0, 1.0), ms.direction(0.0)
    cos = (np.arange(20) + 0.5) / 20
    phi = 2 * np.pi * np.arange(40) / 40
    sin = np.sqrt(1 - cos**2)
    wo = np.array(
        [np.outer(sin, np.cos(phi)).ravel(), np.outer(sin, np.sin(phi)).ravel(), np.repeat(cos, 40)]
    )

    def lobe(name, walks):
        rng = np.random.default_rng(0)
        return METHODS[name](slopes, Conductor(), 1).evaluate(wi, wo, walks, rng).value[0, 1]

    truth, it = lobe("walk-low-variance", 10_000), surface(slopes=(slopes,), theta=(0.0,))
    found = compensated(cases(it), 0, 0)
    assert [c.method for c in found] == ["turquin", "energy-compensated"]
    for mine in found:
        apart = np.abs(lobe(mine.method, 1) - truth).sum() / 2 * 2 * np.pi / wo.shape[1]
        # The other sum is right to 5 %.
        assert mine.lobe == pytest.approx(apart, abs=0.05 * apart + mine.bound - mine.error)
        assert mine.lobe > 0.02
        assert mine.bound < mine.error + 0.005


def test_the_cheapest_within_the_tolerance_is_chosen():
    smooth = surface(slopes=(ms.Ggx(0.02, 0.02),), theta=(0.0, 0.5))
    rough = surface(slopes=(ms.Ggx(0.5, 0.5),))
    easy, hard = recommend([smooth, rough], Wanted(0.01), 0, 1, True)
    assert [c.method for c in easy.candidates] == ["single"], "no work on what is dearer"
    assert easy.bound_only
    assert easy.chosen is easy.candidates[0]
    at = hard.verdicts.index(CHOSEN)
    assert set(hard.verdicts[:at]) <= {TOO_FAR, CLOSE}
    assert all(c.error > 0.005 for c in hard.candidates[:at])
    assert hard.chosen.bound <= 0.01
    facets = [c.facets for c in hard.candidates]
    assert facets == sorted(facets)
    methods = {c.method for c in hard.candidates}
    assert methods == {"single", "exact", "turquin", "energy-compensated"}


def candidate(method, bounces, facets, error, bound):
    place = Place(0.0, 0.0, (0.5, 0.5))
    return Candidate(method, bounces, facets, error, bound, place, error, error, np.nan)


def test_where_nothing_is_near_enough_the_cheapest_of_the_nearest_is_named():
    found = [
        candidate("single", 1, 1.0, 0.2, 0.21),
        candidate("exact", 2, 1.2, 0.042, 0.05),
        candidate("exact", 0, 1.3, 0.04, 0.045),
    ]
    for tolerance, verdicts in [
        (0.01, [TOO_FAR, NEAREST, NOT_NEEDED]),
        (0.043, [TOO_FAR, NEAREST, NOT_NEEDED]),
        (0.046, [TOO_FAR, CLOSE, CHOSEN]),
        (0.06, [TOO_FAR, CHOSEN, NOT_NEEDED]),
    ]:
        mine = judged(surface(), Wanted(tolerance), lambda: found)
        assert mine.verdicts == verdicts
        assert (
            mine.chosen is found[next(i for i, v in enumerate(verdicts) if v in (CHOSEN, NEAREST))]
        )
        assert mine.floor is found[2]


def test_the_sheet_says_what_walks_say(tmp_path):
    it = SceneSurface("diffuse", Diffuse(), (ms.Ggx(0.4, 0.4),), (0.5,))
    found = sheet.entries(it)
    result = ms.walk(ms.Smith(ms.Ggx(0.4, 0.4), Diffuse()), ms.direction(0.5), 400_000, orders=10)
    later = 1 - np.cumsum(result.energy.sum(axis=1))
    assert [e.tolerance for e in found] == [0.1, 0.01, 0.001]
    for e in found:
        # 400000 walks know .001 to 5 %.
        assert later[e.bounces - 1] < 1.2 * e.tolerance
        assert e.bounces == 1 or later[e.bounces - 2] > 0.8 * e.tolerance
        assert e.error == pytest.approx(later[e.bounces - 1], rel=0.2)
    assert found[0].perceptual == pytest.approx(np.sqrt(0.4))
    assert np.isnan(found[0].smith_from_surfaces)


def test_the_sheet_says_where_more_is_pointless_and_what_is_cheaper(tmp_path):
    """The model 2 % from surfaces, known to 2 x .4 %: pointless is what is asked below 1.2 %."""
    place = Place(0.0, 0.0, (0.5, 0.5))
    row = [Apart(place, 0.0, 0.02, 0.028) for _ in sheet.TRACED_THETAS_DEG]
    floor = sheet.Floor.of([row for _ in sheet.TRACED_ALPHAS])
    it = SceneSurface("conductor", Conductor(), (ms.Beckmann(0.5, 0.5),), (0.0, 1.0))
    found = {(e.theta_i_rad, e.tolerance): e for e in sheet.entries(it, floor)}
    assert found[1.0, 0.001].smith_from_surfaces == pytest.approx(0.02)
    assert found[1.0, 0.001].smith_from_surfaces_stderr == pytest.approx(0.004)
    assert [found[1.0, t].of_use for t in (0.1, 0.01, 0.001)] == ["", 2, 2]
    # What two bounces leave, .8 %, is less than 2 %; one leaves 12 %.
    assert found[1.0, 0.001].bounces == 3
    assert [found[1.0, t].instead for t in (0.1, 0.01)] == ["turquin", ""]
    # Known to 2 x 2 % only, it says nothing of pointless.
    row = [Apart(place, 0.0, 0.02, 0.06) for _ in sheet.TRACED_THETAS_DEG]
    doubtful = sheet.entries(it, sheet.Floor.of([row for _ in sheet.TRACED_ALPHAS]))
    assert {e.of_use for e in doubtful} == {""}
    smooth = SceneSurface("conductor", Conductor(), (ms.Beckmann(0.05, 0.05),), (0.0,))
    assert np.isnan(sheet.entries(smooth, floor)[0].smith_from_surfaces), "none were traced there"
    draw_sheet([*found.values(), *sheet.entries(smooth)], tmp_path / "sheet.png")
    assert (tmp_path / "sheet.png").stat().st_size > 10_000


def test_what_cannot_be_judged_says_why():
    (found,) = recommend([surface(slopes=(ms.Ggx(1e-3, 1.0),))], Wanted(1e-4), 0, 1, True)
    assert found.chosen is None
    assert "memory" in found.reason
