"""A method bound to a model: the face that every method shows to a notebook."""

from dataclasses import dataclass

import numpy as np

from msbsdf_cli.checks import count, direction_in, directions_out, one_of
from msbsdf_cli.methods.protocol import Evaluation, Method
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.model import Smith
from surfaces.facet import Array
from surfaces.spectrum import spectrum
from surfaces.streams import stream


@dataclass(frozen=True)
class Bsdf:
    """A BSDF by one method, set up for all pairs of directions."""

    name: str
    model: Smith
    orders: int
    method: Method

    def evaluate(self, wi: Array, wo: Array, samples: float = 10_000, seed: int = 0) -> Evaluation:
        """BSDF x cos(theta_o) per steradian for unit vectors `wi` (3,), z > 0, and `wo` (3,) or
        (3, n): `value` and `stderr`, (channels, orders + 1, n), orders 1 to `orders` and all the
        later ones. To the error of noisy methods belongs what one walk more may bring.

        `samples` is the number of walks; methods without noise take none. Raises ValueError for
        what is no such direction or number.
        """
        wi, wo = direction_in(wi), directions_out(wo)
        samples = count(samples, "samples")
        rng = stream(count(seed, "seed", 0), "evaluate", self.name, 0, 0)
        found = self.method.evaluate(wi, wo.astype(wi.dtype), samples, rng)
        undersampled = self.method.undersampling(wi, wo.astype(wi.dtype), samples, rng)
        stderr = np.array(found.stderr)
        stderr[:, 1:] = np.hypot(stderr[:, 1:], undersampled[:, None])
        return Evaluation(found.value, stderr, found.unresolved)

    def sample(self, wi: Array, n: float, seed: int = 0) -> tuple[Array, Array]:
        """`n` outgoing directions (3, n) and their weights (channels, n), BSDF x cos / density."""
        rng = stream(count(seed, "seed", 0), "evaluate", self.name, "sample")
        return self.method.sample(direction_in(wi), count(n, "n"), rng)

    def pdf(self, wi: Array, wo: Array) -> Array:
        """A density (n,) per steradian to weigh samples of `sample` against other strategies."""
        wi = direction_in(wi)
        return self.method.pdf(wi, directions_out(wo).astype(wi.dtype))


def methods() -> tuple[str, ...]:
    """Names of all methods."""
    return tuple(METHODS)


def method(name: str, model: Smith, orders: int = 4, autocorrelation: str = "gaussian") -> Bsdf:
    """The method `name` for a model, orders 1 to `orders` told apart. `autocorrelation` is that of
    the surfaces which `walk-memory` remembers.

    Raises UnsupportedError, a ValueError, for a material or slopes that it does not hold for, and
    ValueError for a name that is none.
    """
    one_of(name, METHODS, "a method")
    spectrum(autocorrelation)
    orders = count(orders, "orders")
    made = METHODS[name].on(model.slopes, model.material, orders, autocorrelation)
    return Bsdf(name, model, orders, made)
