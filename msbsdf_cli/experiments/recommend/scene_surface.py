"""The surfaces of a scene, whatever it was read from."""

import math
from dataclasses import dataclass, field

from msbsdf_cli.smith.slopes import Slopes
from surfaces.materials import Material

THETA = tuple(map(math.radians, (0.0, 30.0, 60.0, 80.0)))
"""Angles of incidence that stand for all where the file does not say which matter."""

MOST_BYTES = 1_000_000
"""Of a scene's file."""


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

    surfaces: list[SceneSurface] = field(default_factory=list)
    left_out: list[tuple[str, str]] = field(default_factory=list)
    """Name of what cannot be judged, and why."""
    notes: list[str] = field(default_factory=list)
    """Sentences on what was read as something a little different."""
    tolerance: float | None = None
    """What the file asks for."""
