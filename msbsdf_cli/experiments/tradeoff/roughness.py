"""The same rows over roughness."""

from collections.abc import Callable
from dataclasses import replace

from msbsdf_cli.experiments.tradeoff.directions import lobe_directions
from msbsdf_cli.experiments.tradeoff.measuring import Protocol, measure
from msbsdf_cli.experiments.tradeoff.reference import reference
from msbsdf_cli.experiments.tradeoff.rows import Row, method_rows
from msbsdf_cli.experiments.tradeoff.scaling import SAMPLES, one_each
from msbsdf_cli.methods.registry import holds
from msbsdf_cli.scene import Scene

ALPHAS = (0.1, 0.2, 0.5, 1.0)
"""Larger of the two roughnesses; the scene's ratio of the two stays."""

REPLICATES = 8

DIRECTIONS = 64
"""At most: there are many lobes to measure."""

FEW = 16
"""Walks of the shortest run, below which no time is claimed."""


def roughness_rows(
    scene: Scene,
    methods: tuple[str, ...],
    thetas: tuple[float, ...],
    directions: int,
    protocol: Protocol,
    advance: Callable[[float], None] = lambda amount: None,
) -> list[Row]:
    """Rows as those of the chart, for all roughnesses and the angles given: walks at the least
    and at one usual number, and one resolution of `solve`."""
    usual = [s for s in one_each(methods) if s.method != "solve"]
    settings = [replace(s, samples=FEW) for s in usual if s.samples] + usual
    settings += [s for s in one_each(methods) if s.method == "solve"]
    directions = min(directions, DIRECTIONS)
    rows = []
    for alpha in ALPHAS:
        scale = alpha / max(scene.alpha)
        alphas = scale * scene.alpha[0], scale * scene.alpha[1]
        there = replace(scene.of_roughness(alphas), theta=thetas)
        lobes = [lobe_directions(there, theta, directions, protocol.seed) for theta in thetas]
        purpose = f"{protocol.purpose} {alpha}"
        truth = reference(there, lobes, methods, SAMPLES, protocol.seed, purpose)
        here = [s for s in settings if holds(s.method, there.slopes, there.material)]
        few = replace(protocol, replicates=min(protocol.replicates, REPLICATES), purpose=purpose)
        rows += method_rows(there, measure(there, here, lobes, few), truth)
        advance(1)
    return rows
