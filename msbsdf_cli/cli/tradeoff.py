"""`msbsdf tradeoff`"""

from typing import Any

import click

from msbsdf_cli.cli.options import MODEL, REPORT, RESOLUTION, Count, samples, use


@click.command("tradeoff")
@use("method", *(name for name in MODEL if name != "heights"), "orders")
@samples("4096")
@click.option(
    "--replicates",
    type=Count(4),
    default="16",
    show_default=True,
    metavar="N",
    help="Independent repetitions of each setting: they tell bias from noise, and time.",
)
@click.option(
    "--directions",
    type=Count(16),
    default="256",
    show_default=True,
    metavar="N",
    help="Outgoing directions that errors are measured in.",
)
@click.option("--qmc", is_flag=True, help="Scrambled Sobol points where a path starts.")
@click.option(
    "--claims",
    is_flag=True,
    help="Also what a paper says of noise: the error of a slab's image over time.",
)
@click.option(
    "--surfaces/--no-surfaces",
    default=True,
    show_default=True,
    help="Trace explicit surfaces, for the distance of the models from them.",
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
    floor below which no effort on the model pays.
    """
    from msbsdf_cli.cli import common
    from msbsdf_cli.experiments.tradeoff.study import run
    from msbsdf_cli.results import manifest
    from msbsdf_cli.results.directory import new_report

    scene = common.scene_from(options)
    options["method"] = common.methods_for(scene, options["method"])
    out = common.out_directory("tradeoff", scene.slug(), options)
    warnings = common.scene_warnings(options, work_s(options))
    common.announce(warnings)
    started, elapsed = manifest.now(), manifest.stopwatch()
    with new_report(out) as draft:
        result = run(scene, options)
        common.announce(result.warnings)
        walks = sum(s.setting.samples * len(s.seconds) for s in result.series)
        warnings += result.warnings
        record = manifest.methods_record("tradeoff", options, started, elapsed(), walks, warnings)
        record |= result.record()
        manifest.write_report(draft, record, result.tables())
        result.draw(draft)
    if options["as_json"]:
        manifest.show_json(record | {"report": str(out)})
    elif not options["quiet"]:
        show(result)
        click.echo(f"Report: {out}")


EVALUATIONS_PER_S = 2e7
"""Rough rate of one core in walks times directions, for telling beforehand what takes long."""

FIRST_ORDER_S = 1.5e-4
"""Of one direction of diffuse facets, whose first bounce is a quadrature in every evaluation."""

SOLVE_S = 6e-3
SOLVE_GRID_S = 1.5e-2
"""Of one direction of a dielectric by `solve`, of one roughness and of two."""

SETTINGS = 5
"""Of a method, about."""


def work_s(options: dict[str, Any]) -> float:
    """About how many seconds of one core this takes; timing runs on one, so all count."""
    from surfaces.materials import material

    runs = len(options["theta"]) * options["replicates"]
    walks = 4 / 3 * options["samples"] * options["directions"] / EVALUATIONS_PER_S
    methods, direction = len(options["method"]), 0.0
    facets = material(options["material"])
    if facets.lambertian:
        direction = methods * FIRST_ORDER_S
    elif facets.transmits and "solve" in options["method"]:
        direction = SOLVE_S if len(set(options["alpha"])) == 1 else SOLVE_GRID_S
    directions = SETTINGS * options["directions"] * direction
    return float(runs * (methods * walks + directions) * options["threads"])


def show(result: Any) -> None:
    """Print the dearest setting of each method, angle by angle, and what floors there are."""
    from msbsdf_cli.cli.terminal import measured, show_table

    last = {(r.theta_i_rad, r.method): r for r in result.rows}
    lines = [
        (
            f"{r.theta_i_rad:.4g}",
            r.method,
            measured(r.relative_rmse, r.relative_rmse_stderr),
            f"{r.bias:.2g}" if r.bias_z > 3 or r.samples == 0 else "",
            f"{r.seconds:.2g}",
            f"{r.setup_s:.2g}" if r.setup_s > 1e-4 else "",
            f"{r.efficiency_with_setup:.3g}",
            f"{r.slope:.2f}",
            f"{r.to_surfaces:.2g}",
        )
        for r in sorted(last.values(), key=lambda r: r.theta_i_rad)
    ]
    header = ("theta", "method", "relative RMSE", "bias", "seconds", "set-up", "efficiency")
    show_table((*header, "slope", "to surfaces"), lines)
    for sentence in result.sentences():
        click.echo(sentence)
