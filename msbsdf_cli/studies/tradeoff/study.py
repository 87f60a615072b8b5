"""The whole study: reference, methods, surfaces, and what is written of them."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from msbsdf_cli.parallel import Progress
from msbsdf_cli.report.directory import Table
from msbsdf_cli.scene import Scene
from msbsdf_cli.studies.plan import plan
from msbsdf_cli.studies.tradeoff import floors as flooring
from msbsdf_cli.studies.tradeoff import rows as tabulating
from msbsdf_cli.studies.tradeoff.directions import lobe_directions
from msbsdf_cli.studies.tradeoff.measuring import Protocol, Series, ladder, measure
from msbsdf_cli.studies.tradeoff.reference import Reference, reference
from msbsdf_cli.studies.tradeoff.world import World, distances, trace_world


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
    tables_besides: dict[str, Table] = field(default_factory=dict)

    def tables(self) -> dict[str, Table]:
        """All tables by file name."""
        return {
            "tradeoff.csv": tabulating.table(self.rows),
            "floors.csv": flooring.table(self.floors),
            **self.tables_besides,
        }

    def draw(self, draft: Path) -> None:
        """All pictures."""
        from msbsdf_cli.report.tradeoff import draw_tradeoff

        draw_tradeoff(self.rows, self.floors, draft / "tradeoff.png")

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
        return []


def run(scene: Scene, options: dict[str, Any]) -> Result:
    """Measure, from the options of the command."""
    seed, threads, quiet = options["seed"], options["threads"], options["quiet"]
    lobes = [lobe_directions(scene, theta, options["directions"], seed) for theta in scene.theta]
    truth = reference(scene, lobes, options["samples"], seed)
    settings = ladder(options["method"], options["samples"])
    protocol = Protocol(options["replicates"], seed, options["qmc"])
    with Progress("methods", options["replicates"] + 1, "rounds", quiet) as progress:
        series = measure(scene, settings, lobes, protocol, progress.advance)
    rows = tabulating.method_rows(scene, series, truth)
    world, found = None, []
    if options["surfaces"] and scene.slopes == "beckmann":
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
    result.warnings = warnings_of(result, options)
    return result


def surfaces_for(scene: Scene, options: dict[str, Any]) -> World:
    """Surfaces of the wanted accuracy, traced."""
    names = ("accuracy", "cells", "extent", "realisations", "waves")
    resolution = plan(scene, *(options[name] for name in names))
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
    if options["surfaces"] and result.scene.slopes != "beckmann":
        warnings.append(
            "there are no explicit surfaces of GGX slopes: the distance of the model from the "
            "world is not drawn."
        )
    return warnings
