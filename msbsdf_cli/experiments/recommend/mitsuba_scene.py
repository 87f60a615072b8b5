"""The rough surfaces of a Mitsuba 3 scene in XML, by Mitsuba's conventions: Beckmann slopes and a
roughness alpha of 0.1 where nothing else is said, glass of BK7 in air, conductors that mirror."""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from msbsdf_cli.experiments.recommend.scene_file import (
    ANGLES_DEG,
    MOST_BYTES,
    SceneFile,
    SceneFileError,
    SceneSurface,
)
from msbsdf_cli.smith.slopes import distribution
from surfaces.materials import Conductor, Dielectric, Material

MEDIA = {
    "vacuum": 1.0,
    "helium": 1.000036,
    "hydrogen": 1.000132,
    "air": 1.000277,
    "carbon dioxide": 1.00045,
    "water": 1.333,
    "acetone": 1.36,
    "ethanol": 1.361,
    "carbon tetrachloride": 1.461,
    "glycerol": 1.4729,
    "benzene": 1.501,
    "silicone oil": 1.52045,
    "bromine": 1.661,
    "water ice": 1.31,
    "fused quartz": 1.458,
    "pyrex": 1.47,
    "acrylic glass": 1.49,
    "polypropylene": 1.49,
    "bk7": 1.5046,
    "sodium chloride": 1.544,
    "amber": 1.55,
    "pet": 1.575,
    "diamond": 2.419,
}
"""Indices of refraction by the names that Mitsuba 3 knows."""

METALS: dict[str, tuple[tuple[float, float], ...]] = {
    "Ag": ((0.1553, 4.828), (0.1167, 3.122), (0.1384, 2.147)),
    "Al": ((1.658, 9.224), (0.8804, 6.27), (0.5212, 4.837)),
    "Au": ((0.143, 3.983), (0.3753, 2.386), (1.442, 1.603)),
    "Be": ((4.185, 3.835), (3.185, 3.01), (2.784, 2.869)),
    "Cr": ((4.37, 5.207), (2.917, 4.231), (1.655, 3.755)),
    "Cu": ((0.201, 3.913), (0.9237, 2.453), (1.102, 2.142)),
    "Hg": ((2.399, 6.328), (1.44, 4.372), (0.9096, 3.422)),
    "Ir": ((3.086, 5.592), (2.082, 4.067), (1.618, 3.267)),
    "K": ((0.06404, 2.104), (0.04641, 1.349), (0.03818, 0.9131)),
    "Li": ((0.2658, 3.54), (0.1956, 2.311), (0.2209, 1.669)),
    "Mo": ((4.484, 4.111), (3.525, 3.421), (2.776, 3.151)),
    "Na_palik": ((0.06027, 3.179), (0.05614, 2.112), (0.06199, 1.579)),
    "Nb": ((3.42, 3.441), (2.79, 2.738), (2.396, 2.58)),
    "Ni_palik": ((2.367, 4.499), (1.663, 3.05), (1.467, 2.345)),
    "Rh": ((2.586, 6.782), (1.86, 4.703), (1.554, 3.976)),
    "Ta": ((2.063, 2.408), (2.393, 1.741), (2.628, 1.947)),
    "TiC": ((3.701, 3.266), (2.837, 2.352), (2.582, 2.173)),
    "TiN": ((1.648, 3.368), (1.151, 1.943), (1.38, 1.102)),
    "V_palik": ((4.278, 3.491), (3.513, 2.889), (2.761, 3.112)),
    "VC": ((3.658, 3.068), (2.753, 2.199), (2.533, 1.963)),
    "VN": ((2.866, 3.032), (2.119, 2.056), (1.94, 1.616)),
    "W": ((4.371, 3.501), (3.3, 2.605), (2.998, 2.273)),
}
"""Complex indices n + i k of its metals, in the red, green and blue that Mitsuba 3.9 makes of their
spectra."""

ALPHA = 0.1
"""Its roughness where a scene says nothing."""

AROUND = ("twosided", "mask", "bumpmap", "normalmap")
"""Plugins that wrap another surface, whose roughness they leave as it is."""

SMOOTH = ("conductor", "dielectric", "thindielectric", "diffuse", "null")
"""Plugins of no roughness: single scattering is all there is."""

MOST_FILES = 64
"""Files that a scene may include."""


class _LeftOutError(Exception):
    """A surface cannot be judged; the text says why."""


@dataclass
class _Reader:
    """Files read so far, and the values of variables."""

    root: Path
    files: int = 0
    variables: dict[str, str] = field(default_factory=dict)

    def elements(self, path: Path) -> Iterator[ElementTree.Element]:
        """Elements of the scene in a file, those of included files in their place."""
        self.files += 1
        if self.files > MOST_FILES:
            raise SceneFileError(f"{path}: more than {MOST_FILES} files are included.")
        for element in _parsed(path):
            if element.tag == "default":
                self.variables.setdefault(element.get("name", ""), element.get("value", ""))
            elif element.tag == "include":
                wanted = (path.parent / self.value(element, "filename")).resolve()
                if not wanted.is_relative_to(self.root):
                    raise SceneFileError(f"{path}: {wanted.name} lies outside of {self.root}.")
                yield from self.elements(wanted)
            else:
                yield element

    def value(self, element: ElementTree.Element, name: str = "value") -> str:
        """An attribute, with the values of variables put in."""

        def known(match: re.Match[str]) -> str:
            if match[1] not in self.variables:
                raise SceneFileError(f"${match[1]} has no value and no default.")
            return self.variables[match[1]]

        return re.sub(r"\$(\w+)", known, element.get(name, ""))


def read_mitsuba(path: str | Path) -> SceneFile:
    """The rough surfaces of a scene, and what cannot be judged. Raises SceneFileError for what is
    no scene."""
    path = Path(path)
    reader = _Reader(path.resolve().parent)
    named: dict[str, ElementTree.Element] = {}
    used: list[tuple[str, ElementTree.Element]] = []
    for element in reader.elements(path):
        if element.tag == "bsdf":
            name = reader.value(element, "id") or f"surface {len(used) + 1}"
            named[name] = element
            used.append((name, element))
        for shape in element.iter("shape") if element.tag == "shape" else ():
            for inner in shape.iterfind("bsdf"):
                used.append((reader.value(shape, "id") or f"shape {len(used) + 1}", inner))
    scene = SceneFile([], [])
    for name, element in used:
        try:
            scene.surfaces.append(_surface(reader, name, _unwrapped(reader, element, named)))
        except _LeftOutError as reason:
            scene.left_out.append((name, str(reason)))
    if not used:
        raise SceneFileError(f"{path} has no bsdf.")
    return scene


def _parsed(path: Path) -> ElementTree.Element:
    try:
        if path.stat().st_size > MOST_BYTES:
            raise SceneFileError(f"{path} is larger than {MOST_BYTES} bytes.")
        text = path.read_text("utf-8")
        # What entities could be made to do, no scene needs.
        if re.search(r"<!\s*(DOCTYPE|ENTITY)", text, re.IGNORECASE):
            raise SceneFileError(f"{path} declares a document type: no scene needs one.")
        root = ElementTree.fromstring(text)
    except OSError as error:
        raise SceneFileError(f"{path} cannot be read: {error.strerror or error}.") from None
    except (ElementTree.ParseError, UnicodeDecodeError, RecursionError) as error:
        raise SceneFileError(f"{path} is not XML: {error}.") from None
    if root.tag != "scene":
        raise SceneFileError(f"{path} is no Mitsuba scene: it starts with <{root.tag[:40]}>.")
    return root


def _unwrapped(
    reader: _Reader, element: ElementTree.Element, named: dict[str, ElementTree.Element]
) -> ElementTree.Element:
    """The surface inside of others that leave its roughness alone."""
    seen: set[int] = set()
    while reader.value(element, "type") in AROUND:
        if id(element) in seen:
            raise _LeftOutError("it refers to itself")
        seen.add(id(element))
        kind, inside = reader.value(element, "type"), list(element.iterfind("bsdf"))
        inside += [
            named[name]
            for ref in element.iterfind("ref")
            if (name := reader.value(ref, "id")) in named
        ]
        if not inside:
            raise _LeftOutError(f"its {kind} holds no surface that is known here")
        element = inside[0]
    return element


def _surface(reader: _Reader, name: str, element: ElementTree.Element) -> SceneSurface:
    kind = reader.value(element, "type")
    makers = {"roughconductor": _conductor, "roughdielectric": _dielectric}
    if kind in SMOOTH:
        raise _LeftOutError(f"{kind} has no roughness: there is but one bounce")
    if kind not in makers:
        raise _LeftOutError(f"{kind} is no microfacet model that is known here")
    entries = {e.get("name", ""): e for e in element if e.get("name")}
    material = makers[kind](reader, entries)
    slopes = reader.value(entries["distribution"]) if "distribution" in entries else "beckmann"
    if slopes not in ("beckmann", "ggx"):
        raise _LeftOutError(f"its slopes are {slopes!r}")
    alpha = _number(reader, entries, "alpha", ALPHA)
    pair = (_number(reader, entries, name, alpha) for name in ("alpha_u", "alpha_v"))
    theta = tuple(math.radians(angle) for angle in ANGLES_DEG)
    try:
        return SceneSurface(name, material, (distribution(slopes)(*pair),), theta)
    except ValueError as error:
        raise _LeftOutError(str(error).rstrip(".")) from None


def _number(reader: _Reader, entries: dict[str, Any], name: str, default: float) -> float:
    """A number that a scene gives as such, or as a constant spectrum."""
    if name not in entries:
        return default
    element = entries[name]
    if element.tag not in ("float", "integer", "spectrum"):
        raise _LeftOutError(f"its {name} is a {element.tag}")
    text = reader.value(element)
    try:
        return float(text)
    except ValueError:
        raise _LeftOutError(f"its {name} is {text!r}, no number") from None


def _index(reader: _Reader, entries: dict[str, Any], name: str, default: str) -> float:
    if name in entries and entries[name].tag != "string":
        return _number(reader, entries, name, 1.0)
    medium = reader.value(entries[name]) if name in entries else default
    if medium not in MEDIA:
        raise _LeftOutError(f"its {name} is {medium!r}, no medium that is known here")
    return MEDIA[medium]


def _dielectric(reader: _Reader, entries: dict[str, Any]) -> Material:
    inside = _index(reader, entries, "int_ior", "bk7")
    outside = _index(reader, entries, "ext_ior", "air")
    try:
        return Dielectric(inside / outside)
    except (ValueError, ZeroDivisionError) as error:
        raise _LeftOutError(str(error).rstrip(".")) from None


def _conductor(reader: _Reader, entries: dict[str, Any]) -> Material:
    if "material" in entries:
        metal = reader.value(entries["material"])
        if metal == "none":
            return Conductor()
        if metal not in METALS:
            raise _LeftOutError(f"its material is {metal!r}, no metal that is known here")
        return Conductor(METALS[metal])
    if "eta" not in entries and "k" not in entries:
        return Conductor()
    parts = [_channels(reader, entries, name) for name in ("eta", "k")]
    length = max(map(len, parts))
    pairs = zip(*(part * (length // len(part)) for part in parts), strict=True)
    try:
        return Conductor(tuple(pairs))
    except ValueError as error:
        raise _LeftOutError(str(error).rstrip(".")) from None


def _channels(reader: _Reader, entries: dict[str, Any], name: str) -> tuple[float, ...]:
    """One number, or one for each of red, green and blue."""
    if name in entries and entries[name].tag == "rgb":
        try:
            values = tuple(map(float, reader.value(entries[name]).replace(",", " ").split()))
        except ValueError:
            values = ()
        if len(values) not in (1, 3):
            raise _LeftOutError(f"its {name} is no colour")
        return values
    return (_number(reader, entries, name, 0.0 if name == "eta" else 1.0),)
