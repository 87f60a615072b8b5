"""What holds of every method wherever it does not refuse: values and densities are finite and not
negative, and samples are unit vectors."""

import numpy as np
import pytest
from domain import above, index, precision
from domain import slopes as any_slopes
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from msbsdf_cli.methods import albedo_table
from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.smith.walk import random_walk
from surfaces.materials import Conductor, Dielectric, Diffuse

TABLED = ("energy-compensated", "turquin")
"""Methods that make tables first."""

QUICK = tuple(name for name in METHODS if name not in (*TABLED, "published", "solve"))
"""`published` fails as it is known to; `solve` says beforehand how long it takes, and is tested on
its own."""

WO = np.array([[0, 0, 1], [0.6, 0, 0.8], [-0.6, 0.64, 0.48], [0, 0.28, -0.96], [1, 0, 1e-7]]).T


def ends(slopes, material, wi):
    """Whether walks leave in reasonable time: those of hundreds of facets are the map's subject."""
    walks = random_walk(slopes, material, wi, 64, np.random.default_rng(0), 100)
    return all(light.resolved for light in walks)


anything = given(
    any_slopes(),
    above(),
    index,
    st.floats(0, 1),
    st.sampled_from(["conductor", "diffuse", "dielectric"]),
    precision,
    st.integers(0, 2**32 - 1),
)


@pytest.mark.parametrize("name", QUICK)
@settings(deadline=None, max_examples=60)
@anything
def test_a_method_answers_or_refuses(name, slopes, w, ior, albedo, kind, dtype, seed):
    answers_or_refuses(name, slopes, w, ior, albedo, kind, dtype, seed)


@pytest.fixture(scope="module")
def coarse_tables():
    """Tables of a tenth of the nodes: how fine they are is no matter here, and takes seconds."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(albedo_table, "POLAR_NODES", 16)
        patch.setattr(albedo_table, "AZIMUTHS", 7)
        albedo_table.table_of.cache_clear()
        yield
    albedo_table.table_of.cache_clear()


@pytest.mark.usefixtures("coarse_tables")
@pytest.mark.parametrize("name", TABLED)
@settings(deadline=None, max_examples=12)
@anything
def test_a_method_with_tables_answers_or_refuses(name, slopes, w, ior, albedo, kind, dtype, seed):
    answers_or_refuses(name, slopes, w, ior, albedo, kind, dtype, seed)


def answers_or_refuses(name, slopes, w, ior, albedo, kind, dtype, seed):
    wi, wo = w[:, 0].astype(dtype), (WO / np.sqrt((WO * WO).sum(axis=0))).astype(dtype)
    facets = {"conductor": Conductor(), "diffuse": Diffuse(albedo), "dielectric": Dielectric(ior)}
    rng = np.random.default_rng(seed)
    assume(ends(slopes, facets[kind], wi))
    if name == "walk-low-variance":
        # It walks from the other end too.
        assume(all(ends(slopes, facets[kind], w) for w in wo.T if w[2] > 0))
    try:
        METHODS[name].check_supported(slopes, facets[kind])
        method = METHODS[name](slopes, facets[kind], 2)
    except UnsupportedError:
        return
    found = method.evaluate(wi, wo, 8, rng)
    for values in (found.value, found.stderr, method.pdf(wi, wo)):
        assert np.isfinite(values).all()
        assert (values >= 0).all()
    directions, weight = method.sample(wi, 8, rng)
    assert np.isfinite(weight).all()
    assert (weight >= 0).all()
    length = np.sqrt((directions.astype(float) ** 2).sum(axis=0))
    # Each of up to a hundred facets rounds, and refraction stretches that by the index.
    np.testing.assert_allclose(length, 1, rtol=0, atol=1000 * np.finfo(dtype).eps)
