"""Facet materials, a file for each; its name on the command line is that of the file.

A material says what a facet does with light, for tracing and for the models alike. A new one is a
new file: `dielectric.py` has the class `Dielectric`. Names are known without importing it.
"""

from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from surfaces.materials._material import Material, Scattered, Scatters, Slopes
    from surfaces.materials.conductor import Conductor
    from surfaces.materials.dielectric import Dielectric
    from surfaces.materials.diffuse import Diffuse

__all__ = [
    "NAMES",
    "Conductor",
    "Dielectric",
    "Diffuse",
    "Material",
    "Scattered",
    "Scatters",
    "Slopes",
    "material",
]

NAMES = tuple(
    sorted(m.name.replace("_", "-") for m in iter_modules(__path__) if not m.name.startswith("_"))
)
"""Names of the materials."""


def material(name: str) -> "type[Material]":
    """The class of a material by name. Raises ValueError for a name that is none."""
    if name not in NAMES:
        raise ValueError(f"{name!r} is not a material: one of {', '.join(NAMES)}.")
    module = import_module(f"{__name__}.{name.replace('-', '_')}")
    found: type[Material] = getattr(module, "".join(map(str.capitalize, name.split("-"))))
    return found


def __getattr__(name: str) -> Any:
    if name in ("Material", "Scattered", "Scatters", "Slopes"):
        return getattr(import_module(f"{__name__}._material"), name)
    for known in NAMES:
        if known.replace("-", "") == name.lower():
            return material(known)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
