"""`msbsdf compare --heights-of ridges`: random surfaces whose slopes have no name."""

from pathlib import Path
from typing import Any

import click


def compare(options: dict[str, Any]) -> None:
    """Trace light on random surfaces, walk on the slopes of their facets and on what is fitted to
    these, and write the report."""
    from msbsdf_cli.cli import common, compare_surface, simulate
    from msbsdf_cli.cli.meshes import refuse_mesh
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.cli.runs import write_part
    from msbsdf_cli.experiments.fitted_walks import traced, walks_on
    from msbsdf_cli.experiments.parts import parts
    from msbsdf_cli.experiments.random_surfaces import facet_slopes
    from msbsdf_cli.run.executors import do_all
    from surfaces.describe import Description
    from surfaces.describe.fits import fits

    check_options(options)
    beckmann = common.scene_from(options | {"slopes": "beckmann"})
    place = Report("compare", simulate.slug(beckmann, options), options)
    refuse_mesh(options)
    free_paths = common.free_paths_from(options, options["heights_of"])
    resolution = simulate.resolve(beckmann, options)
    slopes = facet_slopes(beckmann, resolution, options["seed"])
    about = Description(fits(slopes), [])
    models, name = compare_surface.models_from(slopes, about, options)
    scene = common.scene_from(options, models[name][0])
    options |= {"slopes": name, "gamma": getattr(scene.slopes, "gamma", None)}
    warnings = simulate.surface_warnings(options)
    compare_surface.warn(place, scene, options, warnings, len(models))
    with place.draft() as draft:
        run = simulate.run(beckmann, resolution, free_paths, options)
        lobes, pictures = write_part(draft, run, options)
        pictures.append(simulate.draw(draft, beckmann, resolution, options))
        of_walks = ("samples", "seed", "threads", "precision", "max_order", "quiet")
        walks = walks_on(scene, models, *(options[n] for n in of_walks))
        light = traced(lobes, run.paths // len(scene.theta))
        found = parts(scene, light, walks, name)
        pictures += compare_surface.write(place, Path(draft), run, found, models, about)
        do_all(pictures, options["threads"])
    place.end(lambda: compare_surface.show_parts(found))


def check_options(options: dict[str, Any]) -> None:
    """Refuse options of other comparisons. Raises click.UsageError."""
    if options["memory"]:
        raise click.UsageError("--memory beside --heights-of: it is for Gaussian surfaces.")
    if options["method"] is not None:
        raise click.UsageError("--method beside --heights-of: its parts are those of the walk.")
