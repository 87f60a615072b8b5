"""Results that hold the sums they came from, so that they merge, save and load."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from msbsdf_cli.checks import kind_of
from msbsdf_cli.results import npz
from msbsdf_cli.results.files import Table, from_rows
from msbsdf_cli.results.lobes import Lobes, lobes_of, order_names
from msbsdf_cli.statistics.tally import SIDES, Estimate, Tally
from surfaces.facet import Array

FORMAT = "result of msbsdf 1"


@dataclass(frozen=True)
class Result:
    """Light that leaves a surface, simulated or modelled, for one incident direction.

    Arrays are (orders + 1, 2): orders 1 to `orders` and all the later ones, reflected and
    transmitted; energies are fractions of the incident energy.
    """

    kind: str
    """`simulate` or `walk`."""
    settings: dict[str, Any]
    """All that two results must share to be one: model or surface, direction, orders."""
    seeds: tuple[int, ...]
    sums: Array
    """(parts, figures): one part for each piece of the surface, or the sum and the sum of squares
    over walks."""
    rays: Array
    """Rays or walks of each part, (parts,); of walks, the same twice."""
    facets: int
    """Facets hit by all of them."""

    @property
    def orders(self) -> int:
        """Orders told apart."""
        return int(self.settings["orders"])

    @property
    def samples(self) -> int:
        """Rays or walks."""
        return int(self.rays[0] if self.kind == "walk" else self.rays.sum())

    @property
    def energy(self) -> Array:
        """Energy that leaves after each order on each side."""
        return self.estimate("energy").value

    @property
    def energy_stderr(self) -> Array:
        """Standard errors of `energy`: over walks, or over pieces of the surface."""
        return self.estimate("energy").stderr

    @property
    def absorbed(self) -> float:
        """Energy that facets kept."""
        return float(self.estimate("absorbed").value)

    @property
    def unresolved(self) -> float:
        """Energy that was not followed to its end."""
        return float(self.estimate("unresolved").value)

    @property
    def bounces_mean(self) -> float:
        """Facets hit by a ray or walk, in the mean."""
        return self.facets / self.samples

    def estimate(self, name: str) -> Estimate:
        """Mean and standard error of `energy`, `moments`, `lobe`, `sequence`, `side`, `absorbed` or
        `unresolved`; shapes as `msbsdf_cli.statistics.tally.Tally.estimate` says."""
        return self._tally.estimate(name)

    @cached_property
    def _tally(self) -> Tally:
        if self.kind == "walk":
            tally = Tally(self.orders)
            tally.sums[:] = self.sums
            tally.units = tally.rays = self.samples
            return tally
        total = Tally(self.orders)
        for sums, rays in zip(self.sums, self.rays, strict=True):
            part = Tally(self.orders, independent=False)
            part.sums[0], part.rays = sums, int(rays)
            total.merge(part.as_unit())
        return total

    def lobes(self) -> Lobes:
        """The light that left, with standard errors, as `compare` and the plots take it."""
        x, y, z = self.settings["wi"]
        theta, phi = math.acos(min(z, 1)), math.atan2(y, x)
        transmits = bool(self.energy[:, 1].any())
        return lobes_of(self.kind, (theta,), phi, transmits, [self._tally])

    def save(self, path: str | Path) -> None:
        """Write the sums to an .npz file, whole or not at all; a file that is there is replaced."""
        about = {name: getattr(self, name) for name in ("kind", "settings", "seeds", "facets")}
        npz.write(path, FORMAT, about, {"sums": self.sums, "rays": self.rays})

    def to_columns(self) -> Table:
        """Energies as columns of order, side, energy and standard error, for tables elsewhere."""
        rows = [
            (order, side, float(self.energy[k, s]), float(self.energy_stderr[k, s]))
            for k, order in enumerate(order_names(self.orders))
            for s, side in enumerate(SIDES)
        ]
        return from_rows(("order", "side", "energy", "stderr"), rows)


def load(path: str | Path) -> Result:
    """A result that `Result.save` wrote. Raises ValueError for a file that is none."""
    about, arrays = npz.read(path, FORMAT)
    try:
        sums, rays = arrays["sums"], arrays["rays"]
        known = about["kind"], about["settings"], tuple(about["seeds"])
        result = Result(*known, sums, rays, about["facets"])
        size = Tally(result.orders).sums.shape[1]
        parts = 2 if result.kind == "walk" else len(rays)
        if sums.shape != (parts, size) or rays.shape != (parts,) or not np.isfinite(sums).all():
            raise ValueError("its sums do not fit its settings")
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{path} does not hold a result of msbsdf: {error}.") from None
    return result


def merge(results: Sequence[Result]) -> Result:
    """One result of all the light of several: of other seeds, or other machines.

    Its error bars are those of one long run. Raises ValueError where they are not of one scene, or
    a seed is in two of them, whose light would be counted twice.
    """
    kind_of(results, Sequence, "a list of results")
    for result in results:
        kind_of(result, Result, "a result of simulate or walk")
    if not results:
        raise ValueError("no results are given to merge.")
    first = results[0]
    for other in results[1:]:
        if other.kind != first.kind:
            raise ValueError(f"the results are of `{first.kind}` and of `{other.kind}`.")
        for name in {*first.settings, *other.settings}:
            a, b = (r.settings.get(name) for r in (first, other))
            if a != b:
                raise ValueError(f"the results differ in {name}: {a} and {b}.")
    seeds = [seed for result in results for seed in result.seeds]
    twice = {seed for seed in seeds if seeds.count(seed) > 1}
    if twice:
        raise ValueError(f"the seed {min(twice)} is in two results: its light would count twice.")
    return replace(
        first,
        seeds=tuple(seeds),
        sums=np.sum([r.sums for r in results], axis=0),
        rays=np.sum([r.rays for r in results], axis=0),
        facets=sum(r.facets for r in results),
    )
