"""Scenes, and angles as a person reads them."""

import math

import numpy as np
import pytest

from msbsdf_cli.scene import in_degrees


@pytest.mark.parametrize(
    ("angle", "text"),
    [
        (0.0, "0°"),
        (1.0, "57.3°"),
        (math.radians(89.999), "89.999°"),
        (math.pi / 2, "90°"),
        (math.radians(150), "150°"),
        (np.nextafter(math.pi / 2, 0), "89.99999999999999°"),
    ],
)
def test_angles_next_to_the_horizon_are_not_the_horizon(angle, text):
    assert in_degrees(angle) == text
