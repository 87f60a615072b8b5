"""A scene: a rough surface and the light that comes in."""

import math
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from msbsdf_cli.smith.slopes import Slopes, distribution, parameters
from surfaces.facet import Array
from surfaces.materials import Material, material


@dataclass(frozen=True)
class Scene:
    """What two runs must share to be compared."""

    material: Material
    slopes: Slopes
    theta: tuple[float, ...]
    """Incident polar angles in radians; beyond pi/2 light comes from inside, and `material` is that
    of the surface turned over."""
    phi: float = 0.0
    """Incident azimuth in radians."""
    orders: int = 4

    @property
    def alpha(self) -> tuple[float, float]:
        """Roughness along x and y."""
        return self.slopes.alpha

    def of_roughness(self, alpha: tuple[float, float]) -> "Scene":
        """The same scene, smoother or rougher."""
        return replace(self, slopes=replace(self.slopes, alpha_x=alpha[0], alpha_y=alpha[1]))

    def settings(self) -> dict[str, Any]:
        """All of it, in words and numbers that JSON can hold."""
        parts = {"material": _settings(self.material), "slopes": _settings(self.slopes)}
        return parts | {"theta": self.theta, "phi": self.phi, "orders": self.orders}

    @classmethod
    def of(cls, settings: dict[str, Any]) -> "Scene":
        """The scene of `settings`. Raises ValueError, KeyError or TypeError for what is none."""
        slopes, facets = (dict(settings[name]) for name in ("slopes", "material"))
        return cls(
            material(facets.pop("name"))(**{k: _tuples(v) for k, v in facets.items()}),
            distribution(slopes.pop("name"))(**{k: _tuples(v) for k, v in slopes.items()}),
            _tuples(settings["theta"]),
            settings["phi"],
            settings["orders"],
        )

    def wi(self, theta: float, dtype: type = np.float64) -> Array:
        """The incident direction (3,) of polar angle `theta`, from the side that light is on."""
        return direction(from_normal(theta), self.phi).astype(dtype)

    def slug(self) -> str:
        """The scene as a file name."""
        name = self.slopes.name
        shape = (getattr(self.slopes, parameter) for parameter in parameters(name))
        alpha = dict.fromkeys(self.alpha)
        words = [self.material.name, name, *(f"{x:g}" for x in (*shape, *alpha))]
        return "-".join(words)


def _settings(part: Any) -> dict[str, Any]:
    return {"name": part.name} | {f.name: getattr(part, f.name) for f in fields(part)}


def _tuples(value: Any) -> Any:
    return tuple(map(_tuples, value)) if isinstance(value, list) else value


def direction(theta: float, phi: float = 0.0) -> Array:
    """Unit vector (3,) of polar angle and azimuth in radians. Raises ValueError for what is not
    finite."""
    if not math.isfinite(theta + phi):
        raise ValueError(f"the angles are {theta} and {phi}: finite numbers are wanted.")
    return np.array(
        [math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)]
    )


def from_normal(theta: float) -> float:
    """The angle to the normal of the side that light comes from, for polar angles up to pi."""
    return min(theta, math.pi - theta)


def in_degrees(angle: float) -> str:
    """An angle in radians as a person reads it: to four digits, or as many as tell it from the
    horizon."""
    degrees = math.degrees(angle)
    texts = (f"{degrees:.{digits}g}" for digits in range(4, 18))
    return f"{next(t for t in texts if float(t) != 90 or angle == math.pi / 2)}°"
