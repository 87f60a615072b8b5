"""`msbsdf simulate`"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import click

from msbsdf_cli.cli.help import Page
from msbsdf_cli.cli.meshes import BYTES_PER_CELL, refuse_mesh, write_mesh
from msbsdf_cli.cli.options import (
    FREE_PATH,
    MODEL_OF_SURFACES,
    OF_FILE,
    REPORT,
    RESOLUTION,
    samples,
    use,
)

RESOLVED = ("cells", "extent", "realisations", "waves", "autocorrelation", "heights_of")

CELLS_OF_PICTURE = 32
"""So that a person sees the surface and not the mesh."""


@click.command("simulate", cls=Page)
@use(*MODEL_OF_SURFACES, "orders")
@samples(None)
@use("heights-of", *RESOLUTION, "convergence", "save-mesh", "surface", *OF_FILE, "wavelength")
@use("max-order", *FREE_PATH, "seed", "threads", *REPORT)
def command(**options: Any) -> None:
    """Trace light on explicit surfaces: random ones, or your own.

    Several independent periodic surfaces are made, meshed and traced with Embree; all standard
    errors come from the spread between them. Writes energies per order, moments, lobes, free paths
    and a picture of the surface. With --surface, also its roughness in figures.
    """
    from msbsdf_cli.cli import common, own_surface
    from msbsdf_cli.cli.own_surface import show_quantities
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.cli.runs import show_run, write_run
    from msbsdf_cli.run.executors import do_all

    own_surface.check_options(options)
    if options["surface"] is not None:
        own_surface.simulate(options)
        return
    scene = common.scene_from(options)
    free_paths = common.free_paths_from(options, options["heights_of"])
    report = Report("simulate", slug(scene, options), options)
    refuse_mesh(options)
    resolution = resolve(scene, options)
    report.warn(common.scene_warnings(options) + surface_warnings(options))
    report.warn(common.long_warnings(options, *effort(scene, options)))
    about = fitted_slopes(scene, resolution, options)
    with report.draft() as draft:
        result = run(scene, resolution, free_paths, options)
        lobes, pictures = write_run(
            report, draft, result, {"roughness.csv": about.to_columns()} if about else None
        )
        if options["convergence"]:
            write_convergence(draft, scene, options)
        do_all([*pictures, draw(draft, scene, resolution, options)], options["threads"])

    def show() -> None:
        click.echo(
            f"{resolution.realisations} surfaces of {resolution.lengths:.4g} correlation lengths, "
            f"{resolution.cells * resolution.extent} cells along a side."
        )
        show_run(lobes, result, "rays")
        if about is not None:
            show_quantities(about)

    report.end(show)


def fitted_slopes(scene: Any, resolution: Any, options: dict[str, Any]) -> Any:
    """What the slopes of facets are like, where these are not Beckmann's."""
    from msbsdf_cli.experiments.random_surfaces import facet_slopes
    from surfaces.describe import Description
    from surfaces.describe.fits import fits

    if not resolution.skewed:
        return None
    return Description(fits(facet_slopes(scene, resolution, options["seed"])), [])


def slug(scene: Any, options: dict[str, Any]) -> str:
    """The scene as a file name; slopes of skewed heights have no name of their own."""
    if options["heights_of"] == "gaussian":
        return str(scene.slug())
    alpha = (f"{a:g}" for a in dict.fromkeys(scene.alpha))
    return "-".join((scene.material.name, options["heights_of"].replace(":", "-"), *alpha))


def resolve(scene: Any, options: dict[str, Any]) -> Any:
    """The resolution; what the options leave open of it is filled in."""
    from msbsdf_cli.experiments.resolution import plan, rays
    from msbsdf_cli.run.memory import gigabytes, memory_bytes

    given = (options[name] for name in RESOLVED)
    resolution = plan(scene, options["accuracy"], *given)
    options |= vars(resolution)
    options["samples"] = options["samples"] or rays(resolution)
    need = BYTES_PER_CELL * (resolution.cells * resolution.extent) ** 2
    need *= min(options["threads"], resolution.realisations)
    if need > memory_bytes():
        raise click.BadParameter(
            f"surfaces of {resolution.lengths:.4g} correlation lengths with "
            f"{resolution.cells * resolution.extent} cells along a side need {gigabytes(need)} in "
            f"{options['threads']} processes, and this machine has {gigabytes(memory_bytes())}.",
            param_hint="--extent, --cells, --threads",
        )
    return resolution


def effort(scene: Any, options: dict[str, Any]) -> tuple[float, str]:
    """About how many seconds one core will need, and for what."""
    from msbsdf_cli.cli.common import RAYS_PER_S, TRIANGLES_PER_S
    from msbsdf_cli.experiments.pilot import pilot
    from msbsdf_cli.experiments.realisations import FREE_PATHS_OF_RAYS, RAYS_OF_SHARED
    from msbsdf_cli.smith.heights import Gaussian
    from msbsdf_cli.statistics.discretisation import on_all_meshes

    side, surfaces = options["extent"] * options["cells"], options["realisations"]
    rays = options["samples"] * len(options["theta"])
    # Coarser meshes have a quarter and a sixteenth of the triangles.
    shared = on_all_meshes(surfaces) / surfaces
    triangles = 2 * side**2 * surfaces * (1 + shared * 5 / 16)
    rows = len(options["free_path_theta"]) * len(options["free_path_height"] or Gaussian.starts)
    facets = rays * pilot(scene)[1] * (1 + 2 * shared / RAYS_OF_SHARED)
    facets += options["samples"] * rows * FREE_PATHS_OF_RAYS
    seconds = triangles / TRIANGLES_PER_S + facets / RAYS_PER_S
    return seconds, f"{surfaces} surfaces of {side} by {side} cells and {rays:.2g} rays"


def surface_warnings(options: dict[str, Any]) -> list[str]:
    """Sentences on what costs accuracy or hours on surfaces."""
    import math

    from msbsdf_cli.scene import from_normal, in_degrees

    warnings = []
    longest = 2 * options["extent"] / min(options["alpha"])
    theta = max(options["theta"], key=from_normal)
    periods = 8 * math.tan(from_normal(theta)) / longest
    if periods > 100:
        warnings.append(
            f"theta {in_degrees(theta)} is so near the horizon that a ray crosses "
            f"up to {periods:.0f} periods of the surface before it meets it; the run may take long."
        )
    if options["realisations"] < 8:
        warnings.append(
            f"with {options['realisations']} surfaces the standard errors themselves are known to "
            f"{100 / math.sqrt(2 * (options['realisations'] - 1)):.0f} % only."
        )
    return warnings


def run(scene: Any, resolution: Any, free_paths: Any, options: dict[str, Any]) -> Any:
    """Simulate."""
    from msbsdf_cli.experiments.realisations import simulate

    names = ("seed", "threads", "max_order", "quiet")
    work = scene, options["samples"], resolution, free_paths
    return simulate(*work, *(options[name] for name in names))


def draw(draft: Path, scene: Any, resolution: Any, options: dict[str, Any]) -> Callable[[], None]:
    """What draws the first surface; the surface itself becomes a mesh where that is wanted."""
    from msbsdf_cli.experiments.random_surfaces import realisation
    from msbsdf_cli.plots.surface import draw_surface

    if options["save_mesh"] is not None:
        surface = realisation(resolution, 0, options["seed"])
        write_mesh(Path(options["save_mesh"]), surface.mesh(surface.stretch(*scene.alpha)))
    finer = replace(resolution, cells=max(resolution.cells, CELLS_OF_PICTURE))
    surface = realisation(finer, 0, options["seed"])
    return partial(draw_surface, draft, surface, surface.stretch(*scene.alpha), scene.alpha)


def write_convergence(draft: Path, scene: Any, options: dict[str, Any]) -> None:
    """convergence.csv and convergence.png"""
    from msbsdf_cli.experiments.convergence import convergence
    from msbsdf_cli.plots.convergence import draw_convergence
    from msbsdf_cli.results.files import write_csv

    rays = options["samples"], options["seed"], options["threads"], options["quiet"]
    table = convergence(scene, *rays, None, *(options[n] for n in RESOLVED[-2:]))
    write_csv(draft / "convergence.csv", table)
    draw_convergence(table, draft)
