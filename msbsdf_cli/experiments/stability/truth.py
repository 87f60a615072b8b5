"""What a cell's figures are held against, none of it from the method that is judged.

The energy of the first order is an integral over facets with edges put where light begins to be
reflected totally or to leave, by two rules of different fineness. All energy together is 1 where
nothing absorbs. The orders in between are those of `solve` where its own error is small enough, and
for `solve` itself those of long walks.
"""

import time
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from msbsdf_cli.experiments.stability.points import Point
from msbsdf_cli.methods.protocol import Evaluation, UnsupportedError
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.methods.solver.first_order import first_order_energy
from msbsdf_cli.methods.solver.size import energy_seconds, value_seconds
from msbsdf_cli.smith.albedo import first_order_albedo
from msbsdf_cli.smith.walk import random_walk
from surfaces.facet import Array
from surfaces.streams import stream

PANELS = (20, 30)
"""Nodes between edges of the two rules, whose difference is the error of the first order."""

DIFFUSE_ERROR, CONTRADICTED = 1e-3, 4
"""Of the first order of diffuse facets, a product rule of 12 by 24 directions, up to grazing; and
the standard errors by which walks contradict it."""

LONG_WALKS = 50
"""Facets in the mean from which walks are out of hand: a hundred times those of ordinary
surfaces."""

MANY_LONGER = 1e-3
"""Share of walks of more than `MOST_FACETS` from which they are too: the longest take most of the
time."""

PILOT, FAR_FACETS = 4096, 4000
"""Walks that tell how many facets they hit, and how far those are followed of which some hit more
than `MOST_FACETS`."""

AFFORDABLE_S, VALUES_AFFORDABLE_S = 3.0, 1.9
"""Seconds up to which a cell is worth a solution of its own, for energies and for values."""

WALKS, MOST_FACETS = 20_000, 200
"""Walks that a cell's truth is made of, and the facets after which they count as unresolved."""


@dataclass(frozen=True)
class Energies:
    """Energy of each order, both sides, and its error, (orders + 1,) each; NaN where unknown."""

    value: Array
    error: Array
    source: str


@dataclass(frozen=True)
class Truth:
    """The truth of one point."""

    point: Point
    seed: int

    @property
    def wi(self) -> Array:
        """The incident direction (3,)."""
        return self.point.scene.wi(self.point.theta)

    def first(self, correlated: bool = True) -> tuple[float, float]:
        """Energy of the first order, and its error."""
        scene = self.point.scene
        if not scene.material.specular:
            if not correlated:
                return float("nan"), float("inf")
            return self._diffuse
        facets = scene.slopes, scene.material, self.wi
        coarse, fine = (first_order_energy(*facets, panel, correlated) for panel in PANELS)
        return fine, abs(fine - coarse)

    @cached_property
    def _diffuse(self) -> tuple[float, float]:
        """Of diffuse facets: the product rule, whose error is no less than what long walks show,
        as tails of slopes may be too heavy for its nodes."""
        scene = self.point.scene
        albedo = float(np.mean(scene.material.albedos))
        value = albedo * float(
            first_order_albedo(scene.slopes, scene.material, self.wi[:, None])[0]
        )
        apart = abs(value - float(self.walked.value[0]))
        shown = apart > CONTRADICTED * float(self.walked.error[0])
        return value, max(DIFFUSE_ERROR, apart if shown else 0.0)

    @property
    def total(self) -> float:
        """Energy of all orders, where nothing absorbs."""
        return float("nan") if self.point.scene.material.absorbs else 1.0

    @cached_property
    def solved(self) -> Energies | None:
        """The orders by `solve`, where it may."""
        scene = self.point.scene
        if energy_seconds(scene.slopes, scene.material) > AFFORDABLE_S:
            return None
        try:
            energy = None if self.solver is None else self.solver.energy(self.wi)
        except ArithmeticError:
            energy = None
        if energy is None:
            return None
        value = (energy.reflected + energy.transmitted)[0]
        return Energies(value, energy.error[0], "solve")

    @cached_property
    def solver(self) -> Solve | None:
        """`solve` for the scene, where it may be asked."""
        scene = self.point.scene
        try:
            Solve.check_supported(scene.slopes, scene.material)
        except UnsupportedError:
            return None
        return Solve(scene.slopes, scene.material, scene.orders)

    def values(self, wo: Array) -> tuple[Evaluation, float] | None:
        """All orders by `solve` in directions `wo` (3, n), and the seconds it took; asked again for
        the same directions it remembers. Raises ArithmeticError where it comes to no end."""
        key = wo.tobytes()
        if key not in self._known and self.solver is not None:
            started = time.perf_counter()
            try:
                found = self.solver.evaluate(self.wi, wo)
                self._known[key] = found, time.perf_counter() - started
            except ArithmeticError as failure:
                self._known[key] = failure
        known = self._known.get(key)
        if isinstance(known, ArithmeticError):
            raise known
        return known

    def affordable_values(self, wo: Array) -> Evaluation | None:
        """Those values where they take no more than some seconds and come to an end."""
        scene = self.point.scene
        if value_seconds(scene.slopes, scene.material) > VALUES_AFFORDABLE_S:
            return None
        try:
            found = self.values(wo)
        except ArithmeticError:
            return None
        return None if found is None else found[0]

    @cached_property
    def _known(self) -> dict[bytes, tuple[Evaluation, float] | ArithmeticError]:
        return {}

    @cached_property
    def walked(self) -> Energies:
        """The orders by long walks in double precision."""
        scene = self.point.scene
        counts = np.zeros(scene.orders + 2)
        squares = np.zeros_like(counts)
        for light in random_walk(
            scene.slopes,
            scene.material,
            self.wi,
            WALKS,
            stream(self.seed, "stability walks", *self.point.place),
            MOST_FACETS,
        ):
            weight = np.ones(light.w.shape[1]) if light.weight is None else light.weight[0]
            k = min(light.order - 1, scene.orders) if light.resolved else -1
            counts[k] += weight.sum()
            squares[k] += (weight * weight).sum()
        mean = counts / WALKS
        stderr = np.sqrt(np.maximum(squares / WALKS - mean * mean, 0) / WALKS)
        # What has not happened in so many walks may yet happen once in as many.
        error = np.hypot(stderr, 1 / WALKS)[:-1]
        error[-1] += mean[-1]
        return Energies(mean[:-1], error, "long walks")

    @property
    def bounces(self) -> float:
        """Facets that a walk hits in the mean, or at least, where that is more than
        `LONG_WALKS`."""
        return self._pilot[0]

    @property
    def longer(self) -> float:
        """Share of walks that hit more than `MOST_FACETS`."""
        return self._pilot[1]

    @cached_property
    def _pilot(self) -> tuple[float, float]:
        scene = self.point.scene
        rng = stream(self.seed, "stability pilot", *self.point.place)
        facets, left, longer, bound = 0, PILOT, 0, 0
        for light in random_walk(scene.slopes, scene.material, self.wi, PILOT, rng, FAR_FACETS):
            number = light.w.shape[1]
            facets += light.order * number
            left -= number
            longer += number if light.order > MOST_FACETS else 0
            # Those still under way have met as many facets at least.
            bound = facets + left * light.order
            if light.order > MOST_FACETS and bound > PILOT * LONG_WALKS:
                longer += left
                break
        return bound / PILOT, longer / PILOT
