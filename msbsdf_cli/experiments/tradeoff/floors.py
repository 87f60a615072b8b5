"""Floors of the chart: what the reference leaves open, and what the Smith model does."""

from dataclasses import dataclass

import numpy as np

from msbsdf_cli.experiments.tradeoff.reference import Reference
from msbsdf_cli.experiments.tradeoff.rows import Row
from msbsdf_cli.experiments.tradeoff.surface_reference import Distance, SurfaceReference, own_noise
from msbsdf_cli.scene import Scene

MARGIN = 3
"""A reference is to be so many times better than the best that it judges; otherwise it is said."""


@dataclass(frozen=True)
class Floor:
    """A relative error below which something cannot be told."""

    theta_i_rad: float
    floor: str
    """`reference` or `surfaces` for the noise of these, `model` for a model's distance from the
    surfaces."""
    model: str
    relative_rmse: float
    stderr: float


def floors(
    scene: Scene, truth: Reference, surfaces: SurfaceReference | None, found: list[Distance]
) -> list[Floor]:
    """All floors, angle by angle."""
    rows = []
    for i, theta in enumerate(scene.theta):
        rows.append(Floor(theta, "reference", "smith", truth.noise[i], 0.0))
        if surfaces is not None:
            rows.append(Floor(theta, "surfaces", "surfaces", *own_noise(surfaces, i)))
        rows += [
            Floor(theta, "model", d.model, d.value, d.stderr) for d in found if d.theta == theta
        ]
    return rows


def margin(rows: list[Row], truth: Reference, theta: tuple[float, ...]) -> float:
    """Least ratio, over angles, of the smallest error that is judged to that of the reference."""
    ratios = [
        np.nanmin([r.relative_rmse for r in rows if r.theta_i_rad == t and r.reference == "smith"])
        / max(noise, 1e-300)
        for t, noise in zip(theta, truth.noise, strict=True)
    ]
    return float(min(ratios))
