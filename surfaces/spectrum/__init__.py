"""Power spectra of random surfaces, a file for each; its name is that of the file, and a parameter
follows a colon: `matern:1.5`."""

from dataclasses import MISSING, fields
from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from surfaces.spectrum._spectrum import Spectrum
from surfaces.spectrum.gaussian import Gaussian

__all__ = ["GAUSSIAN", "NAMES", "Gaussian", "Spectrum", "spectrum"]

NAMES = tuple(
    sorted(m.name.replace("_", "-") for m in iter_modules(__path__) if not m.name.startswith("_"))
)
"""Names of the spectra, without parameters."""

GAUSSIAN = Gaussian()


def spectrum(text: str) -> Spectrum:
    """A spectrum by name and parameter. Raises ValueError for what is none."""
    if not isinstance(text, str) or text.partition(":")[0] not in NAMES:
        raise ValueError(f"{text!r} is not an autocorrelation: one of {', '.join(NAMES)}.")
    return _named(text)


@cache
def _named(text: str) -> Spectrum:
    name, colon, value = text.partition(":")
    module = import_module(f"{__name__}.{name.replace('-', '_')}")
    kind = getattr(module, "".join(map(str.capitalize, name.split("-"))))
    # Fields without a default are told after the colon.
    parameters = [f.name for f in fields(kind) if f.default is MISSING]
    try:
        values = [float(x) for x in value.split(",")] if colon else []
    except ValueError:
        values = None
    if values is None or len(values) != len(parameters):
        wanted = ":".join((name, *(p.upper() for p in parameters)))
        raise ValueError(f"{text!r} is not an autocorrelation: {wanted} is wanted.")
    found: Spectrum = kind(*values)
    return found
