"""Microfacet multiple-scattering BSDFs, put to the test on explicit surfaces.

    import msbsdf_cli as ms

    model = ms.Smith(ms.Ggx(0.5, 0.2), ms.Conductor())
    wi, wo = ms.direction(theta=1.0), ms.hemisphere(64)
    f = ms.method("solve", model).evaluate(wi, wo)

Names are loaded when they are asked for.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from msbsdf_cli.experiments.compare import compare
    from msbsdf_cli.experiments.simulate import simulate
    from msbsdf_cli.experiments.walk import walk
    from msbsdf_cli.methods.bound import Bsdf, method, methods
    from msbsdf_cli.methods.protocol import Evaluation, UnsupportedError
    from msbsdf_cli.model import Smith, hemisphere
    from msbsdf_cli.results.result import Result, load, merge
    from msbsdf_cli.scene import direction
    from msbsdf_cli.smith.slopes import Beckmann, Ggx, StudentT
    from surfaces.field import HeightField
    from surfaces.materials import Conductor, Dielectric, Diffuse

HOMES = {
    "Beckmann": "msbsdf_cli.smith.slopes",
    "Bsdf": "msbsdf_cli.methods.bound",
    "Conductor": "surfaces.materials",
    "Dielectric": "surfaces.materials",
    "Diffuse": "surfaces.materials",
    "Evaluation": "msbsdf_cli.methods.protocol",
    "Ggx": "msbsdf_cli.smith.slopes",
    "HeightField": "surfaces.field",
    "Result": "msbsdf_cli.results.result",
    "Smith": "msbsdf_cli.model",
    "StudentT": "msbsdf_cli.smith.slopes",
    "UnsupportedError": "msbsdf_cli.methods.protocol",
    "compare": "msbsdf_cli.experiments.compare",
    "direction": "msbsdf_cli.scene",
    "hemisphere": "msbsdf_cli.model",
    "load": "msbsdf_cli.results.result",
    "merge": "msbsdf_cli.results.result",
    "method": "msbsdf_cli.methods.bound",
    "simulate": "msbsdf_cli.experiments.simulate",
    "walk": "msbsdf_cli.experiments.walk",
}
"""Where each public name lives."""

__all__ = [
    "Beckmann",
    "Bsdf",
    "Conductor",
    "Dielectric",
    "Diffuse",
    "Evaluation",
    "Ggx",
    "HeightField",
    "Result",
    "Smith",
    "StudentT",
    "UnsupportedError",
    "compare",
    "direction",
    "hemisphere",
    "load",
    "merge",
    "method",
    "methods",
    "simulate",
    "walk",
]


def __getattr__(name: str) -> Any:
    if name == "methods":
        # The folder of that name, which may be called.
        return import_module(f"{__name__}.methods")
    if name not in HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(HOMES[name]), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
