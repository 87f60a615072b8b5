"""A BSDF plugin of Mitsuba 3 as a rough surface, by Mitsuba's conventions: Beckmann slopes and a
roughness alpha of 0.1 where nothing else is said, glass of BK7 in air, conductors that mirror; of
`principled` what is one rough metal or one rough glass."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from msbsdf_cli.experiments.recommend.mitsuba_names import MEDIA, METALS
from msbsdf_cli.experiments.recommend.scene_surface import THETA, SceneSurface
from msbsdf_cli.smith.slopes import Slopes, distribution
from surfaces.facet import Array
from surfaces.materials import Conductor, Dielectric, Material

ALPHA = 0.1
"""Its roughness where a scene says nothing."""

ROUGHNESS = 0.5
LEAST_ALPHA = 1e-3
"""Of `principled`: the perceptual roughness where a scene says nothing, and the least alpha."""

BASE_COLOR = (0.5,)
SPECULAR = 0.5
"""Of `principled`, where a scene says nothing."""

SMOOTH = ("conductor", "dielectric", "thindielectric", "diffuse", "null")
"""Plugins of no roughness: single scattering is all there is."""


class LeftOutError(Exception):
    """A surface cannot be judged; the text says why."""


@dataclass(frozen=True)
class Schlick(Conductor):
    """A metal of `principled`: Schlick's approximation of Fresnel's law, from reflectances at
    normal incidence, 0 to 1, one for each channel. Raises ValueError for others."""

    f0: tuple[float, ...] = (1.0,)

    def __post_init__(self) -> None:
        if not all(0 <= f <= 1 for f in self.f0):
            raise ValueError("its base_color is not from 0 to 1.")

    @property
    def name(self) -> str:
        return "conductor"

    @property
    def absorbs(self) -> bool:
        return min(self.f0) < 1

    @property
    def channels(self) -> int:
        return len(self.f0)

    def reflectance(self, cos_i: Array, inside: bool = False) -> Array:
        absorbed = 1 - np.array(self.f0).reshape(-1, *[1] * cos_i.ndim)
        return np.asarray(1 - absorbed * (1 - (1 - np.minimum(cos_i, 1).astype(float)) ** 5))


class Entries:
    """What is said in a plugin, by name; `value` reads an attribute of an element."""

    def __init__(
        self, element: ElementTree.Element, value: Callable[[ElementTree.Element], str]
    ) -> None:
        self.named = {e.get("name", ""): e for e in element if e.get("name")}
        self.value = value

    def text(self, name: str, default: str) -> str:
        """A word."""
        return self.value(self.named[name]) if name in self.named else default

    def number(self, name: str, default: float) -> float:
        """A number that a scene gives as such, or as a constant spectrum."""
        if name not in self.named:
            return default
        element = self.named[name]
        if element.tag not in ("float", "integer", "spectrum"):
            raise LeftOutError(f"its {name} is a {element.tag}")
        text = self.value(element)
        try:
            return float(text)
        except ValueError:
            raise LeftOutError(f"its {name} is {text!r}, no number") from None

    def share(self, name: str, default: float = 0.0) -> float:
        """A number from 0 to 1."""
        number = self.number(name, default)
        if not 0 <= number <= 1:
            raise LeftOutError(f"its {name} is {number:g}, not from 0 to 1")
        return number

    def channels(self, name: str, default: tuple[float, ...]) -> tuple[float, ...]:
        """One number, or one for each of red, green and blue."""
        if name not in self.named:
            return default
        if self.named[name].tag != "rgb":
            return (self.number(name, 0.0),)
        try:
            values = tuple(map(float, self.text(name, "").replace(",", " ").split()))
        except ValueError:
            values = ()
        if len(values) not in (1, 3):
            raise LeftOutError(f"its {name} is no colour")
        return values

    def index(self, name: str, default: str) -> float:
        """An index of refraction: a number, or a medium by name."""
        if name in self.named and self.named[name].tag != "string":
            return self.number(name, 1.0)
        medium = self.text(name, default)
        if medium not in MEDIA:
            raise LeftOutError(f"its {name} is {medium!r}, no medium that is known here")
        return MEDIA[medium]


def surface(name: str, kind: str, entries: Entries) -> tuple[SceneSurface, list[str]]:
    """The surface of a plugin `kind`, and sentences on how it was read. Raises LeftOutError for
    what cannot be judged."""
    if kind in SMOOTH:
        raise LeftOutError(f"{kind} has no roughness: there is but one bounce")
    if kind not in MAKERS:
        raise LeftOutError(f"{kind} is no microfacet model that is known here")
    try:
        material, slopes, notes = MAKERS[kind](entries)
        return SceneSurface(name, material, (slopes,), THETA), notes
    except (ValueError, ZeroDivisionError) as error:
        raise LeftOutError(str(error).rstrip(".")) from None


Made = tuple[Material, Slopes, list[str]]


def _slopes(entries: Entries) -> Slopes:
    slopes = entries.text("distribution", "beckmann")
    if slopes not in ("beckmann", "ggx"):
        raise LeftOutError(f"its slopes are {slopes!r}")
    alpha = entries.number("alpha", ALPHA)
    return distribution(slopes)(*(entries.number(name, alpha) for name in ("alpha_u", "alpha_v")))


def _dielectric(entries: Entries) -> Made:
    inside, outside = entries.index("int_ior", "bk7"), entries.index("ext_ior", "air")
    return _interface(inside / outside), _slopes(entries), []


def _interface(ior: float) -> Material:
    if ior == 1:
        raise LeftOutError("it has one index inside and outside: there is nothing to see")
    return Dielectric(ior)


def _conductor(entries: Entries) -> Made:
    slopes = _slopes(entries)
    if "material" in entries.named:
        metal = entries.text("material", "")
        if metal not in ("none", *METALS):
            raise LeftOutError(f"its material is {metal!r}, no metal that is known here")
        return Conductor(METALS.get(metal, ())), slopes, []
    if not {"eta", "k"} & set(entries.named):
        return Conductor(), slopes, []
    parts = [entries.channels("eta", (0.0,)), entries.channels("k", (1.0,))]
    length = max(map(len, parts))
    pairs = zip(*(part * (length // len(part)) for part in parts), strict=True)
    return Conductor(tuple(pairs)), slopes, []


def _principled(entries: Entries) -> Made:
    if entries.share("clearcoat") > 0:
        raise LeftOutError("its clearcoat is a second lobe on top")
    alpha = entries.share("roughness", ROUGHNESS) ** 2
    aspect = math.sqrt(1 - 0.9 * entries.share("anisotropic"))
    pair = (max(a, LEAST_ALPHA) for a in (alpha / aspect, alpha * aspect))
    slopes = distribution("ggx")(*pair)
    parts = [entries.share(name) for name in ("metallic", "spec_trans")]
    if parts[0] == 1:
        return _principled_metal(entries), slopes, []
    if parts == [0, 1]:
        return _principled_glass(entries), slopes, _tint(entries)
    raise LeftOutError(
        f"it is principled with metallic {parts[0]:g} and spec_trans {parts[1]:g}, a mixture of "
        "lobes: only metallic 1 or spec_trans 1 is one rough surface"
    )


def _principled_metal(entries: Entries) -> Material:
    if entries.number("eta", 1.5) < 1:
        raise LeftOutError("it is a metal whose eta is below 1")
    f0 = entries.channels("base_color", BASE_COLOR)
    return Conductor() if min(f0) == 1 else Schlick(f0=f0)


def _principled_glass(entries: Entries) -> Material:
    for name in ("spec_tint", "sheen"):
        if entries.share(name) > 0:
            raise LeftOutError(f"its {name} is not of glass")
    if "eta" in entries.named:
        return _interface(entries.number("eta", 1.5))
    return _interface(2 / (1 - math.sqrt(0.08 * entries.share("specular", SPECULAR))) - 1)


def _tint(entries: Entries) -> list[str]:
    """What is left out of glass that is not clear."""
    if min(entries.channels("base_color", BASE_COLOR)) == 1:
        return []
    return ["is judged as clear glass: what its base_color takes on each way through is left out"]


MAKERS = {
    "roughconductor": _conductor,
    "roughdielectric": _dielectric,
    "principled": _principled,
}
