"""Scenes as a small TOML file: the surfaces, what they are made of, how rough, and from where they
are seen."""

import math
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from msbsdf_cli.experiments.recommend.scene_surface import (
    MOST_BYTES,
    THETA,
    SceneFile,
    SceneFileError,
    SceneSurface,
)
from msbsdf_cli.smith.slopes import Slopes, distribution, parameters
from surfaces.materials import NAMES, Material, material

TEXTURE_STEPS = 3
"""Roughnesses that stand for a range, evenly spaced in their logarithm."""

MOST_NUMBER = 1e100
"""Beyond it a number is as good as infinite."""

ROUGHNESS = {"alpha": 1, "perceptual": 2}
"""What a file may call roughness, by the power of it that is alpha."""

COMMON = ("name", "material", "slopes", "gamma", "alpha", "alpha_x", "alpha_y")
COMMON_TOO = ("theta", "weight")


def read_toml(path: Path) -> SceneFile:
    """The surfaces of a file. Raises SceneFileError for what is no scene."""
    try:
        if path.stat().st_size > MOST_BYTES:
            raise SceneFileError(f"{path} is larger than {MOST_BYTES} bytes: no scene is.")
        content = tomllib.loads(path.read_text("utf-8"))
    except OSError as error:
        raise SceneFileError(f"{path} cannot be read: {error.strerror or error}.") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise SceneFileError(f"{path} is not TOML: {error}.") from None
    known = {"roughness", "surface", "tolerance"}
    for key in content.keys() - known:
        raise SceneFileError(f"{path}: {key!r} is not known: {', '.join(sorted(known))} are.")
    kind, surfaces = content.get("roughness", "alpha"), content.get("surface", [])
    if not isinstance(kind, str) or kind not in ROUGHNESS:
        raise SceneFileError(f"{path}: roughness is {kind!r}: one of {', '.join(ROUGHNESS)}.")
    if not isinstance(surfaces, list) or not surfaces:
        raise SceneFileError(f"{path} has no [[surface]].")
    found = SceneFile(tolerance=_tolerance(path, content))
    for number, entries in enumerate(surfaces, 1):
        where = f"{path}, surface {number}"
        if not isinstance(entries, dict):
            raise SceneFileError(f"{where} is no table.")
        try:
            found.surfaces.append(surface_of(entries, ROUGHNESS[kind]))
        except (ValueError, OverflowError) as error:
            raise SceneFileError(f"{where}: {error}") from None
    names = [surface.name for surface in found.surfaces]
    for name in names:
        if names.count(name) > 1:
            raise SceneFileError(f"{path}: two surfaces are called {name!r}.")
    return found


def _tolerance(path: Path, content: dict[str, Any]) -> float | None:
    if "tolerance" not in content:
        return None
    try:
        tolerance = _number(content["tolerance"], "tolerance")
    except ValueError as error:
        raise SceneFileError(f"{path}: {error}") from None
    if not 0 < tolerance < 1:
        raise SceneFileError(f"{path}: tolerance is {tolerance:g}: above 0 and below 1 is wanted.")
    return tolerance


def surface_of(entries: dict[str, Any], power: int = 1) -> SceneSurface:
    """The surface of a table of a file, alpha being the `power` of what is given. Raises ValueError
    for what is none."""
    for key in ("name", "material"):
        if not isinstance(entries.get(key), str) or not entries[key].strip():
            raise ValueError(f"{key} is missing, or no text.")
    if entries["material"] not in NAMES:
        raise ValueError(f"{entries['material']!r} is not a material: one of {', '.join(NAMES)}.")
    kind = material(entries["material"])
    taken = {*COMMON, *COMMON_TOO, *kind.options} - {"rgb"}
    for key in entries.keys() - taken:
        raise ValueError(f"{key!r} is not known of {entries['material']}: {_listed(taken)} are.")
    theta = _angles(entries["theta"]) if "theta" in entries else THETA
    weight = _number(entries.get("weight", 1.0), "weight")
    if not 0 < weight < math.inf:
        raise ValueError(f"weight is {weight:g}: a finite number above 0 is wanted.")
    slopes = _slopes(entries, power)
    return SceneSurface(entries["name"], _material(entries, kind), slopes, theta, weight)


def _angles(value: Any) -> tuple[float, ...]:
    """Angles in radians, from numbers, and texts such as "60deg"."""
    found = []
    for angle in value if isinstance(value, list) else [value]:
        text = re.fullmatch(r"\s*([-+.e\d]+)\s*deg\s*", angle) if isinstance(angle, str) else None
        try:
            radians = math.radians(float(text[1])) if text else _number(angle, "theta")
        except ValueError:
            wanted = 'radians, or a text such as "60deg", are wanted'
            raise ValueError(f"theta has {angle!r}: {wanted}.") from None
        if not 0 <= radians < math.pi / 2:
            raise ValueError(f"theta has {angle!r}: from 0 to below 90 degrees is wanted.")
        found.append(radians)
    if not found:
        raise ValueError("theta is empty.")
    return tuple(found)


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
