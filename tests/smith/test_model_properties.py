"""What holds of heights, masking, free paths, energies and walks over the whole domain."""

import numpy as np
from domain import above, index, precision, slopes
from hypothesis import given, settings
from hypothesis import strategies as st

from msbsdf_cli.smith.albedo import first_order_albedo
from msbsdf_cli.smith.heights import HEIGHTS
from msbsdf_cli.smith.masking import masking_shadowing
from msbsdf_cli.smith.slopes import Beckmann
from msbsdf_cli.smith.visible_slopes import visible_slopes
from msbsdf_cli.smith.walk import exponential, flip, free_path, random_walk
from surfaces.materials import Conductor, Dielectric, Diffuse

seeds = st.integers(0, 2**32 - 1)
coordinates = st.floats(1e-300, 700)
"""t = -ln C1, down to where C1 is the least of floats."""


@given(st.lists(st.floats(-40, 40), min_size=2, max_size=20))
def test_more_of_the_surface_lies_below_what_is_higher(heights):
    h = np.sort(np.array(heights))
    for distribution in HEIGHTS.values():
        t = distribution.t(h)
        assert (t >= 0).all()
        assert (t[1:] <= t[:-1]).all()


@given(slopes(), above(), above())
def test_masking_and_shadowing_is_reciprocal_and_less_than_one(distribution, wi, wo):
    for correlated in (True, False):
        seen = masking_shadowing(distribution, wi, wo, False, correlated) * wi[2]
        back = masking_shadowing(distribution, wo, wi, False, correlated) * wo[2]
        assert 0 <= seen[0] <= 1 + 1e-12
        assert abs(seen - back) <= 1e-9 * seen
        # B(1 + a, 1 + b) is at most 1, and 0 only where it underflows.
        through = masking_shadowing(distribution, wi, wo, True, correlated) * wi[2]
        assert 0 <= through[0] <= 1 + 1e-12


@given(slopes(), above(), coordinates, precision, seeds)
def test_a_free_path_ends_on_the_surface_or_leaves_it(distribution, w, t, dtype, seed):
    rng = np.random.default_rng(seed)
    for d in (w.astype(dtype), -w.astype(dtype)):
        E = exponential(16, rng, dtype)
        assert (E > 0).all()
        start = np.full(16, max(t, float(np.finfo(dtype).tiny)), dtype)
        leaves, end = free_path(start, d, distribution.sigma(d), E)
        assert end.dtype == dtype
        assert not np.isnan(end).any()
        assert (end > 0).all()
        # Upward one rises, t falls; downward nobody leaves.
        stays = end[~leaves]
        assert (stays <= start[0]).all() if d[2, 0] > 0 else not leaves.any()


@given(coordinates)
def test_turning_the_surface_over_twice_changes_nothing(t):
    once = flip(np.array([t]))
    assert once[0] >= 0
    # C1 is t's exponential: where either share is below the rounding of 1, that much is lost.
    if 1e-12 < t < 25:
        np.testing.assert_allclose(flip(once), t, rtol=1e-9)


@settings(deadline=None, max_examples=40)
@given(slopes(), above(), index)
def test_the_first_order_returns_no_more_than_arrives(distribution, w, ior):
    for material in (Conductor(), Dielectric(ior)):
        albedo = first_order_albedo(distribution, material, w)
        # Its quadrature is one of few nodes, right to a percent at any edge of total reflection.
        assert -1e-12 <= albedo[0] <= 1.02


@settings(deadline=None)
@given(slopes(), above())
def test_visible_slopes_sum_to_the_projected_area(distribution, w):
    m, weight = visible_slopes(distribution, -w)
    assert (weight >= 0).all()
    assert np.isfinite(m).all()
    sigma = distribution.sigma(-w)
    if isinstance(distribution, Beckmann):
        np.testing.assert_allclose(weight.sum(axis=0), sigma, rtol=2e-2)


@settings(deadline=None, max_examples=60)
@given(slopes(), above(), index, precision, seeds)
def test_walks_leave_along_unit_vectors_with_no_more_than_they_brought(
    distribution, w, ior, dtype, seed
):
    wi = w[:, 0].astype(dtype)
    for material in (Conductor(), Diffuse(0.5), Dielectric(ior)):
        walks = list(random_walk(distribution, material, wi, 64, np.random.default_rng(seed), 50))
        directions = np.concatenate([light.w for light in walks], axis=1)
        assert directions.shape[1] == 64
        assert directions.dtype == dtype
        length = np.sqrt((directions.astype(float) ** 2).sum(axis=0))
        # Each of up to 50 facets rounds, and refraction stretches that by the index.
        assert np.abs(length - 1).max() < 1000 * np.finfo(dtype).eps
        for light in walks:
            assert light.weight is None or ((light.weight >= 0) & (light.weight <= 1)).all()
            if light.resolved and not material.transmits:
                assert (light.w[2] >= 0).all()
