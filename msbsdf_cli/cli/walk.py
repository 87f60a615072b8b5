"""`msbsdf walk`"""

from typing import Any

import click

from msbsdf_cli.cli.help import Page
from msbsdf_cli.cli.options import FREE_PATH, MODEL, OF_FILE, REPORT, samples, use


@click.command("walk", cls=Page)
@use(MODEL[0], "slopes-or-surface", *MODEL[2:], "orders")
@samples("4e6")
@use(
    "memory",
    "autocorrelation",
    "max-order",
    *FREE_PATH,
    "surface",
    *OF_FILE,
    "seed",
    "threads",
    "precision",
    *REPORT,
)
def command(**options: Any) -> None:
    """Run the random walk of the Smith model: no surface, only its statistics.

    With --memory 1 it remembers the last facet, and follows surfaces more closely; with --memory 2
    the heights that rays pass, too, and more closely still, for a fourth of the speed.

    Writes energies per order, moments, lobes and free paths, with standard errors.
    """
    from msbsdf_cli.cli import common, own_surface
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.cli.runs import show_run, write_run
    from msbsdf_cli.run.executors import do_all

    own_surface.check_options(options)
    if options["surface"] is None:
        scene = common.scene_from(options)
        common.check_memory(scene, options)
        report = Report("walk", scene.slug(), options)
    else:
        if options["memory"]:
            raise click.UsageError("--memory beside --surface: it is for Gaussian surfaces.")
        report = own_surface.report("walk", options)
        scene = own_surface.scene_of_slopes(options, report)
    free_paths = common.free_paths_from(options, options["heights"])
    report.warn(common.scene_warnings(options) + common.facet_warnings(scene))
    report.warn(common.long_warnings(options, *effort(scene, options)))
    with report.draft() as draft:
        result = run(scene, free_paths, options)
        lobes, pictures = write_run(report, draft, result)
        do_all(pictures, options["threads"])
    report.end(lambda: show_run(lobes, result, "walks"))


def effort(scene: Any, options: dict[str, Any]) -> tuple[float, str]:
    """About how many seconds one core will need, and for what."""
    from msbsdf_cli.experiments.pilot import pilot
    from msbsdf_cli.memory.remembered import TAKES

    seconds, facets = pilot(scene)
    walks = options["samples"] * len(scene.theta)
    if options["memory"]:
        seconds *= TAKES[options["memory"]]
    return options["samples"] * seconds, f"{walks:.2g} walks of {facets:.2g} facets in the mean"


def run(scene: Any, free_paths: Any, options: dict[str, Any]) -> Any:
    """Walk."""
    from msbsdf_cli.experiments.walk import remembered_surface
    from msbsdf_cli.experiments.walks import walk

    names = ("heights", "seed", "threads", "precision", "max_order", "quiet")
    surface = remembered_surface(scene.slopes, options["memory"], options["autocorrelation"])
    how = *(options[name] for name in names), surface
    return walk(scene, options["samples"], free_paths, *how)
