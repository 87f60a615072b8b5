"""Models that a surface may be shaded by, each with its error and its cost.

A model that leaves out late bounces misses exactly their energy. One that replaces all but the
first, as energy compensation does, is off where its lobe of them lies elsewhere.
"""

import math
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.experiments.recommend.apart import (
    CHANNELS_OF_COLOUR,
    Apart,
    Place,
    by_energy,
    by_lobe,
    over,
)
from msbsdf_cli.experiments.recommend.cases import (
    ORDERS,
    Case,
    all_hold,
    facets,
    scenes,
    walk_of,
)
from msbsdf_cli.experiments.recommend.light import replaced, walked
from msbsdf_cli.experiments.recommend.scene_surface import SceneSurface
from msbsdf_cli.methods.registry import holds
from msbsdf_cli.methods.solver.size import energy_seconds
from msbsdf_cli.smith.albedo import first_order_albedo
from msbsdf_cli.statistics.colour import MOST_OF_RELATIVE
from msbsdf_cli.statistics.distances import Histogram
from surfaces.facet import Array
from surfaces.materials import Material

WALKS = 1_000_000
"""From each angle, for lobes of several bounces: a total variation is known to .001 of all light
(mirror, alpha 0.8)."""

WALKS_PER_S = 2e6
"""Of one core, or more."""

BOUND_KNOWN = 1e-5
"""Error of first-order albedos by quadrature."""

COMPENSATED = ("turquin", "energy-compensated")
"""Methods that replace all later bounces, the cheaper first."""


MEMORY = "walk-memory"
"""The method that follows all bounces and remembers facets; a candidate against surfaces only."""

MEMORY_COSTS = 9
"""Facets that a walk meets in the time in which one that remembers meets one."""


@dataclass(frozen=True)
class Candidate:
    """A model, and its greatest errors over the roughnesses, angles and channels of a surface."""

    method: str
    bounces: int
    """Followed; 0 for all."""
    facets: float
    """Met by a path in the mean, at the roughness where they are most: what it costs."""
    error: float
    bound: float
    """At most so large is the error, as far as known."""
    place: Place
    """Of the greatest error."""
    albedo: float
    lobe: float
    colour: float
    """Colour difference; not a number where there is no colour."""

    @property
    def least(self) -> float:
        """At least so large is the error."""
        return 2 * self.error - self.bound

    @property
    def follows_all(self) -> bool:
        """Whether it is the Smith model itself, of all bounces."""
        return self.bounces == 0 and self.method not in (*COMPENSATED, MEMORY)

    @property
    def cost(self) -> float:
        """In facets of the Smith walk."""
        return self.facets * (MEMORY_COSTS if self.method == MEMORY else 1)

    @classmethod
    def of(
        cls, method: str, bounces: int, facets: float, found: list[Apart], scale: float
    ) -> "Candidate":
        """From what is found at all places; a colour difference counts `scale` times."""
        worst = max(found, key=lambda a: a.error(scale))
        bound = max(a.most(scale) for a in found)
        most = (max(getattr(a, name) for a in found) for name in ("albedo", "lobe", "colour"))
        return cls(method, bounces, facets, worst.error(scale), bound, worst.place, *most)


def seconds(surface: SceneSurface) -> float:
    """About how many seconds one core needs at most, where the bound does not end it before."""
    found = 0.0
    for scene in scenes(surface):
        methods = [m for m in COMPENSATED if holds(m, scene.slopes, scene.material)]
        walks = WALKS / WALKS_PER_S * scene.material.channels * bool(methods)
        # Of two roughnesses one solution serves all directions.
        solved = energy_seconds(scene.slopes, scene.material)
        one = scene.slopes.isotropic
        found += solved * (len(scene.theta) if one else 0.5) + walks * len(scene.theta)
    return found


def single_bound(surface: SceneSurface, scale: float) -> Candidate:
    """Single scattering, by what its closed form lacks of 1: an upper bound of its error.

    Without absorption later bounces return that share M of the light. Where a facet reflects from
    F_min to F_max, they return F_max^2 M at most, and the first one F_min (1 - M) at least.
    """
    ratio, found = _least_over_most(surface.material), []
    colour = MOST_OF_RELATIVE if surface.material.channels == CHANNELS_OF_COLOUR else math.nan
    for scene in scenes(surface):
        wi = np.array([scene.wi(t) for t in scene.theta]).T
        missing = np.clip(1 - first_order_albedo(scene.slopes, scene.material, wi), 0, 1)
        share = over(missing, missing + (1 - missing) * ratio)
        for theta, most in zip(scene.theta, share.tolist(), strict=True):
            known = most + BOUND_KNOWN
            figures = most, most / 2, known, colour * most, colour * known
            found.append(Apart(Place(theta, scene.phi, scene.alpha), *figures))
    return Candidate.of("single", 1, 1.0, found, scale)


def _least_over_most(material: Material) -> float:
    """F_min / F_max^2 of the channel where it is least; of diffuse facets 1 bounds the same."""
    if not material.specular or not material.absorbs:
        return 1.0
    reflected = material.reflectance(np.linspace(0, 1, 201))
    return float((reflected.min(axis=1) / reflected.max(axis=1) ** 2).min())


def truncated(solved: list[Case], scale: float) -> list[Candidate]:
    """Models of 1, 2, ... bounces, and of all of them, against that of all."""
    name, cost, found = walk_of(solved), facets(solved), []
    for n in range(1, ORDERS + 1):
        apart = [
            by_energy(
                case.place,
                (case.energy[:, :n].sum(axis=1), np.zeros_like(case.known)),
                (case.total, case.known),
            )
            for case in solved
        ]
        method = "single" if n == 1 else name
        found.append(Candidate.of(method, n, float(cost[n - 1]), apart, scale))
    nothing = [by_energy(c.place, (c.total, c.known * 0), (c.total, c.known * 0)) for c in solved]
    return [*found, Candidate.of(name, 0, float(cost[-1]), nothing, scale)]


def compensated(solved: list[Case], scale: float, seed: int) -> list[Candidate]:
    """Models that replace all bounces but the first, which meet one facet."""
    names = [name for name in COMPENSATED if all_hold(name, solved)]
    apart: dict[str, list[Apart]] = {name: [] for name in names}
    for case in solved if names else ():
        for name, found in compensation_apart(case, names, WALKS, seed).items():
            apart[name].append(found)
    return [Candidate.of(name, 0, 1.0, apart[name], scale) for name in names]


def compensation_apart(case: Case, names: list[str], walks: int, seed: int) -> dict[str, Apart]:
    """How far methods are off in one case: their later bounces against those of walks."""
    (light,) = walked(case.scene, walks, seed)
    found = {}
    for name in names:
        (mine,) = replaced(name, case.scene)
        lobes = [
            (_without_noise(m), one.orders(1), None)
            for (m, _), one in zip(mine, light, strict=True)
        ]
        first = case.energy[:, 0]
        added = np.array([m.sum() for m, _ in mine])
        model = first + added, np.zeros_like(first)
        off = doubt(first, mine)
        found[name] = by_lobe(case.place, model, (case.total, case.known), lobes, off)
    return found


def doubt(first: Array, mine: list[tuple[Array, float]]) -> Array:
    """What adding up values in bins may have wrong of the energy (channels,) that a method puts in
    the place of later bounces: the part that it has wrong of the first bounce."""
    off = np.array([abs(seen - known) for (_, seen), known in zip(mine, first, strict=True)])
    added = np.array([later.sum() for later, _ in mine])
    return over(off, first) * added


def _without_noise(bins: Array) -> Histogram:
    return Histogram(bins, np.zeros_like(bins))
