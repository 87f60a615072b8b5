"""What holds of every slope distribution over its whole domain."""

import numpy as np
import pytest
from domain import above, precision, slopes
from hypothesis import given
from hypothesis import strategies as st

from msbsdf_cli.smith.slopes import Beckmann, Ggx, StudentT
from surfaces.facet import dot


@given(slopes(), above())
def test_projected_areas_of_both_sides_differ_by_the_cosine(distribution, w):
    """sigma(-w) - sigma(w) = w_z, [HHdD16] Eqs. 21 and 22; to rounding of the larger one."""
    up, down = distribution.sigma(w), distribution.sigma(-w)
    assert np.isfinite(up).all()
    assert (up >= 0).all()
    assert abs(down - up - w[2]) < 1e-12 * (1 + down)


@pytest.mark.parametrize(("dtype", "beside"), [(np.float64, 1e-160), (np.float32, 1e-25)])
@pytest.mark.parametrize("kind", [Beckmann, Ggx, StudentT])
def test_next_to_the_pole_is_as_at_the_pole(kind, dtype, beside):
    w = np.array([[beside], [0], [1]], dtype)
    distribution = kind(0.5, 0.5)
    assert distribution.sigma(w) < 1e-20
    assert distribution.sigma(-w) == 1
    m = distribution.visible_normals(w, 16, np.random.default_rng(0))
    assert (m[2] > 0).all()
    assert np.isfinite(m).all()


@given(slopes(), above(), precision, st.integers(0, 2**32 - 1))
def test_visible_normals_face_the_viewer(distribution, w, dtype, seed):
    w = w.astype(dtype)
    rng = np.random.default_rng(seed)
    for wi in (w, -w):
        if distribution.sigma(-wi) <= 0:
            continue  # Of a direction that sees nothing there is nothing to draw.
        m = distribution.visible_normals(wi, 64, rng)
        assert m.dtype == dtype
        assert np.isfinite(m).all()
        assert (m[2] > 0).all()
        # What a facet seen edge-on shows is rounding of the terms of the product.
        size = np.abs(m * wi).sum(axis=0)
        assert (dot(m, np.broadcast_to(wi, m.shape)) >= -8 * np.finfo(dtype).eps * size).all()


@given(slopes(), above(), precision)
def test_densities_of_normals_are_finite_and_not_negative(distribution, m, dtype):
    with np.errstate(all="ignore"):
        density = distribution.D(m.astype(dtype))
    assert (density >= 0).all()
    assert not np.isnan(density).any()


@given(slopes(), above())
def test_turning_a_direction_by_half_changes_nothing(distribution, w):
    turned = w * np.array([[-1.0], [-1.0], [1.0]])
    assert distribution.sigma(w) == distribution.sigma(turned)
    assert distribution.D(w) == distribution.D(turned)
