"""What facets are made of, a file for each material; its name is that of the file.

A new material is a new file: `diffuse.py` has the class `Diffuse`, and is `--material diffuse` on
the command line. Names are known without importing it.
"""

from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from surfaces.materials._material import Material, Scattered
    from surfaces.materials.conductor import Conductor
    from surfaces.materials.dielectric import Dielectric
    from surfaces.materials.diffuse import Diffuse

__all__ = ["NAMES", "Conductor", "Dielectric", "Diffuse", "Material", "Scattered", "material"]

NAMES = tuple(sorted(m.name for m in iter_modules(__path__) if not m.name.startswith("_")))
"""Names of the materials."""


def material(name: str) -> type[Any]:
    """The class of a material by name. Raises ValueError for a name that is none."""
    if name not in NAMES:
        raise ValueError(f"{name!r} is not a material: one of {', '.join(NAMES)}.")
    found: type[Material] = getattr(import_module(f"{__name__}.{name}"), name.capitalize())
    return found


def __getattr__(name: str) -> Any:
    if name in ("Material", "Scattered"):
        return getattr(import_module(f"{__name__}._material"), name)
    if name.lower() in NAMES:
        return material(name.lower())
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
