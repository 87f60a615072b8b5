"""`msbsdf simulate`"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from msbsdf_cli.cli.options import FREE_PATH, MODEL_OF_SURFACES, REPORT, RESOLUTION, samples, use

CELLS_OF_PICTURE = 32
"""So that a person sees the surface and not the mesh."""


@click.command("simulate")
@use(*MODEL_OF_SURFACES, "orders")
@samples("1e6")
@use(*RESOLUTION, "convergence", "mesh", "max-order", *FREE_PATH, "seed", "threads", *REPORT)
def command(**options: Any) -> None:
    """Trace light on explicit random Beckmann surfaces.

    Several independent periodic surfaces are made, meshed and traced with Embree; all standard
    errors come from the spread between them. Writes energies per order, moments, lobes, free paths
    and a picture of the surface.
    """
    from msbsdf_cli.cli import common
    from msbsdf_cli.results.directory import new_report
    from msbsdf_cli.results.manifest import show_end, show_json, show_run

    scene = common.scene_from(options)
    common.free_paths_from(options, "gaussian")
    out = common.out_directory("simulate", scene.slug(), options)
    refuse_mesh(options)
    resolve(scene, options)
    warnings = common.scene_warnings(options, work_s(options)) + surface_warnings(options)
    common.announce(warnings)
    with new_report(out) as draft:
        outcome, record = run(draft, scene, options, warnings)
    if options["as_json"]:
        show_json(record | {"report": str(out)})
    elif not options["quiet"]:
        click.echo(
            f"{options['realisations']} surfaces of {options['extent']} correlation lengths, "
            f"{options['cells']} cells each."
        )
        show_run(scene, outcome)
        show_end(out, record, "rays")


def resolve(scene: Any, options: dict[str, Any]) -> None:
    """Fill in the cells, extent and realisations that the options leave open."""
    from msbsdf_cli.experiments.resolution import plan

    given = (options[name] for name in ("cells", "extent", "realisations", "waves"))
    resolution = plan(scene, options["accuracy"], *given)
    options["cells"] = resolution.cells
    options["extent"] = resolution.extent
    options["realisations"] = resolution.realisations


def refuse_mesh(options: dict[str, Any]) -> None:
    """Refuse a mesh file that cannot be written. Raises click.BadParameter."""
    if options["mesh"] is None:
        return
    path = Path(options["mesh"])
    formats = ("ply", "obj", "stl", "off", "glb")
    if path.suffix.lower().removeprefix(".") not in formats:
        raise click.BadParameter(
            f"{path}: a mesh is written as one of .{', .'.join(formats)}.", param_hint="--mesh"
        )
    if path.exists() and not options["force"]:
        raise click.BadParameter(
            f"{path} is already there; name another file, or replace it with --force.",
            param_hint="--mesh",
        )
    if not path.absolute().parent.is_dir():
        raise click.BadParameter(f"{path}: there is no such directory.", param_hint="--mesh")


def work_s(options: dict[str, Any]) -> float:
    """About how many seconds one core will need."""
    from msbsdf_cli.cli.common import RAYS_PER_S, TRIANGLES_PER_S

    triangles = 2 * (options["extent"] * options["cells"]) ** 2 * options["realisations"]
    rays = options["samples"] * len(options["theta"])
    return float(triangles / TRIANGLES_PER_S + rays / RAYS_PER_S)


def surface_warnings(options: dict[str, Any]) -> list[str]:
    """Sentences on what costs accuracy or hours on surfaces."""
    import math

    warnings = []
    longest = 2 * options["extent"] / min(options["alpha"])
    periods = 8 * math.tan(max(options["theta"])) / longest
    if periods > 100:
        warnings.append(
            f"theta {max(options['theta']):g} is so near the horizon that a ray crosses up to "
            f"{periods:.0f} periods of the surface before it meets it; the run takes long."
        )
    if options["realisations"] < 8:
        warnings.append(
            f"with {options['realisations']} surfaces the standard errors themselves are known to "
            f"{100 / math.sqrt(2 * (options['realisations'] - 1)):.0f} % only."
        )
    return warnings


def run(
    draft: Path, scene: Any, options: dict[str, Any], warnings: list[str]
) -> tuple[Any, dict[str, Any]]:
    """Simulate, and write the report into `draft`; the outcome and the content of run.json."""
    import numpy as np

    from msbsdf_cli.cli.common import free_paths_from
    from msbsdf_cli.experiments.realisations import Resolution, realisation, simulate
    from msbsdf_cli.plots.lobes import GROUPS
    from msbsdf_cli.plots.surface import draw_surface
    from msbsdf_cli.results.manifest import now, write_run

    started = now()
    resolution = Resolution(
        options["cells"], options["extent"], options["realisations"], options["waves"]
    )
    outcome = simulate(
        scene,
        options["samples"],
        resolution,
        free_paths_from(options, "gaussian"),
        options["seed"],
        options["threads"],
        options["max_order"],
        options["quiet"],
    )
    record = write_run(draft, "simulate", options, started, scene, outcome, warnings)
    np.save(draft / GROUPS, np.asarray(outcome.lobe_groups, np.float32))
    if options.get("convergence"):
        write_convergence(draft, scene, options)
    finer = replace(resolution, cells=max(resolution.cells, CELLS_OF_PICTURE))
    draw_surface(draft, realisation(finer, 0, options["seed"]), scene.alpha)
    if options["mesh"] is not None:
        surface = realisation(resolution, 0, options["seed"])
        write_mesh(Path(options["mesh"]), surface.mesh(*scene.alpha))
    return outcome, record


def write_convergence(draft: Path, scene: Any, options: dict[str, Any]) -> None:
    """convergence.csv and convergence.png"""
    from msbsdf_cli.experiments.convergence import convergence
    from msbsdf_cli.plots.convergence import draw_convergence
    from msbsdf_cli.results.directory import write_csv

    rays = options["samples"], options["seed"], options["threads"], options["quiet"]
    table = convergence(scene, *rays)
    write_csv(draft / "convergence.csv", table)
    draw_convergence(table, draft)


def write_mesh(path: Path, mesh: Any) -> None:
    """Write a mesh, whole or not at all, in the format that the file's name ends in."""
    import os
    import tempfile

    with tempfile.TemporaryDirectory(prefix=f".{path.stem}-", dir=path.absolute().parent) as draft:
        file = Path(draft) / path.name
        mesh.export(file)
        os.replace(file, path)
