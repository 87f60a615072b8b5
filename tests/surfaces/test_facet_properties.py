"""What holds of every material over its whole domain."""

import numpy as np
import pytest
from domain import above, index, precision, slopes
from hypothesis import assume, given
from hypothesis import strategies as st

from surfaces.facet import absorptance_conductor, dot, fresnel_dielectric
from surfaces.materials import Conductor, Dielectric, Diffuse

cosine = st.one_of(st.floats(0, 1), st.floats(-300, 0).map(lambda power: 10.0**power))
metal = st.tuples(st.floats(1e-3, 1e4), st.floats(0, 1e4))


@given(cosine, index)
def test_dielectrics_reflect_from_nothing_to_all(cos_i, eta):
    reflectance, cos_t = fresnel_dielectric(np.array([cos_i]), eta)
    assert 0 <= reflectance[0] <= 1
    assert 0 <= cos_t[0] <= 1


@given(cosine, metal, precision)
def test_metals_absorb_from_nothing_to_all(cos_i, eta_k, dtype):
    absorbed = absorptance_conductor(np.array([cos_i], dtype), *map(dtype, eta_k))
    assert 0 <= absorbed[0] <= 1 + 4 * np.finfo(dtype).eps
    kept = Conductor((eta_k,)).reflectance(np.array([cos_i], dtype))
    assert kept[0] == pytest.approx(1 - float(absorbed[0]), abs=1e-12)


@given(
    st.one_of(
        st.just(Conductor()),
        metal.map(lambda pair: Conductor((pair,))),
        st.floats(0, 1).map(Diffuse),
        index.map(Dielectric),
    ),
    above(), above(), st.booleans(), st.integers(0, 2**32 - 1),
)  # fmt: skip
def test_light_leaves_a_facet_as_a_unit_vector(material, wi, m, inside, seed):
    d = -wi
    assume(dot(d, m)[0] < -1e-12)
    n = 16
    d, m = np.repeat(d, n, axis=1), np.repeat(m, n, axis=1)
    within = np.full(n, inside) if material.transmits else None
    out = material.scatter(d, m, within, np.random.default_rng(seed))
    assert np.sqrt(dot(out.d, out.d)) == pytest.approx(1, abs=1e-9)
    through = np.zeros(n, bool) if out.transmitted is None else out.transmitted
    side = dot(out.d, m)
    assert (np.where(through, -side, side) >= -1e-12).all()
    if out.gain is not None:
        assert ((out.gain >= 0) & (out.gain <= 1)).all()


@given(slopes(), above(), above())
def test_a_mirror_scatters_alike_from_both_ends(distribution, a, b):
    mirror = Conductor()
    with np.errstate(all="ignore"):
        forth = mirror.density(distribution, -a, b)
        back = mirror.density(distribution, -b, a)
    assert forth == pytest.approx(back, rel=1e-9)
    assert (forth >= 0).all()
