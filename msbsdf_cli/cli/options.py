"""The options of all commands: types, defaults and words, each in one place."""

import math
import os
from collections.abc import Callable
from typing import Any

import click

from msbsdf_cli.cli.types import (
    Angles,
    Autocorrelation,
    Autocorrelations,
    Count,
    HeightsOf,
    Lengths,
    Methods,
    Numbers,
    Real,
    Roughness,
)
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.smith.slopes import NAMES as SLOPES
from msbsdf_cli.smith.slopes import OF_SURFACE
from surfaces.materials import NAMES as MATERIALS
from surfaces.materials._metals import METALS

Decorator = Callable[[Callable[..., None]], Callable[..., None]]


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
    "remembered": dict(
        type=Autocorrelation(),
        default="gaussian",
        help="Of the heights that walk-memory remembers: gaussian, exponential, matern:NU or "
        "power-law:HURST.",
    ),
    "heights-of": dict(
        type=HeightsOf(),
        default="gaussian",
        help="Distribution of the heights: gaussian, or of skewness S (1): ridges:S, pits:S.",
    ),
    "memory": dict(
        type=click.IntRange(0, 2),
        default=0,
        metavar="K",
        help="What a walk remembers of a Gaussian surface of --autocorrelation: 0: nothing, the "
        "Smith model; 1: the last facet; 2: also the heights passed since, 4 times slower.",
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
    "remembered": "autocorrelation",
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
