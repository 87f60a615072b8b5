"""A model of a rough surface: facets of a material, and how they slope."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from msbsdf_cli.checks import count, kind_of
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material


@dataclass(frozen=True)
class Smith:
    """The Smith microsurface of [HHdD16]: heights independent of slopes and of each other."""

    slopes: Slopes
    """`Beckmann`, `Ggx` or `StudentT`."""
    material: Material
    """Of the facets: `Conductor`, `Diffuse` or `Dielectric`."""

    def __post_init__(self) -> None:
        kind_of(self.slopes, Slopes, "a distribution of slopes, such as Ggx(0.5, 0.5),")
        kind_of(self.material, Material, "a material, such as Conductor(),")

    def settings(self) -> dict[str, Any]:
        """Distribution and material in words and numbers."""
        return {"slopes": described(self.slopes), "material": described(self.material)}


def described(thing: Any) -> str:
    """A distribution or material as a text that tells it from any other."""
    home = type(thing).__module__.rpartition(".")[2]
    values = ", ".join(f"{name}={value!r}" for name, value in vars(thing).items())
    return f"{home}.{type(thing).__name__}({values})"


def hemisphere(n: int) -> Array:
    """`n` directions (3, n) spread evenly over the upper hemisphere, 2 pi / n steradians each: a
    spiral whose turns are golden angles (A. Gonzalez, Mathematical Geosciences 42, 2010)."""
    i = np.arange(count(n, "n")) + 0.5
    z, phi = 1 - i / n, np.pi * (3 - np.sqrt(5)) * i
    s = np.sqrt(1 - z * z)
    return np.stack([s * np.cos(phi), s * np.sin(phi), z])
