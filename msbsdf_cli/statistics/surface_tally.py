"""Light on realisations of a surface: each is one unit, helped by what is known of it."""

from dataclasses import dataclass

import numpy as np

from msbsdf_cli.statistics.discretisation import squared_errors
from msbsdf_cli.statistics.regression import regress
from msbsdf_cli.statistics.tally import REST, Tally
from surfaces.facet import Array

SUMS = ("products", "controls", "on_all_meshes")


@dataclass
class SurfaceLight:
    """Light of one incident angle on one surface."""

    unit: Tally
    controls: Array
    """Control variates (k,), each less its known mean."""
    more: Tally | None = None
    """What a mesh without errors would have more, and how far that is in doubt, as
    `msbsdf_cli.statistics.discretisation.extrapolated` tells, where coarser meshes were traced."""
    doubt: Tally | None = None


class SurfaceTally(Tally):
    """Sums over surfaces: of what leaves, of its products with control variates, and of what meshes
    of several finenesses say.

    Figures are estimated by regression on the controls, and extrapolated to a mesh without errors;
    their errors hold what is in doubt about that, and the period's.
    """

    def __init__(self, orders: int, controls: int, extent: float) -> None:
        super().__init__(orders)
        self.products = np.zeros((controls, self.sums.shape[1]))
        """Sums of products of controls and figures."""
        self.controls = np.zeros((controls + 1, controls + 1))
        """Sums of products of 1 and the controls among themselves."""
        self.more, self.doubt = Tally(orders), Tally(orders)
        self.on_all_meshes = np.zeros_like(self.sums)
        """Sums of figures, and of their products with `more`, over the surfaces that have it."""
        self.extent = extent
        """Period, in correlation lengths."""
        self._known: tuple[int, tuple[Array, Array, Array]] | None = None
        """Units that there were when figures were last estimated, and what came out."""

    def add_surface(self, light: SurfaceLight) -> None:
        """Take in the next surface."""
        super().merge(light.unit)
        self.products += np.outer(light.controls, light.unit.sums[0])
        known = np.append(1, light.controls)
        self.controls += np.outer(known, known)
        if light.more is not None and light.doubt is not None:
            self.more.merge(light.more)
            self.doubt.merge(light.doubt)
            figures = light.unit.sums[0]
            self.on_all_meshes += figures, figures * light.more.sums[0]

    def merge(self, other: Tally) -> None:
        """Take in the surfaces of another simulation of the same scene and resolution."""
        assert isinstance(other, SurfaceTally), "one surface is added by `add_surface`"
        super().merge(other)
        for name in SUMS:
            getattr(self, name)[:] += getattr(other, name)
        self.more.merge(other.more)
        self.doubt.merge(other.doubt)

    def arrays(self) -> dict[str, Array]:
        parts = {"more": self.more, "doubt": self.doubt}
        found = {f"{part}_{k}": a for part, t in parts.items() for k, a in t.arrays().items()}
        return super().arrays() | found | {n: getattr(self, n) for n in SUMS}

    def restore(self, arrays: dict[str, Array]) -> None:
        super().restore(arrays)
        for name in SUMS:
            getattr(self, name)[:] = arrays[name]
        for part, tally in (("more", self.more), ("doubt", self.doubt)):
            tally.restore({name: arrays[f"{part}_{name}"] for name in ("counts", "sums")})

    def figures(self) -> tuple[Array, Array]:
        """Estimates of all figures and the squares of their errors: rows for `views`."""
        value, noise, systematic = self._estimated()
        return value, noise + systematic

    @property
    def systematic(self) -> Array:
        """Squares of the errors that more surfaces would not make smaller, a row for `views`."""
        return self._estimated()[2]

    def _estimated(self) -> tuple[Array, Array, Array]:
        """Values, squared noise, and squared systematic errors; once for all that is asked."""
        if self._known is None or self._known[0] != self.units:
            self._known = self.units, self._estimate()
        return self._known[1]

    def _estimate(self) -> tuple[Array, Array, Array]:
        mean, mean_noise = super().figures()
        value, noise = mean, mean_noise
        judged = slice(0, self.views(mean)["energy"].size)
        found = regress(self.sums, self.products, self.controls, judged)
        if found is not None:
            value, noise = found[0], found[1] + self.unseen()
        more, more_noise = self.more.figures()
        value, noise = value + more, noise + more_noise + 2 * self._covariance()
        v, m = self.views(value), self.views(mean)
        self._make_consistent(v, m)
        share = _over(v["energy"], m["energy"])[..., None] ** 2
        self.views(noise)["lobe"][:] = share * self.views(mean_noise)["lobe"]
        return value, noise, squared_errors(self, value, self.more, self.doubt, self.extent)

    def _covariance(self) -> Array:
        """Of the means of all figures and of `more`, which have rays in common; no less than 0,
        where few surfaces tell."""
        n, (figures, products) = self.more.units, self.on_all_meshes
        covariance = (products - figures * self.more.sums[0] / n) / max(n - 1, 1)
        return np.maximum(covariance, 0) / self.units

    def _make_consistent(self, value: dict[str, Array], mean: dict[str, Array]) -> None:
        """Keep what noise may break where a figure is rare: no energy is below 0, and the parts of
        one sum to it. Directions keep the shares that they have in the mean."""
        _share_out([value[name] for name in ("energy", *REST)])
        value["side"][:] = value["energy"].sum(axis=0)
        value["lobe"][:] = mean["lobe"] * _over(value["energy"], mean["energy"])[..., None]
        histories, total = np.maximum(value["sequence"], 0), np.zeros_like(value["energy"])
        order = [self.orders, 0, *(c.bit_length() - 2 for c in range(2, 2 ** (self.orders + 1)))]
        np.add.at(total, order, histories)
        value["sequence"][:] = histories * _over(value["energy"], total)[order]


def _share_out(parts: list[Array]) -> None:
    """Raise to 0 what is below it, and take that from all the rest in proportion."""
    total = 0.0
    for part in parts:
        np.maximum(part, 0, out=part)
        total += float(part.sum())
    for part in parts:
        part /= total


def _over(a: Array, b: Array) -> Array:
    """a / b, and 0 where b is."""
    return np.divide(a, b, out=np.zeros(np.broadcast_shapes(a.shape, b.shape)), where=b != 0)
