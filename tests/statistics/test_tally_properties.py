"""What holds of a tally whatever light it counts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from msbsdf_cli.statistics.binning import lobe_bin
from msbsdf_cli.statistics.tally import Tally
from surfaces.light import Light


@st.composite
def lights(draw, orders=3):
    """Some batches of light that leaves, is absorbed or is not followed to its end."""
    batches = []
    for _ in range(draw(st.integers(1, 4))):
        n = draw(st.integers(1, 20))
        rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
        w = rng.standard_normal((3, n))
        w /= np.linalg.norm(w, axis=0)
        weight = rng.random((1, n)) if draw(st.booleans()) else None
        below, resolved = (w[2] < 0) if draw(st.booleans()) else None, draw(st.booleans())
        if below is None:
            w[2] = np.abs(w[2])
        batches.append(Light(draw(st.integers(1, 6)), w, weight, below, resolved=resolved))
    return batches


def counted(batches):
    tally = Tally(3)
    for light in batches:
        tally.add(light)
    return tally


@given(lights())
def test_all_light_is_accounted_for(batches):
    tally = counted(batches)
    parts = [tally.estimate(name).value for name in ("side", "absorbed", "unresolved")]
    assert sum(np.sum(part) for part in parts) == pytest.approx(1)
    energy, lobe = (tally.estimate(name).value for name in ("energy", "lobe"))
    assert lobe.sum(axis=2) == pytest.approx(energy)
    assert energy.sum(axis=0) == pytest.approx(parts[0])


@given(lights(), lights())
def test_tallies_merge_as_if_counted_together(one, two):
    merged, together = counted(one), counted(one + two)
    merged.merge(counted(two))
    assert merged.units == together.units
    np.testing.assert_allclose(merged.sums, together.sums, atol=1e-12)


@given(st.floats(-1, 1), st.floats(-10, 10))
def test_every_direction_has_a_bin(z, phi):
    s = np.sqrt(1 - z * z)
    (place,) = lobe_bin(np.array([[s * np.cos(phi)], [s * np.sin(phi)], [z]]))
    assert 0 <= place < 30 * 60
