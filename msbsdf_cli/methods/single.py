"""The classic microfacet BSDF: one bounce, in closed form."""

import numpy as np

from msbsdf_cli.methods.base import MethodBase, Outgoing, outgoing
from msbsdf_cli.methods.protocol import Evaluation
from msbsdf_cli.methods.traits import Traits
from msbsdf_cli.smith.albedo import first_order_albedo
from msbsdf_cli.smith.masking import masking_shadowing
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array, dot
from surfaces.materials import Material


class Single(MethodBase):
    """One bounce with height-correlated masking and shadowing, [HHdD16] Eqs. 11, 16 and 17.

    No noise: diffuse facets are integrated over by quadrature. The energy that later bounces
    would carry is unresolved.
    """

    name = "single"
    traits = Traits("0.45", "X", model="single", conserves_energy=False)
    deterministic = True

    def evaluate(self, wi: Array, wo: Array, samples: int, rng: np.random.Generator) -> Evaluation:
        value = np.zeros((self.material.channels, self.orders + 1, wo.shape[1]), wi.dtype)
        out = outgoing(self.slopes, wo.astype(wi.dtype, copy=False))
        value[:, 0] = first_order(self.slopes, self.material, wi, out)
        later = 1 - float(first_order_albedo(self.slopes, self.material, wi[:, None])[0])
        return Evaluation(value, np.zeros_like(value), unresolved=max(later, 0.0))

    def sample(self, wi: Array, n: int, rng: np.random.Generator) -> tuple[Array, Array]:
        return self._sample(wi[:, None], n, rng)

    def evaluate_each(self, wi: Array, wo: Array, rng: np.random.Generator) -> Array:
        out = outgoing(self.slopes, wo)
        return first_order_of_each(self.slopes, self.material, wi, out, rng)

    def sample_each(self, wi: Array, rng: np.random.Generator) -> tuple[Array, Array]:
        return self._sample(wi, wi.shape[1], rng)

    def _sample(self, wi: Array, n: int, rng: np.random.Generator) -> tuple[Array, Array]:
        """One facet, by visible normals; the weight is shadowing given masking, 0 for light that
        heads for the surface again."""
        d = -wi
        m = self.slopes.visible_normals(-d, n, rng)
        w, gain, transmitted = self.material.scatter(d, m, None, rng)
        inside = np.zeros(n, bool) if transmitted is None else transmitted
        local = np.where(inside, -w, w)
        passes = np.zeros(n, wi.dtype)
        for side in (False, True):
            lanes = np.flatnonzero((inside == side) & (local[2] > 0))
            if lanes.size:
                here, w_i = self.slopes.at(lanes), _of(lanes, wi)
                passes[lanes] = masking_shadowing(here, w_i, local[:, lanes], side)
        weight = np.broadcast_to(passes * self.slopes.sigma(d), (self.material.channels, n))
        return w, weight if gain is None else weight * gain

    def pdf(self, wi: Array, wo: Array) -> Array:
        """Density (n,) of `sample`; what it sends back into the surface is missing from it."""
        return phase_density(self.slopes, self.material, wi, wo)

    def pdf_each(self, wi: Array, wo: Array) -> Array:
        """Of diffuse facets a cosine lobe: their density is an integral."""
        if not self.material.specular:
            return np.maximum(wo[2], 0) / np.pi
        return phase_density(self.slopes, self.material, wi, wo)


def first_order(
    slopes: Slopes, material: Material, wi: Array, out: Outgoing, correlated: bool = True
) -> Array:
    """BSDF x cos(theta_o) of the first bounce, (channels, n), for `wi` (3,): q G2 / cos(theta_i).

    With correlated heights it is that of [HHdD16] Eqs. 11 and 17, else that of the uncorrelated
    model of [WJFYHY22 supp.].
    """
    return _closed_form(slopes, material, wi[:, None], out, correlated)


def first_order_of_each(
    slopes: Slopes,
    material: Material,
    wi: Array,
    out: Outgoing,
    rng: np.random.Generator,
    correlated: bool = True,
) -> Array:
    """The same, (channels, n), where each outgoing direction has an incident one of its own in `wi`
    (3, n); of diffuse facets an unbiased estimate by one visible normal each."""
    if material.specular:
        return _closed_form(slopes, material, wi, out, correlated)
    m = slopes.visible_normals(wi, out.n, rng)
    q = slopes.sigma(-wi) * material.lobe(dot(m, out.w) / np.sqrt(dot(m, m)))
    passes = masking_shadowing(slopes, wi, out.w, False, correlated)
    return np.asarray(material.kept() * np.where(out.inside, 0, q * passes))


def _closed_form(
    slopes: Slopes, material: Material, wi: Array, out: Outgoing, correlated: bool
) -> Array:
    """q G2 / cos(theta_i), (channels, n), for `wi` (3, 1) or (3, n)."""
    value = np.zeros((material.channels, out.n), wi.dtype)
    for side in (False, True) if material.transmits else (False,):
        lanes = np.flatnonzero((out.inside == side) & (out.w[2] > 0))
        if lanes.size:
            here, w, w_i = slopes.at(lanes), out.w[:, lanes], _of(lanes, wi)
            q = material.density(here, -w_i, w, transmitted=side)
            value[:, lanes] = q * masking_shadowing(here, w_i, w, side, correlated)
    return value


def _of(lanes: Array, wi: Array) -> Array:
    """The incident directions of some lanes, one (3, 1) or many (3, n)."""
    return wi if wi.shape[1] == 1 else wi[:, lanes]


def phase_density(slopes: Slopes, material: Material, wi: Array, wo: Array) -> Array:
    """Density (n,) per steradian of the direction in which the first facet sends light from `wi`
    (3,) or (3, n), whatever it absorbs: q / sigma for a mirror or an albedo of 1."""
    d, lossless = -wi.reshape(3, -1), material.lossless
    density = np.zeros(wo.shape[1], wi.dtype)
    for side in (False, True) if material.transmits else (False,):
        lanes = np.flatnonzero(wo[2] < 0 if side else wo[2] > 0)
        if lanes.size:
            w = -wo[:, lanes] if side else wo[:, lanes]
            here = lossless.density(slopes.at(lanes), _of(lanes, d), w, transmitted=side)
            density[lanes] = here[0]
    return density / slopes.sigma(d)
