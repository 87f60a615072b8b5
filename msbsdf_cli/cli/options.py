"""What the options of all commands mean: their types, defaults and refusals."""

import math
import os
import string
from abc import abstractmethod
from collections.abc import Callable
from typing import Any

import click
from click.shell_completion import CompletionItem

from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.smith.slopes import NAMES as SLOPES
from msbsdf_cli.smith.slopes import OF_SURFACE
from surfaces.materials import NAMES as MATERIALS
from surfaces.materials._metals import METALS

Decorator = Callable[[Callable[..., None]], Callable[..., None]]


def quoted(value: Any) -> str:
    """What was typed, however long or odd, as part of a sentence."""
    text = repr(value) if isinstance(value, str) else str(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


LEAST_ROUGHNESS, MOST_ROUGHNESS = 1e-6, 1e4
"""Far beyond any surface either way; slopes squared still have room in single precision."""

MOST_ANGLES = 100
"""In one run: each has a row of pictures, and 1.5 megabytes of bins."""


class Typed(click.ParamType):
    """What a text means, or a sentence on why it means nothing."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """What is no text is what one has meant."""
        if not isinstance(value, str):
            return value
        try:
            return self.read(value)
        except ValueError as error:
            self.fail(f"{error}", param, ctx)

    @abstractmethod
    def read(self, text: str) -> Any:
        """What `text` means. Raises ValueError with a sentence where that is nothing."""


class Roughness(Typed):
    """`A` or `AX,AY`, positive and finite."""

    name = "A|AX,AY"

    def read(self, text: str) -> tuple[float, float]:
        alphas = _numbers(text)
        if len(alphas) not in (1, 2) or not all(0 < a < math.inf for a in alphas):
            raise ValueError(f"{quoted(text)} is not a roughness: one or two numbers above 0.")
        if not all(LEAST_ROUGHNESS <= a <= MOST_ROUGHNESS for a in alphas):
            wanted = f"a roughness is from {LEAST_ROUGHNESS:g} to {MOST_ROUGHNESS:g}"
            raise ValueError(f"{quoted(text)} is beyond every surface: {wanted}.")
        return alphas[0], alphas[-1]


class Angles(Typed):
    """Angles in radians, or in degrees where a value ends in `deg`, separated by commas; `but` is
    none."""

    name = "T[,T...]"

    def __init__(
        self,
        low: float,
        high: float,
        where: str,
        count: int | None = None,
        but: float = math.inf,
    ) -> None:
        self.low, self.high, self.where, self.count, self.but = low, high, where, count, but

    def read(self, text: str) -> tuple[float, ...]:
        angles = []
        for part in map(str.strip, text.split(",")):
            factor = math.pi / 180 if part.endswith("deg") else 1.0
            angle = _numbers(part.removesuffix("deg"))[0] * factor
            if not self.low <= angle < self.high:
                meant = factor == 1 and self.low <= math.radians(angle) < self.high
                hint = f" Is it {part}deg?" if meant else ""
                raise ValueError(f"{quoted(part)} is not an angle {self.where}.{hint}")
            if angle == self.but:
                raise ValueError(
                    f"{quoted(part)} is not an angle of incidence: such light meets nothing."
                )
            angles.append(angle)
        if self.count is not None and len(angles) != self.count:
            raise ValueError(f"{quoted(text)}: one angle is wanted.")
        if len(angles) > MOST_ANGLES:
            raise ValueError(f"{len(angles)} angles are too many: {MOST_ANGLES} a run.")
        if len(set(angles)) < len(angles):
            raise ValueError(f"{quoted(text)} names an angle twice.")
        return tuple(angles)


class Count(Typed):
    """A whole number from `least` to `most`, also written `1e6`."""

    name = "N"

    def __init__(self, least: int = 1, even: bool = False, most: float = math.inf) -> None:
        self.least, self.even, self.most = least, even, most

    def read(self, text: str) -> int:
        try:
            number = int(text)
        except ValueError:
            (real,) = _numbers(text, count=1)
            if not math.isfinite(real) or real != int(real):
                raise ValueError(f"{quoted(text)} is not a whole number.") from None
            number = int(real)
        if number < self.least:
            raise ValueError(f"{quoted(text)} is too few: at least {self.least} are wanted.")
        if number > self.most:
            raise ValueError(f"{quoted(text)} is too many: at most {self.most:g} are taken.")
        if self.even and number % 2:
            raise ValueError(f"{quoted(text)} is odd: an even number is wanted.")
        return number


class Real(Typed):
    """A finite number for which `holds` is true; `wanted` says so in words."""

    name = "X"

    def __init__(self, holds: Callable[[float], bool], wanted: str) -> None:
        self.holds, self.wanted = holds, wanted

    def read(self, text: str) -> float:
        (number,) = _numbers(text, count=1)
        if not (math.isfinite(number) and self.holds(number)):
            raise ValueError(f"{quoted(text)} is not {self.wanted}.")
        return number


class Numbers(Typed):
    """Numbers from `low` to `high` separated by commas, as many as `count` where it is given."""

    name = "X,X..."

    def __init__(
        self, count: int | None = None, low: float = -math.inf, high: float = math.inf
    ) -> None:
        self.count, self.low, self.high = count, low, high

    def read(self, text: str) -> tuple[float, ...]:
        numbers = _numbers(text, self.count)
        for x in numbers:
            if not self.low <= x <= self.high:
                raise ValueError(f"{x:g} is not from {self.low:g} to {self.high:g}.")
        return numbers


def _numbers(text: str, count: int | None = None) -> tuple[float, ...]:
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        raise ValueError(f"{quoted(text)} is not a number.") from None
    if any(math.isnan(x) for x in numbers) or (count is not None and len(numbers) != count):
        wanted = "a number" if count in (None, 1) else f"{count} numbers"
        raise ValueError(f"{quoted(text)} is not {wanted}.")
    return numbers


class Autocorrelation(Typed):
    """The name of a spectrum, and its parameter."""

    name = "NAME[:X]"

    def read(self, text: str) -> str:
        if text == "gaussian":
            return text
        # Not above: it takes NumPy and SciPy.
        from surfaces.spectrum import spectrum

        return spectrum(text).name


class Autocorrelations(Typed):
    """One of them, or several, separated by commas, none of them twice."""

    name = "NAME[:X],..."

    def read(self, text: str) -> str | tuple[str, ...]:
        names = tuple(map(Autocorrelation().read, map(str.strip, text.split(","))))
        if len(set(names)) < len(names):
            raise ValueError(f"{quoted(text)} names an autocorrelation twice.")
        return names if len(names) > 1 else names[0]


class HeightsOf(Typed):
    """The name of a distribution of heights, and its skewness."""

    name = "NAME[:S]"

    def read(self, text: str) -> str:
        if text == "gaussian":
            return text
        # Not above: it takes NumPy and SciPy.
        from surfaces.marginal import marginal

        return marginal(text).name


UNITS = {"nm": 1e-9, "um": 1e-6, "µm": 1e-6, "mm": 1e-3, "m": 1.0}
LETTERS = "µμ" + string.ascii_letters


class Lengths(Typed):
    """Lengths above 0, in metres or with a unit behind them: `2e-6`, `2um`, `2um,3um`."""

    name = "X[,Y]"

    def __init__(self, most: int = 2) -> None:
        self.most = most

    def read(self, text: str) -> tuple[float, ...]:
        lengths = []
        for part in map(str.strip, text.split(",")):
            number = part.rstrip(LETTERS)
            # An exponent without digits, infinity and the like are numbers that are none.
            unit = part[len(number) :] if number else ""
            if unit and unit not in UNITS:
                raise ValueError(
                    f"{quoted(part)} is in no unit that is known: {', '.join(UNITS)}; a number "
                    "alone is in metres."
                )
            lengths.append(_numbers(number or part)[0] * UNITS.get(unit, 1.0))
        if len(lengths) > self.most or not all(0 < x < math.inf for x in lengths):
            wanted = "a length above 0" if self.most == 1 else "one or two lengths above 0"
            raise ValueError(f"{quoted(text)} is not {wanted}, such as 2e-6 or 2um.")
        return tuple(lengths)


class Methods(Typed):
    """Names of methods separated by commas, and of what else is `also` taken for one; a shell
    completes the last of them."""

    name = "NAME[,NAME...]"

    def __init__(self, also: tuple[str, ...] = ()) -> None:
        self.names = (*METHODS, *also)

    def read(self, text: str) -> tuple[str, ...]:
        names = tuple(dict.fromkeys(part.strip() for part in text.split(",")))
        for name in names:
            if name not in self.names:
                raise ValueError(f"{quoted(name)} is not a method; --help lists them.")
        return names

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        before, comma, last = incomplete.rpartition(",")
        fitting = (name for name in self.names if name.startswith(last))
        return [CompletionItem(f"{before}{comma}{name}") for name in fitting]


_OPTIONS: dict[str, Any] = {
    "material": dict(
        type=click.Choice(MATERIALS),
        default="conductor",
        help="What the facets are made of.",
    ),
    "slopes": dict(type=click.Choice(SLOPES), default="beckmann", help="Slope distribution."),
    "slopes-or-surface": dict(
        type=click.Choice([*SLOPES, OF_SURFACE]),
        default="beckmann",
        help="Slope distribution; surface: that of --surface.",
    ),
    "gamma": dict(
        type=Real(lambda g: g > 1.5, "a gamma: a number above 1.5"),
        default="3",
        metavar="G",
        help="Slopes student-t: GGX at 2, towards Beckmann as it grows.",
    ),
    "surface-slopes": dict(
        type=click.Choice(["beckmann"]),
        default="beckmann",
        help="Slope distribution: a sum of many waves is Beckmann.",
    ),
    "heights": dict(
        type=click.Choice(["uniform", "gaussian"]),
        default="gaussian",
        help="Height distribution of the free paths; the BSDF does not depend on it.",
    ),
    "alpha": dict(type=Roughness(), default="0.5", help="Roughness, along x and y."),
    "theta": dict(
        type=Angles(0, math.nextafter(math.pi, 4), "from 0 to pi (180deg)", but=math.pi / 2),
        default="0,0.5,1,1.5",
        help="Incident polar angles in radians, or with deg behind, such as 30deg; of a dielectric "
        "beyond 90deg from inside.",
    ),
    "theta-furnace": dict(
        type=Angles(0, math.pi / 2, "from 0 to below pi/2 (90deg)"),
        default="0,0.3,0.6,0.9,1.1,1.3,1.4,1.5",
        help="Incident polar angles in radians, or with deg behind, such as 30deg.",
    ),
    "phi": dict(
        type=Angles(-math.inf, math.inf, "in radians", count=1),
        default="0",
        metavar="P",
        help="Incident azimuth, likewise.",
    ),
    "ior": dict(
        type=Real(
            lambda n: 0.01 <= n <= 100 and n != 1,
            "an index ratio: a number from 0.01 to 100 other than 1",
        ),
        default="1.5",
        metavar="N",
        help="Dielectric: index inside over index outside; 0.667 is glass seen from inside, as "
        "--theta beyond 90deg is of 1.5.",
    ),
    "metal": dict(
        type=click.Choice(tuple(METALS)),
        help="Conductor: Fresnel reflectance of this metal at 549 nm.",
    ),
    "eta-k": dict(
        type=Numbers(2), metavar="N,K", help="Conductor: Fresnel from the complex index N + iK."
    ),
    "albedo": dict(
        type=Real(lambda a: 0 <= a <= 1, "an albedo: a number from 0 to 1"),
        default="1",
        metavar="A",
        help="Diffuse facets.",
    ),
    "eta-k-channels": dict(
        type=Numbers(), metavar="N,K[,N,K...]", help="Conductor: complex index of each channel."
    ),
    "albedo-channels": dict(
        type=Numbers(low=0, high=1),
        default="1",
        metavar="A[,A...]",
        help="Diffuse facets, in each channel.",
    ),
    "rgb": dict(is_flag=True, help="With --metal: red, green and blue in one run."),
    "method": dict(type=Methods(), metavar="NAME[,NAME...]", help=f"Of {', '.join(METHODS)}."),
    "method-or-surfaces": dict(
        type=Methods(("surfaces",)),
        metavar="NAME[,NAME...]",
        help=f"Of {', '.join(METHODS)}; or surfaces, light traced on explicit ones.",
    ),
    "bidirectional": dict(
        is_flag=True, help="Position-free methods: sub-paths from both ends, all connections."
    ),
    "accuracy-of-solve": dict(
        type=Real(lambda a: 0 < a < 1, "an accuracy: a number between 0 and 1"),
        metavar="E",
        help="Wanted error of each order's energy by solve, which refines its nodes for it.",
    ),
    "phi-o": dict(
        type=Angles(-math.inf, math.inf, "in radians", count=1),
        metavar="P",
        help="Azimuth of the slice; default: the plane of incidence.",
    ),
    "points": dict(
        type=Count(2, most=100_000),
        default="91",
        metavar="N",
        help="Outgoing directions of the slice.",
    ),
    "orders": dict(
        type=click.IntRange(1, 10),
        default=4,
        metavar="K",
        help="Bounces reported one by one; the later ones are summed.",
    ),
    "accuracy": dict(
        type=Real(lambda a: 0 < a < 1, "an accuracy: a number between 0 and 1"),
        default="0.002",
        metavar="E",
        help="Wanted standard error of each order's energy; decides what is not given of these:",
    ),
    "cells": dict(
        type=Count(4, even=True, most=10_000),
        metavar="N",
        help="Mesh cells in 2 / alpha, the correlation length if that is gaussian; even.",
    ),
    "extent": dict(type=Count(4, most=10_000), metavar="N", help="Period, in 2 / alpha as well."),
    "realisations": dict(type=Count(2, most=1_000_000), metavar="N", help="Independent surfaces."),
    "autocorrelation": dict(
        type=Autocorrelation(),
        default="gaussian",
        help="Of the heights: gaussian, exponential, matern:NU or power-law:HURST.",
    ),
    "autocorrelations": dict(
        type=Autocorrelations(),
        default="gaussian",
        help="Of the heights: gaussian, exponential, matern:NU or power-law:HURST; of several, the "
        "one model is held against surfaces of each.",
    ),
    "heights-of": dict(
        type=HeightsOf(),
        default="gaussian",
        help="Distribution of the heights: gaussian, or of skewness S (1): ridges:S, pits:S.",
    ),
    "memory": dict(
        type=click.IntRange(0, 1),
        default=0,
        metavar="K",
        help="Facets that a walk remembers: 0 is the Smith model; 1: heights are those of a "
        "Gaussian surface of --autocorrelation, given the last facet.",
    ),
    "waves": dict(
        type=Count(most=1_000_000),
        metavar="N",
        help="Cosines summed to a surface; default: every wave of the period.",
    ),
    "convergence": dict(
        is_flag=True, help="Also measure what cells, period, waves and offset do to the energies."
    ),
    "save-mesh": dict(
        type=click.Path(dir_okay=False),
        metavar="FILE",
        help="Save the surface, or the first: .ply, .obj, .stl, .off or .glb.",
    ),
    "surface": dict(
        type=click.Path(exists=True, dir_okay=False),
        metavar="FILE",
        help="Heights of your own instead of random ones: an array, text, picture, mesh, or what "
        "an instrument wrote. For it are:",
    ),
    "step": dict(
        type=Lengths(),
        metavar="X[,Y]",
        help="Distance of its points, in metres or as 2um; where the file does not say.",
    ),
    "height-unit": dict(
        type=Lengths(1), metavar="X", help="What a height of 1, or a grey level, is, likewise."
    ),
    "periodic": dict(is_flag=True, help="It goes on at its sides; else its mirror images do."),
    "detrend": dict(
        type=click.IntRange(0, 8),
        default=1,
        metavar="N",
        help="Degree of the polynomial taken out of it; 1: a plane.",
    ),
    "filter": dict(
        type=Lengths(1), metavar="L", help="Smooth away what is shorter (ISO 16610, Gaussian)."
    ),
    "wavelength": dict(
        type=Lengths(1), metavar="L", help="Say where geometrical optics does not hold."
    ),
    "max-order": dict(
        type=Count(),
        default="10000",
        metavar="N",
        help="Facets after which light counts as unresolved.",
    ),
    "seed": dict(type=Count(0), default="0", help="Same seed, same options: the same numbers."),
    "threads": dict(
        # More than a few for each core only wait for each other, and take memory.
        type=Count(most=max(64, 4 * (os.cpu_count() or 1))),
        default=lambda: os.cpu_count() or 1,
        help="Processes.",
        show_default="all cores",
    ),
    "precision": dict(
        type=click.Choice(["float64", "float32"]), default="float64", help="Of the model."
    ),
    "free-path-theta": dict(
        type=Angles(0, math.pi, "from 0 to below pi"),
        default="0.5,1.0,1.4,2.0",
        help="Polar angles of travel for the free paths.",
    ),
    "free-path-height": dict(
        type=Numbers(),
        metavar="H[,H...]",
        help="Heights that free paths start from, inf for outside; default -2,-1,0,1,2,inf.",
    ),
    "out": dict(type=click.Path(file_okay=False), metavar="DIR", help="Where the report goes."),
    "force": dict(is_flag=True, help="Replace a report that is already there."),
    "quiet": dict(is_flag=True, help="No progress and no table."),
    "format": dict(
        type=click.Choice(["png", "svg", "pdf"]),
        default="png",
        help="What pictures are written as.",
    ),
    "json": dict(is_flag=True, help="The summary as one JSON object on standard output."),
}


VARIANTS = {
    "surface-slopes": "slopes",
    "slopes-or-surface": "slopes",
    "autocorrelations": "autocorrelation",
    "eta-k-channels": "eta-k",
    "albedo-channels": "albedo",
    "theta-furnace": "theta",
    "accuracy-of-solve": "accuracy",
    "method-or-surfaces": "method",
}
"""Options that some commands have in another form, by the name that the user types."""


def use(*names: str) -> Decorator:
    """Add the named options to a command, in this order."""

    def decorate(function: Callable[..., None]) -> Callable[..., None]:
        for name in reversed(names):
            settings = dict(_OPTIONS[name])
            settings.setdefault("show_default", settings.get("default") is not None)
            flag = VARIANTS.get(name, name)
            parameter = "as_json" if name == "json" else flag.replace("-", "_")
            function = click.option(f"--{flag}", parameter, **settings)(function)
        return function

    return decorate


MODEL = (
    "material",
    "slopes",
    "gamma",
    "heights",
    "alpha",
    "theta",
    "phi",
    "ior",
    "metal",
    "eta-k",
    "albedo",
)
MODEL_OF_SURFACES = ("material", "surface-slopes", *MODEL[4:])
MODEL_IN_COLOUR = (
    *(name for name in MODEL[:-2] if name != "heights"),
    "eta-k-channels",
    "albedo-channels",
    "rgb",
)
RESOLUTION = ("autocorrelation", "accuracy", "cells", "extent", "realisations", "waves")
OF_FILE = ("step", "height-unit", "periodic", "detrend", "filter")
FREE_PATH = ("free-path-theta", "free-path-height")
REPORT = ("out", "force", "format", "quiet", "json")


def samples(default: str | None) -> Decorator:
    """The option --samples with a command's own default; None: what the accuracy needs."""
    return click.option(
        "--samples",
        type=Count(),
        default=default,
        show_default=default or "1e6, or more where --accuracy needs them",
        help="Rays or walks for each incident angle.",
    )
