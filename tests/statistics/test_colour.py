"""Colour differences: the published test data, and what the conversion must do."""

import numpy as np
import pytest

from msbsdf_cli.statistics.colour import MOST_OF_RELATIVE, albedo_difference, ciede2000, lab

PUBLISHED = """
50 2.6772 -79.7751 50 0 -82.7485 2.0425
50 3.1571 -77.2803 50 0 -82.7485 2.8615
50 2.8361 -74.0200 50 0 -82.7485 3.4412
50 -1.3802 -84.2814 50 0 -82.7485 1.0000
50 -1.1848 -84.8006 50 0 -82.7485 1.0000
50 -0.9009 -85.5211 50 0 -82.7485 1.0000
50 0 0 50 -1 2 2.3669
50 -1 2 50 0 0 2.3669
50 2.4900 -0.0010 50 -2.4900 0.0009 7.1792
50 2.4900 -0.0010 50 -2.4900 0.0010 7.1792
50 2.4900 -0.0010 50 -2.4900 0.0011 7.2195
50 2.4900 -0.0010 50 -2.4900 0.0012 7.2195
50 -0.0010 2.4900 50 0.0009 -2.4900 4.8045
50 -0.0010 2.4900 50 0.0010 -2.4900 4.8045
50 -0.0010 2.4900 50 0.0011 -2.4900 4.7461
50 2.5 0 50 0 -2.5 4.3065
50 2.5 0 73 25 -18 27.1492
50 2.5 0 61 -5 29 22.8977
50 2.5 0 56 -27 -3 31.9030
50 2.5 0 58 24 15 19.4535
50 2.5 0 50 3.1736 0.5854 1.0000
50 2.5 0 50 3.2972 0 1.0000
50 2.5 0 50 1.8634 0.5757 1.0000
50 2.5 0 50 3.2592 0.3350 1.0000
60.2574 -34.0099 36.2677 60.4626 -34.1751 39.4387 1.2644
63.0109 -31.0961 -5.8663 62.8187 -29.7946 -4.0864 1.2630
61.2901 3.7196 -5.3901 61.4292 2.2480 -4.9620 1.8731
35.0831 -44.1164 3.7933 35.0232 -40.0716 1.5901 1.8645
22.7233 20.0904 -46.6940 23.0331 14.9730 -42.5619 2.0373
36.4612 47.8580 18.3852 36.2715 50.5065 21.2231 1.4146
90.8027 -2.0831 1.4410 91.1528 -1.6435 0.0447 1.4441
90.9257 -0.5406 -0.9208 88.6381 -0.8985 -0.7239 1.5381
6.7747 -0.2908 -2.4247 5.8714 -0.0985 -2.2286 0.6377
2.0776 0.0795 -1.1350 0.9033 -0.0636 -0.5514 0.9082
"""
"""The 34 pairs of Sharma, Wu and Dalal 2005, Table 1, and their differences to four digits."""

PAIRS = np.array([[float(x) for x in line.split()] for line in PUBLISHED.split("\n") if line])


def test_the_published_pairs():
    one, other, wanted = PAIRS[:, :3].T, PAIRS[:, 3:6].T, PAIRS[:, 6]
    assert wanted.size == 34
    # Half of the last digit that is printed.
    np.testing.assert_allclose(ciede2000(one, other), wanted, rtol=0, atol=5.1e-5)
    np.testing.assert_allclose(ciede2000(other, one), wanted, rtol=0, atol=5.1e-5)


@pytest.mark.parametrize(
    ("rgb", "expected"),
    [
        # White, black and the primaries of sRGB in L*a*b* under D65, as printed everywhere.
        ((1, 1, 1), (100, 0, 0)),
        ((0, 0, 0), (0, 0, 0)),
        ((1, 0, 0), (53.24, 80.09, 67.20)),
        ((0, 1, 0), (87.73, -86.18, 83.18)),
        ((0, 0, 1), (32.30, 79.19, -107.86)),
        # Half of the light: a lightness of 76.07 by CIE's formula.
        ((0.5, 0.5, 0.5), (76.07, 0, 0)),
    ],
)
def test_albedos_as_colours(rgb, expected):
    # Printed matrices of sRGB have 4 to 7 digits.
    np.testing.assert_allclose(lab(np.array(rgb, float)), expected, atol=0.05)


def test_a_difference_is_bounded_by_that_of_a_channel():
    rng = np.random.default_rng(0)
    rgb = 10 ** rng.uniform(-3, 0, (3, 200_000))
    for share in (1e-3, 1e-2, 0.1):
        less = rgb * (1 - share * rng.integers(0, 2, rgb.shape))
        assert albedo_difference(rgb, less).max() < MOST_OF_RELATIVE * share
        # And the bound is not one that nothing comes near.
        assert albedo_difference(rgb, less).max() > 0.5 * MOST_OF_RELATIVE * share
