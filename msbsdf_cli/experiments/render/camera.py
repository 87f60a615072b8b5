"""A pinhole camera."""

from dataclasses import dataclass

import numpy as np

from surfaces.facet import Array


@dataclass(frozen=True)
class Camera:
    """At `eye`, looking `at` a point, with the vertical upwards in the picture.

    `view` is the angle across the picture in radians, `aspect` its width over its height.
    """

    eye: tuple[float, float, float]
    at: tuple[float, float, float]
    view: float
    aspect: float = 1.5

    def rays(self, x: Array, y: Array) -> Array:
        """Directions (3, n) through places of the picture, from 0 to 1 rightwards and downwards."""
        ahead = np.subtract(self.at, self.eye)
        ahead = ahead / np.linalg.norm(ahead)
        right = np.cross(ahead, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        up, half = np.cross(right, ahead), np.tan(self.view / 2)
        d = (
            ahead[:, None]
            + np.outer(right, half * (2 * x - 1))
            + np.outer(up, half / self.aspect * (1 - 2 * y))
        )
        return np.asarray(d / np.linalg.norm(d, axis=0))
