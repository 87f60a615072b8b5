"""The position-free models of Wang et al. 2022, with uncorrelated and with correlated heights."""

from functools import partial

import numpy as np

from msbsdf_cli.methods.base import Outgoing, outgoing
from msbsdf_cli.methods.bidirectional import connect_bidirectionally
from msbsdf_cli.methods.estimate import Estimate, batches
from msbsdf_cli.methods.path_factors import FactoredPaths, go_on, leaving_probability, send
from msbsdf_cli.methods.paths import arriving, follow, meet, scatter
from msbsdf_cli.methods.protocol import Evaluation
from msbsdf_cli.methods.sampling import FollowsPaths
from msbsdf_cli.methods.single import first_order, first_order_of_each
from msbsdf_cli.methods.traits import Traits
from msbsdf_cli.smith.integrated_heights import extinction_of
from msbsdf_cli.smith.slopes import Slopes
from msbsdf_cli.smith.walk import BLOCK
from surfaces.facet import Array
from surfaces.materials import Material


class PositionFree(FollowsPaths):
    """Base of the two models, see `msbsdf_cli.methods.path_factors`; single scattering is in closed
    form, and the orders after it come from one of two estimators:

    unidirectional: directions sampled from wi by visible normals, next events towards all wo;
    bidirectional: sub-paths from wi and from wo, all connections, balance heuristic.

    Either is unbiased, with roulette for long paths.
    """

    name = "position-free"
    correlated: bool

    def __init__(
        self, slopes: Slopes, material: Material, orders: int, bidirectional: bool = False
    ) -> None:
        super().__init__(slopes, material, orders)
        self.bidirectional = bidirectional

    def evaluate(self, wi: Array, wo: Array, samples: int, rng: np.random.Generator) -> Evaluation:
        out = outgoing(self.slopes, wo.astype(wi.dtype, copy=False))
        estimate = Estimate(self.material.channels, self.orders, out.n)
        one_batch = self._connect if self.bidirectional else self._send
        for n in batches(samples, out.n):
            one_batch(np.tile(-wi[:, None], n), None, out, estimate, rng)
            estimate.close_batch()
        value, stderr = estimate.mean(samples)
        value[:, 0] = first_order(self.slopes, self.material, wi, out, self.correlated)
        stderr[:, 0] = 0
        return Evaluation(value, stderr)

    def evaluate_each(self, wi: Array, wo: Array, rng: np.random.Generator) -> Array:
        out = outgoing(self.slopes, wo, each=True)
        first = first_order_of_each(self.slopes, self.material, wi, out, rng, self.correlated)
        return first + self._one_path_each(self._send, wi, out, rng)

    def sample(self, wi: Array, n: int, rng: np.random.Generator) -> tuple[Array, Array]:
        """By visible normals, leaving with the model's probability: perfect but for absorption."""
        w = np.empty((3, n), wi.dtype)
        weight = np.ones((self.material.channels, n), wi.dtype)
        for start in range(0, n, BLOCK):
            paths = self._arrive(np.tile(-wi[:, None], min(BLOCK, n - start)))
            paths.slot += start
            while paths.n:
                paths = self._sample_facet(paths, w, weight, rng)
        return w, weight

    def sample_each(self, wi: Array, rng: np.random.Generator) -> tuple[Array, Array]:
        n = wi.shape[1]
        w, weight = np.empty_like(wi), np.ones((self.material.channels, n), wi.dtype)
        paths = self._arrive(-wi, np.arange(n))
        while paths.n:
            paths = self._sample_facet(paths, w, weight, rng)
        return w, weight

    def _arrive(self, d: Array, start: Array | None = None) -> FactoredPaths:
        n = d.shape[1]
        columns = arriving(self.slopes, self.material, d, np.zeros(n, bool))
        extinction = extinction_of(d, columns["sigma"])
        one = np.ones(n, d.dtype)
        return FactoredPaths(**columns, extinction=extinction, throughput=one, start=start)

    def _send(
        self,
        d: Array,
        start: Array | None,
        out: Outgoing,
        estimate: Estimate,
        rng: np.random.Generator,
    ) -> None:
        """Add what paths along `d` (3, n) send to the outgoing directions from their second facet
        on."""
        again = partial(go_on, self.slopes, self.material, correlated=self.correlated, rng=rng)
        paths = self._arrive(d, start)
        paths.m = meet(self.slopes, self.material, paths, rng)
        value = partial(send, self.slopes, self.material, out=out, correlated=self.correlated)
        per_path, paths = out.per_path, again(paths)
        follow(self.slopes, self.material, paths, per_path, estimate, rng, value, again, order=2)

    def _connect(
        self, d: Array, start: None, out: Outgoing, estimate: Estimate, rng: np.random.Generator
    ) -> None:
        connect_bidirectionally(
            self.slopes, self.material, self.correlated, -d[:, 0], d.shape[1], out, estimate, rng
        )

    def _sample_facet(
        self, paths: FactoredPaths, w: Array, weight: Array, rng: np.random.Generator
    ) -> FactoredPaths:
        """Writes the directions and weights of the paths that leave; the others go on."""
        m = meet(self.slopes, self.material, paths, rng)
        after, transmitted = scatter(self.slopes, self.material, paths, m, rng)
        after.extinction = extinction_of(after.d, after.sigma)
        through = False if transmitted is None else transmitted
        probability = leaving_probability(
            paths.extinction, after.d, after.extinction, through, self.correlated
        )
        leaves = rng.random(after.n, dtype=w.dtype) < probability
        done = after.compress(leaves)
        inside = np.zeros(done.n, bool) if done.inside is None else done.inside
        w[:, done.slot] = np.where(inside, -done.d, done.d)
        if done.weight is not None:
            weight[:, done.slot] = done.weight
        return after.compress(~leaves)


class PositionFreeUncorrelated(PositionFree):
    """Heights of arriving and leaving are independent: reciprocal [WJFYHY22 supp. 2.1]."""

    name = "position-free-uncorrelated"
    traits = Traits("#cc79a7", "^", model="position-free-uncorrelated", correlated=False)
    correlated = False


class PositionFreeCorrelated(PositionFree):
    """Heights of arriving and leaving are the same; its single scattering is the classic one, but
    later orders are not reciprocal [WJFYHY22 supp. 2.2]."""

    name = "position-free-correlated"
    traits = Traits("#882255", "v", model="position-free-correlated", reciprocal=False)
    correlated = True
