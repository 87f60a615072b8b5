"""The whole study: reference, methods, surfaces, and what is written of them."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from msbsdf_cli.cli.terminal import measured
from msbsdf_cli.experiments.resolution import plan
from msbsdf_cli.experiments.tradeoff import floors as flooring
from msbsdf_cli.experiments.tradeoff import reach as reaching
from msbsdf_cli.experiments.tradeoff import rows as tabulating
from msbsdf_cli.experiments.tradeoff.claims import figure_17, two_samples
from msbsdf_cli.experiments.tradeoff.directions import Lobe, lobe_directions
from msbsdf_cli.experiments.tradeoff.measuring import Protocol, Series, ladder, measure
from msbsdf_cli.experiments.tradeoff.reference import Reference, references
from msbsdf_cli.experiments.tradeoff.roughness import ALPHAS, roughness_rows
from msbsdf_cli.experiments.tradeoff.scaling import (
    REPEATS,
    Scaling,
    of_rows,
    one_each,
    over_orders,
    over_threads,
)
from msbsdf_cli.experiments.tradeoff.scaling import table as scaling_table
from msbsdf_cli.experiments.tradeoff.world import World, distances, trace_world
from msbsdf_cli.results.directory import Table
from msbsdf_cli.run.executors import Progress
from msbsdf_cli.scene import Scene

PAIRS = 8
"""Outgoing directions that are asked for one at a time."""
PAIR_REPLICATES = 8

SURFACES = 64
"""Realisations, unless the accuracy wants more: a distance of .03 is known to about .004 then."""


@dataclass
class Result:
    """What the study found."""

    scene: Scene
    series: list[Series]
    truth: Reference
    rows: list[tabulating.Row]
    floors: list[flooring.Floor]
    margin: float
    warnings: list[str] = field(default_factory=list)
    pairs: list[tabulating.Row] = field(default_factory=list)
    scaling: list[Scaling] = field(default_factory=list)
    claims: dict[str, Table] = field(default_factory=dict)

    def tables(self) -> dict[str, Table]:
        """All tables by file name."""
        tables = {
            "tradeoff.csv": tabulating.table(self.rows),
            "floors.csv": flooring.table(self.floors),
            "reach.csv": reaching.table(reaching.reach(self.rows)),
            "pairs.csv": tabulating.table(self.pairs),
            "scaling.csv": scaling_table(self.scaling),
        }
        return tables | self.claims

    def draw(self, draft: Path) -> None:
        """All pictures."""
        from msbsdf_cli.plots.figure_17 import draw_figure_17
        from msbsdf_cli.plots.scaling import draw_scaling
        from msbsdf_cli.plots.tradeoff import draw_tradeoff

        draw_tradeoff(self.rows, self.floors, draft / "tradeoff.png")
        draw_scaling(self.scaling, draft / "scaling.png")
        if self.claims:
            draw_figure_17(self.claims["figure_17.csv"], draft / "figure_17.png")

    def record(self) -> dict[str, Any]:
        """What run.json says of it."""
        return {
            "reference": {
                "method": self.truth.method,
                "resolution": self.truth.resolution,
                "relative_noise": self.truth.noise,
                "margin": self.margin,
                "seconds": self.truth.seconds,
            },
            "summary": "\n".join(self.sentences()),
        }

    def sentences(self) -> list[str]:
        """What the chart says at a glance, in words."""
        found = reaching.reach(self.rows)
        said = reaching.sentences(found) + reaching.tenfold(found)
        smith = [f for f in self.floors if (f.floor, f.model) == ("model", "smith")]
        if smith:
            apart = ", ".join(
                f"{measured(f.relative_rmse, f.stderr)} at theta {f.theta_i_rad:.4g}" for f in smith
            )
            said.append(
                f"Distance of the Smith model from explicit surfaces: {apart}. A smaller error "
                "against the model is wasted there."
            )
        return said + (two_samples(self.claims["figure_17.csv"]) if self.claims else [])


def run(scene: Scene, options: dict[str, Any]) -> Result:
    """Measure, from the options of the command."""
    seed, threads, quiet = options["seed"], options["threads"], options["quiet"]
    lobes = [lobe_directions(scene, theta, options["directions"], seed) for theta in scene.theta]
    pairs = [lobe_directions(scene, theta, PAIRS, seed) for theta in scene.theta]
    truth, pair_truth = references(scene, lobes, pairs, options["samples"], seed)
    settings = ladder(options["method"], options["samples"])
    protocol = Protocol(options["replicates"], seed, options["qmc"])
    with Progress("methods", options["replicates"] + 1, "rounds", quiet) as progress:
        series = measure(scene, settings, lobes, protocol, progress.advance)
    rows = tabulating.method_rows(scene, series, truth)
    world, found = None, []
    if options["surfaces"] and scene.slopes.name == "beckmann":
        world = surfaces_for(scene, options)
        found = distances(scene, options["method"], world, seed, threads)
        rows += tabulating.simulate_rows(scene, world)
        rows = tabulating.with_distances(rows, found)
    result = Result(
        scene,
        series,
        truth,
        rows,
        flooring.floors(scene, truth, world, found),
        flooring.margin(rows, truth, scene.theta),
    )
    result.pairs = pair_rows(scene, pairs, pair_truth, options)
    result.scaling = scale(result, options, lobes[len(lobes) // 2])
    if options["claims"]:
        result.claims = {"figure_17.csv": figure_17(scene, seed)}
    result.warnings = warnings_of(result, options)
    return result


def pair_rows(
    scene: Scene, lobes: list[Lobe], truth: Reference, options: dict[str, Any]
) -> list[tabulating.Row]:
    """Rows of a renderer's case: one pair of directions at a time."""
    settings = [
        replace(s, one_by_one=True) for s in one_each(options["method"], options["samples"])
    ]
    few = min(options["replicates"], PAIR_REPLICATES)
    protocol = Protocol(few, options["seed"], options["qmc"], "pairs")
    with Progress("pairs", protocol.replicates + 1, "rounds", options["quiet"]) as progress:
        series = measure(scene, settings, lobes, protocol, progress.advance)
    return tabulating.method_rows(scene, series, truth)


def scale(result: Result, options: dict[str, Any], lobe: Lobe) -> list[Scaling]:
    """Time over samples, orders, processes and roughness, at the angle of `lobe`."""
    methods, seed = options["method"], options["seed"]
    dearest = [s for s in one_each(methods, options["samples"]) if s.samples]
    rough = over_roughness(result.scene, options, (lobe.theta,), "roughness")
    return [
        *of_rows("samples", result.rows),
        *over_orders(result.scene, methods, lobe, Protocol(REPEATS, seed, options["qmc"])),
        *over_threads(result.scene, dearest, lobe, options["threads"], seed),
        *of_rows("roughness", rough),
    ]


def over_roughness(
    scene: Scene, options: dict[str, Any], thetas: tuple[float, ...], label: str
) -> list[tabulating.Row]:
    """Rows over roughness and these angles."""
    protocol = Protocol(options["replicates"], options["seed"], options["qmc"], label)
    with Progress(label, len(ALPHAS), "roughnesses", options["quiet"]) as progress:
        return roughness_rows(
            scene, options["method"], thetas, options["directions"], protocol, progress.advance
        )


def surfaces_for(scene: Scene, options: dict[str, Any]) -> World:
    """Surfaces of the wanted accuracy, traced."""
    names = ("accuracy", "cells", "extent", "realisations", "waves")
    resolution = plan(scene, *(options[name] for name in names))
    if options["realisations"] is None:
        # Lobes scatter more between surfaces than energies do, and a surface is cheap.
        resolution = replace(resolution, realisations=max(resolution.realisations, SURFACES))
    return trace_world(
        scene, resolution, options["rays"], options["seed"], options["threads"], options["quiet"]
    )


def warnings_of(result: Result, options: dict[str, Any]) -> list[str]:
    """Sentences on what limits the result."""
    warnings = []
    if result.margin < flooring.MARGIN:
        warnings.append(
            f"the reference, {result.truth.method}, is only {result.margin:.2g} times better than "
            "the best setting it judges: the smallest errors are upper bounds."
        )
    if options["surfaces"] and result.scene.slopes.name != "beckmann":
        warnings.append(
            "there are no explicit surfaces of GGX slopes: the distance of the model from the "
            "world is not drawn."
        )
    return warnings
