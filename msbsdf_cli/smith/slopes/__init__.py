"""Slope distributions, a file for each; its name on the command line is that of the file.

A new distribution is a new file: `student_t.py` has the class `StudentT`, and is `student-t` on the
command line. Names are known without importing it.
"""

from dataclasses import fields
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from msbsdf_cli.smith.slopes._distribution import Lambda, Slopes
    from msbsdf_cli.smith.slopes.beckmann import Beckmann
    from msbsdf_cli.smith.slopes.ggx import Ggx
    from msbsdf_cli.smith.slopes.student_t import StudentT

__all__ = [
    "NAMES",
    "OF_SURFACE",
    "Beckmann",
    "Ggx",
    "Lambda",
    "Slopes",
    "StudentT",
    "distribution",
    "parameters",
]

OF_SURFACE = "surface"
"""Name of the distribution that is counted on a surface, and has no roughness to be given."""

NAMES = tuple(
    sorted(
        m.name.replace("_", "-")
        for m in iter_modules(__path__)
        if not m.name.startswith("_") and m.name != OF_SURFACE
    )
)
"""Names of the distributions that are formulae."""


def distribution(name: str) -> type[Any]:
    """The class of a distribution by name. Raises ValueError for a name that is none."""
    if name not in (*NAMES, OF_SURFACE):
        raise ValueError(f"{name!r} is not a slope distribution: one of {', '.join(NAMES)}.")
    module = import_module(f"{__name__}.{name.replace('-', '_')}")
    found: type[Slopes] = getattr(module, "".join(map(str.capitalize, name.split("-"))))
    return found


def parameters(name: str) -> tuple[str, ...]:
    """Names of a distribution's parameters beyond roughness; none where they are a table."""
    if name == OF_SURFACE:
        return ()
    return tuple(f.name for f in fields(distribution(name)) if not f.name.startswith("alpha"))


def __getattr__(name: str) -> Any:
    if name in ("Lambda", "Slopes"):
        return getattr(import_module(f"{__name__}._distribution"), name)
    for known in NAMES:
        if known.replace("-", "") == name.lower():
            return distribution(known)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
