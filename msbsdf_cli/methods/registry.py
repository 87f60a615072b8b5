"""The methods by name, each imported only when it is asked for."""

from collections.abc import Iterable, Iterator, Mapping
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from msbsdf_cli.methods.protocol import Method
    from msbsdf_cli.smith.slopes import Slopes
    from surfaces.materials import Material

PLACES = {
    "single": ("single", "Single"),
    "walk": ("walk", "Walk"),
    "walk-low-variance": ("walk_low_variance", "WalkLowVariance"),
    "position-free-uncorrelated": ("position_free", "PositionFreeUncorrelated"),
    "position-free-correlated": ("position_free", "PositionFreeCorrelated"),
    "exact": ("exact", "Exact"),
    "solve": ("solve", "Solve"),
    "energy-compensated": ("energy_compensated", "EnergyCompensated"),
    "turquin": ("turquin", "Turquin"),
    "published": ("published.method", "Published"),
    "walk-memory": ("walk_memory", "WalkMemory"),
}
"""Module in this package and class of each method."""


class _Lazy(Mapping[str, "type[Method]"]):
    def __getitem__(self, name: str) -> "type[Method]":
        module, cls = PLACES[name]
        loaded: type[Method] = getattr(import_module(f"msbsdf_cli.methods.{module}"), cls)
        return loaded

    def __iter__(self) -> Iterator[str]:
        return iter(PLACES)

    def __len__(self) -> int:
        return len(PLACES)


def holds(method: str, slopes: "Slopes", material: "Material") -> bool:
    """Whether a method can do these slopes and this material."""
    from msbsdf_cli.methods.protocol import UnsupportedError

    try:
        METHODS[method].check_supported(slopes, material)
    except UnsupportedError:
        return False
    return True


def most_trusted(methods: Iterable[str]) -> str | None:
    """The one of these methods that others are held against: of the Smith model with all its
    bounces, without noise where there is one, else the first; None where there is none."""
    whole = []
    for name in methods:
        traits = METHODS[name].traits
        if traits.model == "smith" and traits.conserves_energy and traits.consistent:
            whole.append(name)
    return min(whole, key=lambda name: not METHODS[name].deterministic, default=None)


METHODS: Mapping[str, "type[Method]"] = _Lazy()
"""Class of each method: `METHODS[name](slopes, material, orders)` is a `protocol.Method`."""
