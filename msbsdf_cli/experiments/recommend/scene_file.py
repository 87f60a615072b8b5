"""Scenes as a small TOML file: the surfaces, what they are made of, how rough, and from where they
are seen."""

import math
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from msbsdf_cli.smith.slopes import Slopes, distribution, parameters
from surfaces.materials import NAMES, Material, material

ANGLES_DEG = (0.0, 30.0, 60.0, 80.0)
"""Angles that matter where the file does not say."""

TEXTURE_STEPS = 3
"""Roughnesses that stand for a range, evenly spaced in their logarithm."""

MOST_BYTES = 1_000_000
"""Of a scene's file."""

MOST_NUMBER = 1e100
"""Beyond it a number is as good as infinite."""

ROUGHNESS = {"alpha": 1, "perceptual": 2}
"""What a file may call roughness, by the power of it that is alpha."""

COMMON = ("name", "material", "slopes", "gamma", "alpha", "alpha_x", "alpha_y")
COMMON_TOO = ("angles_deg", "weight")


class SceneFileError(ValueError):
    """A scene that cannot be read; the text says where and why."""


@dataclass(frozen=True)
class SceneSurface:
    """A surface of a scene."""

    name: str
    material: Material
    slopes: tuple[Slopes, ...]
    """One for each roughness that is judged: several stand for a texture."""
    theta: tuple[float, ...]
    """Angles of incidence that matter, in radians."""
    weight: float = 1.0


@dataclass
class SceneFile:
    """What a file holds."""

    surfaces: list[SceneSurface]
    left_out: list[tuple[str, str]]
    """Name of what cannot be judged, and why."""


def read_scene(path: str | Path) -> SceneFile:
    """The surfaces of a file, TOML, or XML of Mitsuba where its name says so. Raises SceneFileError
    for what is no scene."""
    path = Path(path)
    if path.suffix.lower() == ".xml":
        from msbsdf_cli.experiments.recommend.mitsuba_scene import read_mitsuba

        return read_mitsuba(path)
    return SceneFile(_read_toml(path), [])


def _read_toml(path: Path) -> list[SceneSurface]:
    try:
        if path.stat().st_size > MOST_BYTES:
            raise SceneFileError(f"{path} is larger than {MOST_BYTES} bytes: no scene is.")
        content = tomllib.loads(path.read_text("utf-8"))
    except OSError as error:
        raise SceneFileError(f"{path} cannot be read: {error.strerror or error}.") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise SceneFileError(f"{path} is not TOML: {error}.") from None
    known = {"roughness", "surface"}
    for key in content.keys() - known:
        raise SceneFileError(f"{path}: {key!r} is not known: {', '.join(sorted(known))} are.")
    kind, surfaces = content.get("roughness", "alpha"), content.get("surface", [])
    if not isinstance(kind, str) or kind not in ROUGHNESS:
        raise SceneFileError(f"{path}: roughness is {kind!r}: one of {', '.join(ROUGHNESS)}.")
    if not isinstance(surfaces, list) or not surfaces:
        raise SceneFileError(f"{path} has no [[surface]].")
    found = []
    for number, entries in enumerate(surfaces, 1):
        where = f"{path}, surface {number}"
        if not isinstance(entries, dict):
            raise SceneFileError(f"{where} is no table.")
        try:
            found.append(_surface(entries, ROUGHNESS[kind]))
        except (ValueError, OverflowError) as error:
            raise SceneFileError(f"{where}: {error}") from None
    names = [surface.name for surface in found]
    for name in names:
        if names.count(name) > 1:
            raise SceneFileError(f"{path}: two surfaces are called {name!r}.")
    return found


def _surface(entries: dict[str, Any], power: int) -> SceneSurface:
    for key in ("name", "material"):
        if not isinstance(entries.get(key), str) or not entries[key].strip():
            raise ValueError(f"{key} is missing, or no text.")
    if entries["material"] not in NAMES:
        raise ValueError(f"{entries['material']!r} is not a material: one of {', '.join(NAMES)}.")
    kind = material(entries["material"])
    taken = {*COMMON, *COMMON_TOO, *kind.options} - {"rgb"}
    for key in entries.keys() - taken:
        raise ValueError(f"{key!r} is not known of {entries['material']}: {_listed(taken)} are.")
    angles = _numbers(entries.get("angles_deg", ANGLES_DEG), "angles_deg")
    for angle in angles:
        if not 0 <= angle < 90:
            raise ValueError(f"an angle is {angle:g} degrees: from 0 to below 90 are wanted.")
    weight = _number(entries.get("weight", 1.0), "weight")
    if not 0 < weight < math.inf:
        raise ValueError(f"weight is {weight:g}: a finite number above 0 is wanted.")
    slopes = _slopes(entries, power)
    theta = tuple(math.radians(angle) for angle in angles)
    return SceneSurface(entries["name"], _material(entries, kind), slopes, theta, weight)


def _material(entries: dict[str, Any], kind: type[Any]) -> Material:
    options: dict[str, Any] = {name: entries.get(name) for name in kind.options}
    metal = options.get("metal")
    if metal is not None and not isinstance(metal, str):
        raise ValueError(f"metal is {metal!r}: a name is wanted.")
    for name in ("eta_k", "albedo"):
        if options.get(name) is not None:
            options[name] = _numbers(options[name], name)
    if options.get("ior") is not None:
        options["ior"] = _number(options["ior"], "ior")
    if "rgb" in options:
        options["rgb"] = True
    else:
        # The material's own default stands for what is not given.
        options = {name: value for name, value in options.items() if value is not None}
    found: Material = kind.of(**options)
    return found


def _slopes(entries: dict[str, Any], power: int) -> tuple[Slopes, ...]:
    slopes = entries.get("slopes", "beckmann")
    kind, shape = distribution(slopes), {}
    for name in parameters(slopes):
        if name not in entries:
            raise ValueError(f"{name} is missing: slopes {slopes} have one.")
        shape[name] = _number(entries[name], name)
    if "gamma" in entries and "gamma" not in shape:
        raise ValueError("gamma is for slopes student-t.")
    if ("alpha" in entries) == ("alpha_x" in entries and "alpha_y" in entries):
        raise ValueError(
            "either alpha is wanted, a number or a range [LOW, HIGH], or alpha_x and alpha_y."
        )
    if "alpha" not in entries:
        pairs = [tuple(_number(entries[a], a) ** power for a in ("alpha_x", "alpha_y"))]
    else:
        ends = _numbers(entries["alpha"], "alpha")
        if len(ends) > 2 or min(ends) <= 0 or ends[0] > ends[-1]:
            raise ValueError("alpha is a number above 0, or a range [LOW, HIGH] of two.")
        steps = TEXTURE_STEPS if ends[0] < ends[-1] else 1
        pairs = [(a**power,) * 2 for a in np.geomspace(ends[0], ends[-1], steps).tolist()]
    return tuple(kind(*pair, **shape) for pair in pairs)


def _numbers(value: Any, name: str) -> tuple[float, ...]:
    values = value if isinstance(value, list | tuple) else [value]
    for number in values:
        if isinstance(number, bool) or not isinstance(number, int | float):
            raise ValueError(f"{name} is {value!r}: numbers are wanted.")
        if not -MOST_NUMBER < number < MOST_NUMBER:
            raise ValueError(f"{name} is too large or not finite: finite numbers are wanted.")
    if not values:
        raise ValueError(f"{name} is empty.")
    return tuple(float(number) for number in values)


def _number(value: Any, name: str) -> float:
    values = _numbers(value, name)
    if len(values) > 1:
        raise ValueError(f"{name} is {value!r}: one number is wanted.")
    return values[0]


def _listed(names: set[str]) -> str:
    return ", ".join(sorted(names))
