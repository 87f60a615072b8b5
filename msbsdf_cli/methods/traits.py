"""What a method says of itself: data that charts, options and `validate` read."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Traits:
    """What is true of all of a method's values."""

    colour: str
    marker: str
    """Of its points on every chart."""
    model: str = "smith"
    """Whose values they are: those of `smith`, the random walk, or of an approximation by name."""
    conserves_energy: bool = True
    """Whether all light leaves a lossless surface; else only the first order does."""
    reciprocal: bool = True
    correlated: bool = True
    """Whether the first order has height-correlated masking and shadowing."""
    smith_first: bool = True
    """Whether the first order is that of independent heights, which has closed forms."""
    consistent: bool = True
    """Whether samples and values, both orders of arguments and all directions are of one model, so
    that `validate` can hold it to identities; fits and thresholds are not."""
    samples: bool = True
    """Whether it draws outgoing directions."""
    pairs: bool = True
    """Whether it takes pairs of directions one by one, with a roughness each, as pixels ask."""
    one_roughness_textured: bool = False
    """Whether a texture may have one roughness at a point only, for the sake of tables."""
    energy_error: Mapping[str, float] = field(default_factory=dict)
    """Known error of energies by material, 0 where it is not named."""
    energy_error_because: str = ""

    def slack(self, material: str) -> float:
        """Known error of energies for a material."""
        return self.energy_error.get(material, 0.0)
