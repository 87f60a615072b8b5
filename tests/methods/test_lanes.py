"""Pairs of directions one by one, with a roughness each, against many directions of one surface."""

import pickle

import numpy as np
import pytest

from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.methods.registry import METHODS, holds
from msbsdf_cli.scene import direction
from msbsdf_cli.smith.slopes import Beckmann, Ggx, Slopes
from surfaces.materials import Conductor, Dielectric, Diffuse, Material
from surfaces.materials.diffuse import TexturedDiffuse
from surfaces.streams import stream

GOLD = Conductor.named("gold", rgb=True)
MATERIALS = {"gold": GOLD, "diffuse": Diffuse((0.9, 0.5, 0.2)), "glass": Dielectric(1.5)}
PAIRS = [
    (direction(0.3), direction(0.8, 2.0), 0.3),
    (direction(1.3), direction(1.2, 3.0), 1.0),
    (direction(1.0), direction(2.2, 3.0), 0.5),
]
"""Incident and outgoing direction, and roughness."""
LANES = 12_000
WALKS = 30_000
LIMIT = 4.5
"""Standard errors: of the 200 means of this file one would be further off in 700 runs."""


def textured(name: str, slopes: Slopes, material: Material):
    """Method with the roughness of `PAIRS` in turn, and their directions."""
    order = np.arange(LANES) % len(PAIRS)
    alpha = np.array([pair[2] for pair in PAIRS])[order]
    wi, wo = (np.stack([pair[k] for pair in PAIRS], axis=1)[:, order] for k in (0, 1))
    method = METHODS[name](slopes, material, 1)
    return method.of_lanes(slopes.of_lanes(alpha, alpha), material), wi, wo


def cases():
    for name in METHODS:
        for kind, material in MATERIALS.items():
            if METHODS[name].traits.pairs and holds(name, Ggx(1.0, 1.0), material):
                yield pytest.param(name, material, id=f"{name}-{kind}")


@pytest.mark.parametrize(("name", "material"), list(cases()))
def test_lanes_have_the_values_and_samples_of_their_surfaces(name, material):
    rng = stream(1, "evaluate", "lanes", name)
    lanes, wi, wo = textured(name, Ggx(1.0, 1.0), material)
    # Pictures are made in other processes.
    lanes = pickle.loads(pickle.dumps(lanes))
    value = lanes.evaluate_each(wi, wo, rng)
    w, weight = lanes.sample_each(wi, rng)
    density = lanes.pdf_each(wi, wo)
    for k, (w_i, w_o, alpha) in enumerate(PAIRS):
        of = METHODS[name](Ggx(alpha, alpha), material, 1)
        known = of.evaluate(w_i, w_o[:, None], WALKS, rng)
        mine = value[:, k :: len(PAIRS)]
        # Tables over roughness are interpolated: what they state to be off by.
        table = getattr(getattr(lanes, "E", None), "error", 0.0) * 2
        assert_same(mine, known.value.sum(axis=1)[:, 0], np.hypot(*known.stderr[:, :, 0].T), table)
        directions, weights = of.sample(w_i, LANES, rng)
        theirs = weights * directions[2]
        spread = theirs.std(axis=1) / np.sqrt(LANES)
        mine = (weight * w[2])[:, k :: len(PAIRS)]
        assert_same(mine, theirs.mean(axis=1), spread, table)
        if material.specular:
            own = of.pdf(w_i, w_o[:, None])[0]
            assert density[k] == pytest.approx(own, abs=1e-12 + table)


def assert_same(lanes, value, stderr, slack):
    error = np.hypot(lanes.std(axis=1) / np.sqrt(lanes.shape[1]), stderr)
    assert (np.abs(lanes.mean(axis=1) - value) < LIMIT * error + slack + 1e-9).all()


@pytest.mark.parametrize("name", ["single", "walk", "walk-low-variance", "exact", "published"])
def test_lanes_have_albedos_of_their_own(name):
    lanes, wi, wo = textured(name, Ggx(1.0, 1.0), Diffuse())
    albedos = np.array([[0.9, 0.5, 0.2]])[:, np.arange(LANES) % len(PAIRS)]
    lanes = lanes.of_lanes(lanes.slopes, TexturedDiffuse(lanes=albedos))
    rng = stream(2, "evaluate", "lanes", name)
    value, weight = lanes.evaluate_each(wi, wo, rng), lanes.sample_each(wi, rng)[1]
    for k, (w_i, w_o, alpha) in enumerate(PAIRS[:2]):
        of = METHODS[name](Ggx(alpha, alpha), Diffuse(float(albedos[0, k])), 1)
        known = of.evaluate(w_i, w_o[:, None], WALKS, rng)
        mine = value[:, k :: len(PAIRS)]
        assert_same(mine, known.value.sum(axis=1)[:, 0], np.hypot(*known.stderr[:, :, 0].T), 0)
        theirs = of.sample(w_i, LANES, rng)[1]
        mine, spread = weight[:, k :: len(PAIRS)], theirs.std(axis=1) / np.sqrt(LANES)
        assert_same(mine, theirs.mean(axis=1), spread, 0)


def test_slopes_of_lanes():
    slopes = Beckmann(0.5, 0.5).of_lanes(np.array([0.1, 0.2, 0.3]), np.array([0.4, 0.5, 0.6]))
    some = slopes.at(np.array([2, 0]))
    assert some.alpha_x.tolist() == [0.3, 0.1]
    assert some.alpha_y.tolist() == [0.6, 0.4]
    with pytest.raises(ValueError, match="a roughness is a finite number above 0"):
        slopes.of_lanes(np.array([0.1, 0.0]), np.array([0.1, 0.1]))


def test_published_searches_for_slopes_lane_by_lane():
    """Beckmann's slopes are searched for, each until it is found: with two roughnesses per lane,
    values are those of the two surfaces."""
    rng = stream(3, "evaluate", "lanes", "published")
    wi, wo, alphas = direction(0.9, 0.4), direction(1.1, 2.5), ((0.3, 0.9), (1.0, 0.2))
    order = np.arange(LANES) % 2
    alpha_x, alpha_y = np.array(alphas)[order].T
    slopes = Beckmann(1.0, 1.0).of_lanes(alpha_x, alpha_y)
    lanes = METHODS["published"](Beckmann(1.0, 1.0), GOLD, 1).of_lanes(slopes, GOLD)
    value = lanes.evaluate_each(*(np.tile(w[:, None], LANES) for w in (wi, wo)), rng)
    for k, alpha in enumerate(alphas):
        of = METHODS["published"](Beckmann(*alpha), GOLD, 1)
        known = of.evaluate(wi, wo[:, None], WALKS, rng)
        stderr = np.hypot(*known.stderr[:, :, 0].T)
        assert_same(value[:, k::2], known.value.sum(axis=1)[:, 0], stderr, 0)


def test_a_method_without_pairs_says_so():
    method = METHODS["solve"](Ggx(0.5, 0.5), Conductor(), 1)
    with pytest.raises(UnsupportedError, match="not pairs"):
        method.of_lanes(Ggx(0.5, 0.5), Conductor())


def test_tables_are_for_one_roughness_and_up_to_theirs():
    method = METHODS["turquin"](Ggx(0.5, 0.5), Conductor(), 1)
    one = np.full(2, 0.3)
    with pytest.raises(UnsupportedError, match="a texture has two"):
        method.of_lanes(Ggx(0.5, 0.5).of_lanes(one, 2 * one), Conductor())
    with pytest.raises(ValueError, match=r"above 0\.5"):
        method.of_lanes(Ggx(0.5, 0.5).of_lanes(2 * one, 2 * one), Conductor())
