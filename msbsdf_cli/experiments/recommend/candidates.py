"""How far cheaper models are from the Smith model of all bounces.

An error is the larger of two, both over the light that a surface sends back: of the directional
albedo, and the total variation of the lobe, half the sum of absolute differences over directions.
A model that leaves out late bounces misses exactly their energy. One that replaces all but the
first, as energy compensation does, is off where its lobe of them lies elsewhere.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from msbsdf_cli.experiments.recommend.scene_file import SceneSurface
from msbsdf_cli.methods.registry import METHODS, holds
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.methods.solver.size import energy_seconds, value_seconds
from msbsdf_cli.scene import direction
from msbsdf_cli.smith.albedo import first_order_albedo
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material
from surfaces.quadrature import hemisphere
from surfaces.streams import stream

ORDERS = 10
"""Most bounces that are told apart."""

LOBE_RESOLUTION = 0.6
"""Of `solve` for lobes of several bounces, which are wide: right to a percent of them."""

POLAR = 12, 8
"""Polar angles in which lobes are compared, and twice as many azimuths; and fewer of them: the
difference tells the error."""

BOUND_KNOWN = 1e-5
"""Error of first-order albedos by quadrature."""

COMPENSATED = ("turquin", "energy-compensated")
"""Methods that replace all later bounces, the cheaper first."""


@dataclass(frozen=True)
class Candidate:
    """A model, and its greatest error over the roughnesses, angles and channels of a surface."""

    method: str
    bounces: int
    """Followed; 0 for all."""
    facets: float
    """Met by a path in the mean, at the roughness where they are most: what it costs."""
    error: float
    uncertainty: float
    """Of the error, by the estimates of `solve` and of the sum over directions."""
    theta: float
    """Angle of the greatest error."""
    alpha: tuple[float, float]
    """Its roughness."""


@dataclass(frozen=True)
class Case:
    """A surface at one roughness, from one angle, and the light that it sends back there."""

    slopes: Slopes
    material: Material
    theta: float
    shares: Array
    """Of each order, 1 to `ORDERS` and all later ones, in the channel that bounces most,
    (orders + 1,)."""
    known: float
    """Error of their sum."""
    total: Array
    """Energy (channels,) that leaves."""

    @property
    def wi(self) -> Array:
        """The incident direction (3,)."""
        return direction(self.theta)

    @property
    def later(self) -> Array:
        """Share (orders + 1,) that is still to come after 1, 2, ... facets."""
        return np.maximum(1 - np.cumsum(self.shares), 0)

    @property
    def place(self) -> tuple[float, tuple[float, float]]:
        """Angle and roughness."""
        return self.theta, (self.slopes.alpha_x, self.slopes.alpha_y)


def cases(surface: SceneSurface) -> list[Case]:
    """All roughnesses and angles of a surface, solved. Raises UnsupportedError where `solve` does
    not hold, and ArithmeticError where it comes to no end."""
    return [_case(s, surface.material, t) for s in surface.slopes for t in surface.theta]


@lru_cache(maxsize=1)
def _solved(slopes: Slopes, material: Material, orders: int, resolution: float) -> Solve:
    """The equation of one roughness serves all its angles."""
    return Solve(slopes, material, orders, resolution)


def _case(slopes: Slopes, material: Material, theta: float) -> Case:
    energy = _solved(slopes, material, ORDERS, 1.0).energy(direction(theta))
    each = energy.reflected + energy.transmitted
    total = each.sum(axis=1)
    shares = each / total[:, None]
    channel = int(np.argmin(shares[:, 0]))
    known = float(energy.error[channel].sum() / total[channel])
    return Case(slopes, material, theta, shares[channel], known, total)


def seconds(surface: SceneSurface) -> float:
    """About how many seconds one core needs at most, where the bound does not end it before."""
    material, each = surface.material, 0.0
    for slopes in surface.slopes:
        each += energy_seconds(slopes, material)
        if any(holds(name, slopes, material) for name in COMPENSATED):
            each += LOBE_RESOLUTION * value_seconds(slopes, material)
    return each * len(surface.theta)


def single_bound(surface: SceneSurface) -> Candidate:
    """Single scattering, by what its closed form lacks of 1: an upper bound of its error.

    Without absorption later bounces return that share M of the light. Where a facet reflects from
    F_min to F_max, they return F_max^2 M at most, and the first one F_min (1 - M) at least.
    """
    ratio, found = _most_over_least(surface.material), []
    for slopes in surface.slopes:
        wi = np.array([direction(t) for t in surface.theta]).T
        missing = np.clip(1 - first_order_albedo(slopes, surface.material, wi), 0, 1)
        share = ratio * missing / (ratio * missing + 1 - missing)
        worst, alpha = int(np.argmax(share)), (slopes.alpha_x, slopes.alpha_y)
        place = surface.theta[worst], alpha
        found.append(Candidate("single", 1, 1.0, float(share[worst]), BOUND_KNOWN, *place))
    return max(found, key=lambda c: c.error)


def _most_over_least(material: Material) -> float:
    """F_max^2 / F_min of the channel where it is greatest; of diffuse facets 1 bounds the same."""
    if not material.specular or not material.absorbs:
        return 1.0
    reflected = material.reflectance(np.linspace(0, 1, 201))
    return float((reflected.max(axis=1) ** 2 / reflected.min(axis=1)).max())


def truncated(solved: list[Case]) -> list[Candidate]:
    """Models of 1, 2, ... bounces, and of all of them."""
    walk = "exact" if _all_hold("exact", solved) else "walk"
    # A path meets one facet more unless it has left before.
    facets = 1 + np.cumsum(np.max([case.later for case in solved], axis=0))
    found = []
    for n in range(1, ORDERS + 1):
        worst = max(solved, key=lambda case: case.later[n - 1])
        name, cost = ("single", 1.0) if n == 1 else (walk, float(facets[n - 2]))
        error = float(worst.later[n - 1])
        found.append(Candidate(name, n, cost, error, worst.known, *worst.place))
    return [*found, Candidate(walk, 0, float(facets[-1]), 0.0, 0.0, *solved[0].place)]


def compensated(solved: list[Case]) -> list[Candidate]:
    """Models that replace all bounces but the first, which meet one facet."""
    names = [name for name in COMPENSATED if _all_hold(name, solved)]
    worst: dict[str, tuple[float, float, Case]] = {}
    # None can be further off than all the light that it replaces: the rest need no work.
    for case in sorted(solved, key=lambda case: -case.later[0]):
        wanted = [n for n in names if n not in worst or worst[n][0] < case.later[0]]
        for name, (error, uncertainty) in _apart(case, wanted).items():
            if name not in worst or worst[name][0] < error:
                worst[name] = error, uncertainty, case
    return [
        Candidate(name, 0, 1.0, error, uncertainty, *case.place)
        for name, (error, uncertainty, case) in worst.items()
    ]


def _apart(case: Case, methods: list[str]) -> dict[str, tuple[float, float]]:
    """Error of methods in one case, and its own error."""
    if not methods:
        return {}
    truth = _solved(case.slopes, case.material, 1, LOBE_RESOLUTION)
    rules = [_directions(n, case.material.transmits) for n in POLAR]
    known = [truth.evaluate(case.wi, wo) for wo, _ in rules]
    doubt = (known[0].stderr[:, 1] * rules[0][1]).sum(axis=1) / case.total / 2
    found = {}
    for name in methods:
        method, values = METHODS[name](case.slopes, case.material, 1), []
        for (wo, weight), light in zip(rules, known, strict=True):
            rng = stream(0, "without noise")
            mine = method.evaluate(case.wi, wo, 1, rng).value.sum(axis=1)
            apart = (mine - light.value.sum(axis=1)) * weight
            size = np.maximum(np.abs(apart).sum(axis=1) / 2, np.abs(apart.sum(axis=1)))
            values.append(float((size / case.total).max()))
        found[name] = values[0], abs(values[0] - values[1]) + float(doubt.max())
    return found


def _all_hold(method: str, solved: list[Case]) -> bool:
    return all(holds(method, case.slopes, case.material) for case in solved)


def _directions(polar: int, both_sides: bool) -> tuple[Array, Array]:
    """Outgoing directions (3, n) and their solid angles (n,)."""
    wo, weight = hemisphere(polar, 2 * polar)
    if not both_sides:
        return wo, weight
    return np.concatenate([wo, wo * [[1], [1], [-1]]], axis=1), np.tile(weight, 2)
