"""`msbsdf compare --autocorrelation gaussian,exponential,...`"""

from collections.abc import Callable
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import Any

import click

Pictures = list[Callable[[], None]]


def check_options(runs: tuple[str, ...], options: dict[str, Any]) -> None:
    """Refuse what is of one kind of surface, or of another model. Raises click.UsageError."""
    beside = "beside several --autocorrelation:"
    if runs:
        raise click.UsageError(f"reports {beside} surfaces of each of them are simulated.")
    if options["method"] is not None:
        raise click.UsageError(f"--method {beside} it is the walk that is held against them.")
    if options["memory"]:
        raise click.UsageError(f"--memory {beside} that walk is another one for each of them.")
    if options["heights_of"] != "gaussian":
        raise click.UsageError(f"--heights-of {beside} one is varied at a time.")
    if options["save_mesh"] is not None:
        raise click.UsageError(f"--save-mesh {beside} it is for one surface.")


def compare(options: dict[str, Any]) -> None:
    """Walk once, simulate surfaces of every spectrum, and write the report."""
    from msbsdf_cli.cli import common, simulate, walk
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.cli.runs import write_part
    from msbsdf_cli.experiments.resolution import LEAST_RAYS
    from msbsdf_cli.run.executors import do_all

    options["heights"] = "gaussian"
    scene = common.scene_from(options)
    free_paths = common.free_paths_from(options, "gaussian")
    place = Report("compare", f"{scene.slug()}-spectra", options)
    each = {name: options | {"autocorrelation": name} for name in options["autocorrelation"]}
    resolutions = {name: simulate.resolve(scene, of) for name, of in each.items()}
    options["samples"] = options["samples"] or LEAST_RAYS
    efforts = [walk.effort(scene, options), *(simulate.effort(scene, of) for of in each.values())]
    warnings = [text for of in each.values() for text in simulate.surface_warnings(of)]
    warnings += common.scene_warnings(options) + common.facet_warnings(scene)
    work = " and ".join(words for _, words in efforts)
    warnings += common.long_warnings(options, sum(seconds for seconds, _ in efforts), work)
    place.warn(list(dict.fromkeys(warnings)))
    with place.draft() as draft:
        model, pictures = write_part(draft, walk.run(scene, free_paths, options), options)
        runs = {}
        for name, of in each.items():
            runs[name] = simulate.run(scene, resolutions[name], free_paths, of)
            kept = f"simulate-{name.replace(':', '-')}"
            pictures += write_part(draft, runs[name], of, kept)[1]
        pictures += write(place, draft, runs, model, resolutions)
        do_all(pictures, options["threads"])
    place.end()


def write(
    place: Any, draft: Path, runs: dict[str, Any], model: Any, resolutions: dict[str, Any]
) -> Pictures:
    """Write the report into `draft`; what draws."""
    from msbsdf_cli.cli.simulate import CELLS_OF_PICTURE
    from msbsdf_cli.experiments.compare import Row
    from msbsdf_cli.experiments.random_surfaces import realisation
    from msbsdf_cli.experiments.spectra import relative, rows_of
    from msbsdf_cli.plots.spectra import draw_spectra
    from msbsdf_cli.results.files import columns

    rows = {name: rows_of(run.lobes(), model) for name, run in runs.items()}
    table = columns([row for of in rows.values() for row in of], (f.name for f in fields(Row)))
    table = {**table, "autocorrelation": [name for name, of in rows.items() for _ in of]}
    errors = {name: relative(of) for name, of in rows.items()}
    paths = sum(run.paths for run in runs.values())
    bounces = sum(run.paths * run.bounces_mean for run in runs.values()) / paths
    wall_s = sum(run.wall_s for run in runs.values())
    more = {"summary": in_one_sentence(errors)}
    place.write(draft, {"agreement.csv": table}, paths, bounces, wall_s, more)
    surfaces: list[tuple[str, Callable[[], Any]]] = []
    for name, resolution in resolutions.items():
        finer = replace(resolution, cells=max(resolution.cells, CELLS_OF_PICTURE))
        surfaces.append((name, partial(realisation, finer, 0, place.options["seed"])))
    alpha, found = next(iter(runs.values())).scene.alpha, list(errors.values())
    return [partial(draw_spectra, draft / "spectra.png", alpha, surfaces, found)]


def in_one_sentence(errors: dict[str, tuple[Any, Any, Any]]) -> str:
    """By how much the model is off on each, at the angle where they differ most."""
    import numpy as np

    from msbsdf_cli.scene import in_degrees

    theta = next(iter(errors.values()))[0]
    values = np.array([value for _, value, _ in errors.values()])
    apart = np.nan_to_num(np.ptp(values, axis=0), nan=-1, posinf=-1)
    at = int(np.argmax(apart))
    if apart[at] < 0:
        return "Light bounces so seldom more than once that nothing is known of multiple bounces."
    said = [
        f"{off(float(value[at]), float(stderr[at]))} on {name}"
        for name, (_, value, stderr) in errors.items()
    ]
    return (
        "The Smith model has one BSDF for all of them: at theta "
        f"{in_degrees(theta[at])}, where they differ most, its energy of multiple bounces is "
        f"{', '.join(said[:-1])} and {said[-1]} surfaces."
    )


def off(value: float, stderr: float) -> str:
    """A relative error in words."""
    size, error = 100 * abs(value), 100 * stderr
    digits = 0 if error >= 1 else 1
    side = "high" if value > 0 else "low"
    return f"{size:.{digits}f} +- {error:.{digits}f} % too {side}"
