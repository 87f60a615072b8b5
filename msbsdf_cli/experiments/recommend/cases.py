"""A surface at each of its roughnesses, from each direction that matters, and its light there."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from msbsdf_cli.experiments.recommend.apart import Place, over
from msbsdf_cli.experiments.recommend.scene_surface import SceneSurface
from msbsdf_cli.methods.registry import holds
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material

ORDERS = 10
"""Most bounces that are told apart."""


@dataclass(frozen=True)
class Case:
    """A surface at one roughness, from one direction, and the light that it sends back there."""

    scene: Scene
    """Of one angle."""
    energy: Array
    """Of each order, 1 to `ORDERS` and all later ones, (channels, orders + 1)."""
    known: Array
    """Error of their sum (channels,)."""

    @property
    def total(self) -> Array:
        """Energy (channels,) that leaves."""
        return np.asarray(self.energy.sum(axis=1))

    @property
    def later(self) -> Array:
        """Share (orders + 1,) that is still to come after 1, 2, ... facets, in the channel that
        bounces most."""
        shares = over(self.energy, self.total[:, None])
        channel = int(np.argmin(np.where(self.total > 0, shares[:, 0], 1)))
        return np.maximum(shares[channel].sum() - np.cumsum(shares[channel]), 0)

    @property
    def place(self) -> Place:
        """Direction and roughness."""
        return Place(self.scene.theta[0], self.scene.phi, self.scene.alpha)


def cases(surface: SceneSurface) -> list[Case]:
    """All roughnesses and directions of a surface, solved. Raises UnsupportedError where `solve`
    does not hold, and ArithmeticError where it comes to no end."""
    return [_case(scene, theta) for scene in scenes(surface) for theta in scene.theta]


def scenes(surface: SceneSurface) -> list[Scene]:
    """A scene for each roughness and azimuth: surfaces of two roughnesses are seen along both."""
    found = []
    for slopes in surface.slopes:
        azimuths = (0.0,) if slopes.isotropic else (0.0, math.pi / 2)
        found += [Scene(surface.material, slopes, surface.theta, a, ORDERS) for a in azimuths]
    return found


@lru_cache(maxsize=1)
def _solved(slopes: Slopes, material: Material) -> Solve:
    """The equation of one roughness serves all its directions."""
    return Solve(slopes, material, ORDERS)


def _case(scene: Scene, theta: float) -> Case:
    energy = _solved(scene.slopes, scene.material).energy(scene.wi(theta))
    return Case(one_angle(scene, theta), energy.reflected + energy.transmitted, energy.error.sum(1))


def one_angle(scene: Scene, theta: float) -> Scene:
    """The scene from one of its angles alone."""
    return Scene(scene.material, scene.slopes, (theta,), scene.phi, scene.orders)


def walk_of(solved: list[Case]) -> str:
    """The method that follows bounces one by one at the least cost."""
    return "exact" if all_hold("exact", solved) else "walk"


def facets(solved: list[Case]) -> Array:
    """Met in the mean by paths that are ended after 1, 2, ... `ORDERS` bounces, and by all."""
    # A path meets one facet more unless it has left before.
    return np.append(1.0, 1 + np.cumsum(np.max([case.later for case in solved], axis=0)))


def all_hold(method: str, solved: list[Case]) -> bool:
    """Whether a method can do all roughnesses."""
    return all(holds(method, case.scene.slopes, case.scene.material) for case in solved)
