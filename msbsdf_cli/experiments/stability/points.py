"""The points of the map: one scene with one parameter driven to its ends."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import Beckmann, Ggx, Slopes, StudentT
from surfaces.materials import Conductor, Dielectric, Diffuse, Material

ORDERS = 3

HORIZON = float(np.nextafter(np.pi / 2, 0))
"""The last float below pi / 2."""

UNIFORM = "uniform numbers"
"""The sweep that only methods which draw numbers are put through."""

ALPHA, THETA = 0.5, 1.0
"""Roughness and polar angle of incidence where something else is varied."""


@dataclass(frozen=True)
class Point:
    """A scene with one incident direction, and what was varied to get there."""

    parameter: str
    value: float | str
    scene: Scene

    @property
    def theta(self) -> float:
        """Incident polar angle in radians."""
        return self.scene.theta[0]

    @property
    def place(self) -> tuple[str, ...]:
        """What tells the point from all others, as in a table's row."""
        value = f"{self.value:.17g}" if isinstance(self.value, float) else self.value
        words = self.scene.material.name, self.scene.slopes.name, f"{self.theta:.17g}"
        return (self.parameter, value, *words)


@dataclass(frozen=True)
class Sweep:
    """One parameter and its values; a few of them, or of the others, make a draft."""

    parameter: str
    values: tuple[float | str, ...]
    scene: Callable[[Scene, float], Scene]
    """The scene of a value."""
    draft: tuple[float | str, ...]
    materials: tuple[str, ...] = ("conductor", "diffuse", "dielectric")
    thetas: tuple[float, ...] = (THETA,)
    thetas_of_draft: tuple[float, ...] = (THETA,)
    slopes: tuple[type[Slopes], ...] = (Beckmann, Ggx)

    def points(self, full: bool) -> Iterator[Point]:
        """All points, or those of a draft: mirrors with GGX slopes, glass and diffuse facets with
        Beckmann's, of which one angle has to do, as they cost quadratures."""
        values, thetas = (self.values, self.thetas) if full else (self.draft, self.thetas_of_draft)
        for material in self.materials:
            for slopes in self.slopes if full else (DRAFTED[material],):
                for theta in thetas if full or material != "diffuse" else thetas[:1]:
                    base = Scene(MATERIALS[material], slopes(ALPHA, ALPHA), (theta,), 0.3, ORDERS)
                    for value in values:
                        number = value if isinstance(value, float) else 0.0
                        yield Point(self.parameter, value, self.scene(base, number))


MATERIALS: dict[str, Material] = {
    "conductor": Conductor(),
    "diffuse": Diffuse(),
    "dielectric": Dielectric(1.5),
}
DRAFTED: dict[str, type[Slopes]] = {"conductor": Ggx, "diffuse": Beckmann, "dielectric": Beckmann}


def _roughness(scene: Scene, alpha: float) -> Scene:
    return scene.of_roughness((alpha, alpha))


def _anisotropy(scene: Scene, ratio: float) -> Scene:
    return scene.of_roughness((1.0, 1 / ratio))


def _theta(scene: Scene, theta: float) -> Scene:
    return replace(scene, theta=(theta,))


def _phi(scene: Scene, phi: float) -> Scene:
    return replace(scene, phi=phi).of_roughness((1.0, 0.2))


def _ior(scene: Scene, ior: float) -> Scene:
    return replace(scene, material=Dielectric(ior))


def _gamma(scene: Scene, gamma: float) -> Scene:
    """Student's slopes, whose tails grow as gamma falls to 3/2."""
    return replace(scene, slopes=StudentT(ALPHA, ALPHA, gamma))


def _absorption(scene: Scene, absorbed: float) -> Scene:
    """Diffuse facets of that absorptance, or mirrors that at normal incidence have it: of the
    index 1 + i k, whose absorptance there is 4 / (4 + k^2)."""
    if not scene.material.specular:
        return replace(scene, material=Diffuse(1 - absorbed))
    return replace(scene, material=Conductor(((1.0, math.sqrt(4 / absorbed - 4)),)))


def _same(scene: Scene, value: float) -> Scene:
    return scene


def _two(scene: Scene, value: float) -> Scene:
    return scene.of_roughness((1.0, 1.0))


SWEEPS = (
    Sweep(
        "roughness",
        (1e-4, 1e-3, 0.01, 0.05, 0.1, 0.3, 1.0, 5.0, 20.0, 100.0),
        _roughness,
        (1e-4, 1e-3, 0.1, 20.0, 100.0),
        thetas=(0.0, THETA, 1.5, 1.5707, HORIZON),
        thetas_of_draft=(THETA, 1.5707),
    ),
    Sweep("anisotropy", (1.0, 10.0, 100.0, 1000.0), _anisotropy, (1000.0,)),
    Sweep(
        "theta",
        (0.0, 1e-8, 1e-4, 0.01, 0.5, 1.4, 1.57, 1.5707, 1.570796, HORIZON),
        _theta,
        (1e-8, HORIZON),
    ),
    Sweep("phi", (0.0, 0.7, math.pi / 2, math.pi), _phi, ()),
    Sweep(
        "ior",
        (1 / 3, 1 / 1.5, 0.9, 1 - 1e-6, 1 + 1e-6, 1.01, 1.33, 2.4, 4.0),
        _ior,
        (1 / 3, 1 + 1e-6, 4.0),
        ("dielectric",),
        (THETA, 1.57),
        (THETA,),
    ),
    Sweep(
        "absorption",
        (1e-5, 1e-3, 0.1, 0.5, 1.0),
        _absorption,
        (1e-5, 1.0),
        ("conductor", "diffuse"),
    ),
    Sweep("gamma", (1.500001, 1.6, 2.0, 10.0, 1e6), _gamma, (), slopes=(StudentT,)),
    Sweep(UNIFORM, ("0", "near 1", "both"), _same, ("both",)),
    Sweep("outgoing", ("zenith", "horizon", "around the horizon"), _two, ("around the horizon",)),
)


def points(full: bool) -> list[Point]:
    """Every point of the map."""
    return [point for sweep in SWEEPS for point in sweep.points(full)]


def find(place: tuple[str, ...]) -> Point:
    """The point of that place, from either map. Raises KeyError for a place that is none."""
    return {point.place: point for full in (False, True) for point in points(full)}[place]
