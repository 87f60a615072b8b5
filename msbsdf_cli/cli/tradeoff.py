"""`msbsdf tradeoff`"""

from dataclasses import fields, replace
from functools import partial
from typing import Any

import click

from msbsdf_cli.cli.help import Page
from msbsdf_cli.cli.options import MODEL, REPORT, RESOLUTION, samples, use
from msbsdf_cli.cli.types import Count


@click.command("tradeoff", cls=Page)
@use("method", *(name for name in MODEL if name != "heights"), "orders")
@samples("4096")
@click.option(
    "--replicates",
    type=Count(4, most=10_000),
    metavar="N",
    help="Independent repetitions of each setting: they tell bias from noise, and time; default: "
    "16, or down to 6 where so many take long.",
)
@click.option(
    "--directions",
    type=Count(16, most=65_536),
    default="256",
    show_default=True,
    metavar="N",
    help="Outgoing directions that errors are measured in.",
)
@click.option("--qmc", is_flag=True, help="Scrambled Sobol points where a path starts.")
@click.option(
    "--surfaces/--no-surfaces",
    default=True,
    show_default=True,
    help="Trace explicit surfaces, for the distance of the models from them.",
)
@click.option(
    "--against",
    type=click.Choice(["smith", "surfaces"]),
    default="smith",
    show_default=True,
    help="What errors are against: the Smith model solved, or traced surfaces (Beckmann).",
)
@click.option(
    "--rays",
    type=Count(),
    default="1e6",
    show_default=True,
    metavar="N",
    help="Rays on the surfaces, for each incident angle.",
)
@use(*RESOLUTION, "seed", "threads", *REPORT)  # fmt: skip
def command(**options: Any) -> None:
    """Error against time for every method, on one chart.

    Each method goes from few walks to --samples, solve from coarse to fine. Errors are measured
    against the Smith model solved; how far that itself is from explicit surfaces is drawn as the
    floor below which no effort on the model pays. With --against surfaces that distance is part of
    the error: methods of the Smith model stop at it, and walk-memory goes on below.
    """
    from msbsdf_cli.cli import common
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.experiments.tradeoff.study import study
    from msbsdf_cli.plots.scaling import draw_scaling
    from msbsdf_cli.plots.tradeoff import draw_tradeoff
    from msbsdf_cli.run.executors import do_all

    scene = common.scene_from(options)
    traceable = options["surfaces"] and scene.slopes.name == "beckmann"
    if options["against"] == "surfaces" and not traceable:
        raise click.UsageError(
            "--against surfaces is for Beckmann slopes, whose surfaces are traced, and not with "
            "--no-surfaces."
        )
    options["method"] = methods_of(scene, options)
    if options["replicates"] is None:
        options["replicates"] = affordable(options)
    report = Report("tradeoff", scene.slug(), options)
    report.warn(common.scene_warnings(options))
    report.warn(common.method_warnings([scene], options["method"]))
    work = f"{options['replicates']} runs of {len(options['method'])} methods, timed on one core"
    report.warn(common.long_warnings(options, work_s(options), work))
    settings = settings_from(scene, options)
    if settings.resolution is None:
        report.warn([NO_SURFACES] if options["surfaces"] else [])
        report.warn(common.not_remembered(options))
    with report.draft() as draft:
        result = study(scene, settings)
        report.warn(result.warnings)
        walks = options["replicates"] * sum(r.samples for r in result.rows)
        report.write(draft, tables(result), walks, more=in_words(result))
        place, of_energies = draft / "energies.png", "energies of orders"
        pictures = [partial(draw_tradeoff, result.rows, result.floors, draft / "tradeoff.png")]
        if result.energies:
            pictures.append(partial(draw_tradeoff, result.energies, [], place, of_energies))
        pictures.append(partial(draw_scaling, result.scaling, draft / "scaling.png"))
        do_all(pictures, options["threads"])
    report.end(lambda: show(result.rows))


def methods_of(scene: Any, options: dict[str, Any]) -> tuple[str, ...]:
    """Those that are wanted, or all; against the Smith model without those of another one, whose
    distance from it is no error."""
    from msbsdf_cli.cli import common
    from msbsdf_cli.methods.registry import METHODS

    found = common.methods_for(scene, options["method"])
    if options["method"] is not None or options["against"] == "surfaces":
        return found
    return tuple(name for name in found if METHODS[name].traits.smith_first)


NO_SURFACES = (
    "there are explicit surfaces of Beckmann slopes only: the distance of the model from surfaces "
    "is not drawn."
)

SURFACES = 64
"""Realisations, unless the accuracy wants more: lobes scatter more between surfaces than energies
do, and a surface is cheap. A distance of .03 is known to about .004 then."""


def settings_from(scene: Any, options: dict[str, Any]) -> Any:
    """How much is measured, from the options."""
    from msbsdf_cli.experiments.resolution import plan
    from msbsdf_cli.experiments.tradeoff.study import Settings

    resolution = None
    if options["surfaces"] and scene.slopes.name == "beckmann":
        names = ("accuracy", "cells", "extent", "realisations", "waves", "autocorrelation")
        resolution = plan(scene, *(options[name] for name in names))
        if options["realisations"] is None:
            resolution = replace(resolution, realisations=max(resolution.realisations, SURFACES))
    same = ("samples", "replicates", "directions", "qmc", "rays", "seed", "threads", "quiet")
    amounts = {name: options[name] for name in (*same, "against", "autocorrelation")}
    return Settings(methods=options["method"], resolution=resolution, **amounts)


def tables(result: Any) -> dict[str, Any]:
    """All tables by file name."""
    from msbsdf_cli.experiments.tradeoff.floors import Floor
    from msbsdf_cli.experiments.tradeoff.rows import Row
    from msbsdf_cli.experiments.tradeoff.scaling import Scaling
    from msbsdf_cli.experiments.tradeoff.time_to_accuracy import TimeToAccuracy, times_to_accuracy
    from msbsdf_cli.results.files import columns

    found = {
        "tradeoff.csv": (Row, result.rows),
        "floors.csv": (Floor, result.floors),
        "reach.csv": (TimeToAccuracy, times_to_accuracy(result.rows)),
        "pairs.csv": (Row, result.pairs),
        "scaling.csv": (Scaling, result.scaling),
    }
    if result.energies:
        found["energies.csv"] = (Row, result.energies)
    names = {file: [f.name for f in fields(kind)] for file, (kind, _) in found.items()}
    return {file: columns(rows, names[file]) for file, (_, rows) in found.items()}


def in_words(result: Any) -> dict[str, Any]:
    """What run.json says of it: the reference, and what the chart says at a glance."""
    from msbsdf_cli.experiments.tradeoff.time_to_accuracy import (
        sentences,
        tenfold,
        times_to_accuracy,
    )

    found = times_to_accuracy(result.rows)
    said = sentences(found) + tenfold(found)
    smith, memory = (_apart(result.floors, model) for model in ("smith", "memory"))
    if smith:
        said.append(
            f"Distance of the Smith model from explicit surfaces: {smith}. A smaller error "
            "against the model is wasted there."
        )
    if memory:
        said.append(f"That of the walk that remembers the last facet: {memory}.")
    truth = result.truth
    reference = {
        "method": truth.method,
        "resolution": truth.resolution,
        "relative_noise": truth.noise,
        "margin": result.margin,
        "seconds": truth.seconds,
    }
    return {"reference": reference, "summary": "\n".join(said)}


def _apart(floors: list[Any], model: str) -> str:
    """How far a model is from the surfaces, angle by angle; nothing where that was not measured."""
    from msbsdf_cli.cli.terminal import measured
    from msbsdf_cli.scene import in_degrees

    return ", ".join(
        f"{measured(f.relative_rmse, f.stderr)} at theta {in_degrees(f.theta_i_rad)}"
        for f in floors
        if (f.floor, f.model) == ("model", model)
    )


FIRST_ORDER_S = 1.5e-4
"""Of one direction of diffuse facets, whose first bounce is a quadrature in every evaluation."""

SOLVE_S = 6e-3
SOLVE_GRID_S = 1.5e-2
"""Of one direction of a dielectric by `solve`, of one roughness and of two."""

SETTINGS = 5
"""About how many settings of each method are measured."""


def affordable(options: dict[str, Any]) -> int:
    """Replicates that take `CHART_S`, or the nearest number that says something."""
    one = work_s(options | {"replicates": 1}) / options["threads"]
    return max(LEAST_REPLICATES, min(MOST_REPLICATES, int(CHART_S / one)))


LEAST_REPLICATES, MOST_REPLICATES, CHART_S = 6, 16, 25


def work_s(options: dict[str, Any]) -> float:
    """About how many seconds of one core this takes; timing runs on one, so all count."""
    from msbsdf_cli.cli.common import EVALUATIONS_PER_S
    from surfaces.materials import material

    runs = len(options["theta"]) * options["replicates"]
    walks = 4 / 3 * options["samples"] * options["directions"] / EVALUATIONS_PER_S
    methods, direction = len(options["method"]), 0.0
    facets = material(options["material"])
    if not facets.specular:
        direction = methods * FIRST_ORDER_S
    elif facets.transmits and "solve" in options["method"]:
        direction = SOLVE_S if len(set(options["alpha"])) == 1 else SOLVE_GRID_S
    directions = SETTINGS * options["directions"] * direction
    return float(runs * (methods * walks + directions) * options["threads"])


def show(rows: list[Any]) -> None:
    """Print the dearest setting of each method, angle by angle, and what floors there are."""
    from msbsdf_cli.cli.terminal import measured, show_table
    from msbsdf_cli.scene import in_degrees

    last = {(r.theta_i_rad, r.method): r for r in rows}
    lines = [
        (
            in_degrees(r.theta_i_rad),
            r.method,
            measured(r.relative_rmse, r.relative_rmse_stderr),
            f"{r.bias:.2g}" if r.bias_z > 3 or r.samples == 0 else "",
            f"{r.seconds:.2g}",
            f"{r.setup_s:.2g}" if r.setup_s > 1e-4 else "",
            f"{r.efficiency_with_setup:.3g}",
            f"{r.slope:.2f}" if r.slope == r.slope else "",
            f"{r.to_surfaces:.2g}" if r.to_surfaces == r.to_surfaces else "",
        )
        for r in sorted(last.values(), key=lambda r: r.theta_i_rad)
    ]
    header = ("theta", "method", "relative RMSE", "bias", "seconds", "set-up", "efficiency")
    show_table((*header, "slope", "to surfaces"), lines, "tradeoff.csv", len(rows))
