"""Scenes to render, a file for each; its name on the command line is that of the file.

A file has a function `stage(texture)` and the `DEFAULTS` of its surface, by the names of options.
"""

from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from msbsdf_cli.experiments.render.stage import Stage

NAMES = tuple(sorted(m.name for m in iter_modules(__path__)))
"""Names of the scenes."""

TEXTURES = ("roughness", "anisotropy", "albedo", "none")
"""What may differ from point to point."""


def defaults(name: str) -> dict[str, Any]:
    """Options of the surface, as they would be typed."""
    return dict(import_module(f"{__name__}.{name}").DEFAULTS)


def stage(name: str, texture: str = "none") -> "Stage":
    """The scene `name`. Raises ValueError for a texture that it does not have."""
    found: Stage = import_module(f"{__name__}.{name}").stage(texture)
    if texture != "none" and found.texture is None:
        raise ValueError(f"scene {name} has no texture: plate has {', '.join(TEXTURES[:-1])}.")
    return found
