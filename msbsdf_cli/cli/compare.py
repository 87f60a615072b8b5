"""`msbsdf compare`"""

from collections.abc import Callable
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import Any

import click

from msbsdf_cli.cli.help import Page
from msbsdf_cli.cli.options import (
    FREE_PATH,
    MODEL,
    MODEL_OF_SURFACES,
    OF_FILE,
    REPORT,
    RESOLUTION,
    VARIANTS,
    samples,
    use,
)
from msbsdf_cli.smith.slopes import OF_SURFACE

Pictures = list[Callable[[], None]]
"""What draws pictures, side by side on all cores."""


@click.command("compare", cls=Page)
@click.argument("runs", nargs=-1, metavar="[RUN [RUN]]", type=click.Path())
@use(MODEL[0], "slopes", "gamma", *MODEL_OF_SURFACES[2:], "orders", "method", "memory")
@samples(None)
@use(
    "heights-of",
    "autocorrelations",
    *RESOLUTION[1:],
    "save-mesh",
    "surface",
    *OF_FILE,
    "wavelength",
    "max-order",
    *FREE_PATH,
    "seed",
    "threads",
    "precision",
    *REPORT,
)
def command(runs: tuple[str, ...], **options: Any) -> None:
    """Hold the Smith model against explicit surfaces: free paths and lobes.

    RUN is the directory of a report of `simulate` or `walk`; what is not given is run, for the
    same scene. Writes agreement.csv and pictures, and the reports that it made as directories.
    With --method, the lobes of other methods are held against the surfaces instead of the walk;
    with --memory 1 or 2, a walk that remembers the surface is. With several --autocorrelation, the
    walk is held against surfaces of each, which Smith's cannot tell apart, and spectra.png shows
    how far its multiple bounces are off.

    With --surface, says what part of the difference from your surface comes from the slope
    distribution, which is fitted to it (the best one, or that of --slopes), what part from heights
    that are correlated, and what part single scattering would add. Writes roughness.csv too.
    """
    from msbsdf_cli.cli import compare_surface

    compare_surface.check_options(runs, options)
    if options["surface"] is not None:
        compare_surface.compare(options)
        return
    if isinstance(options["autocorrelation"], tuple):
        from msbsdf_cli.cli import compare_spectra

        compare_spectra.check_options(runs, options)
        compare_spectra.compare(options)
        return
    if options["heights_of"] != "gaussian" and not runs:
        from msbsdf_cli.cli import compare_skewed

        compare_skewed.compare(options)
        return
    from msbsdf_cli.cli import common, compare_words
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.run.executors import do_all

    if len(runs) > 2:
        raise click.UsageError(f"{len(runs)} reports are given; two are compared.")
    handed = take_runs(runs, options)
    first = next(iter(handed.values()), None)
    options["heights"] = first.heights if first else "gaussian"
    # Where both are handed over, the walk's slopes may be others than the surface's own.
    scene = handed.get("simulate", first).scene if first else common.scene_from(options)
    check_pair(handed, runs)
    free_paths = common.free_paths_from(options, options["heights"])
    report = Report("compare", scene.slug(), options, tuple(map(Path, runs)))
    resolution = prepare(scene, options, handed, report)
    with report.draft() as draft:
        work = scene, resolution, free_paths, options
        handed_run = handed.get("simulate")
        simulated, of_surfaces = (handed_run, []) if handed_run else simulated_run(draft, *work)
        models = modelled(draft, scene, free_paths, options, handed)
        walk_on = scene if "walk" not in handed else handed["walk"].scene
        rows, of_both = write(report, draft, simulated, models, walk_on)
        do_all([*of_surfaces, *of_both], options["threads"])

    report.end(lambda: compare_words.show_rows(rows))


def take_runs(names: tuple[str, ...], options: dict[str, Any]) -> dict[str, Any]:
    """The runs handed over, by kind, with their scene put into `options`.

    Raises click.UsageError where a scene is given beside them, and click.ClickException for what
    is no report of a run.
    """
    from msbsdf_cli.cli.own_surface import OF_RANDOM
    from msbsdf_cli.cli.runs import read_run

    handed: dict[str, Any] = {}
    for name in names:
        record, run = read_run(Path(name))
        if run.kind in handed:
            raise click.ClickException(
                f"both reports are of `{run.kind}`; one of `simulate` and one of `walk` "
                "are compared."
            )
        handed[run.kind] = run
        if run.kind == "simulate":
            # What remembers a surface remembers that on which light was traced.
            options["autocorrelation"] = record["options"].get("autocorrelation", "gaussian")
        source = click.get_current_context().get_parameter_source
        for option in OF_RANDOM if run.kind == "simulate" else ():
            if source(option.replace("-", "_")) is click.core.ParameterSource.COMMANDLINE:
                raise click.UsageError(f"--{option} beside {name}: its surfaces are there already.")
        for option in SCENE:
            if source(option) is click.core.ParameterSource.COMMANDLINE:
                raise click.UsageError(
                    f"--{option.replace('_', '-')} beside a report: the scene is that of {name}."
                )
            options[option] = record["options"].get(option)
        options |= {"theta": run.scene.theta, "alpha": run.scene.alpha}
        options |= {"free_path_theta": run.free_paths.theta}
        options |= {"free_path_height": run.free_paths.starts}
    return handed


SCENE = tuple(
    VARIANTS.get(name, name).replace("-", "_")
    for name in (*MODEL_OF_SURFACES, "orders", *FREE_PATH)
)
"""Options that a report decides."""


def check_pair(handed: dict[str, Any], names: tuple[str, ...]) -> None:
    """Refuse runs of different scenes, or of what no surface is. Where the surface has slopes of
    its own, any may be held against them.

    Raises click.ClickException.
    """
    surface = handed.get("simulate")
    own = surface is not None and surface.scene.slopes.name == OF_SURFACE
    if len(handed) == 2:
        a, b = (in_words(run.scene) for run in handed.values())
        for key in (k for k in a if a[k] != b.get(k) and not (own and k.startswith("slopes"))):
            raise click.ClickException(
                f"the reports are of different scenes: {key} is {a[key]} in {names[0]} "
                f"and {b.get(key)} in {names[1]}."
            )
    for name, run in zip(names, handed.values(), strict=True):
        if run.heights != (wanted := surface.heights if surface else "gaussian"):
            again = "make it again without --heights"
            raise click.ClickException(
                f"the heights of {name} are {run.heights}, those of a surface {wanted}; "
                f"{again if wanted == 'gaussian' else 'leave it out, and a walk is made'}."
            )
        if run.scene.slopes.name != "beckmann" and not own:
            raise click.ClickException(
                f"the slopes of {name} are {run.scene.slopes.name}, those of a surface beckmann."
            )


def in_words(scene: Any) -> dict[str, Any]:
    """The settings of a scene, those of its material and slopes by name."""
    settings = scene.settings()
    parts = {name: settings.pop(name) for name in ("material", "slopes")}
    for part, values in parts.items():
        name = {part: values.pop("name")}
        settings = name | {f"{part} {key}": value for key, value in values.items()} | settings
    return settings


def prepare(scene: Any, options: dict[str, Any], handed: dict[str, Any], report: Any) -> Any:
    """The resolution of what is to be simulated, warnings of what takes long, and refusals."""
    from msbsdf_cli.cli import common, simulate, walk
    from msbsdf_cli.cli.meshes import refuse_mesh
    from msbsdf_cli.experiments.resolution import LEAST_RAYS

    refuse_mesh(options)
    common.check_memory(scene, options)
    warnings, efforts, resolution = [], [], None
    if "simulate" not in handed:
        resolution = simulate.resolve(scene, options)
        warnings += simulate.surface_warnings(options)
        efforts.append(simulate.effort(scene, options))
    options["samples"] = options["samples"] or LEAST_RAYS
    if options["method"] is not None:
        if "walk" in handed:
            raise click.UsageError("--method replaces the walk; leave out its report, or --method.")
        options["method"] = common.methods_for(scene, options["method"])
        warnings += common.method_warnings([scene], options["method"])
        efforts.append(effort_of_methods(scene, options))
    elif "walk" in handed and options["memory"]:
        raise click.UsageError("--memory replaces the walk; leave out its report, or --memory.")
    elif "walk" not in handed:
        warnings += common.facet_warnings(scene)
        efforts.append(walk.effort(scene, options))
    work = " and ".join(words for _, words in efforts)
    warnings += common.long_warnings(options, sum(seconds for seconds, _ in efforts), work)
    report.warn(warnings + common.scene_warnings(options))
    return resolution


def effort_of_methods(scene: Any, options: dict[str, Any]) -> tuple[float, str]:
    """About how many seconds one core needs for lobes of methods in the bins of a simulation."""
    from msbsdf_cli.cli.common import EVALUATIONS_PER_S
    from msbsdf_cli.experiments.method_lobes import SAMPLES_OF_RAYS, bins, places
    from msbsdf_cli.experiments.pilot import pilot

    directions = bins(scene.material.transmits, places(scene))[0].shape[1]
    methods = len(options["method"])
    walks = options["samples"] * SAMPLES_OF_RAYS * len(scene.theta) * methods
    seconds = walks * directions * max(pilot(scene)[1], 1) / EVALUATIONS_PER_S
    return seconds, f"{methods} methods in all bins"


def simulated_run(
    draft: Path, scene: Any, resolution: Any, free_paths: Any, options: dict[str, Any]
) -> tuple[Any, Pictures]:
    """Simulate; the report goes into `draft`, and what draws the surface comes back: the light is
    in the pictures of the comparison."""
    from msbsdf_cli.cli import simulate
    from msbsdf_cli.cli.runs import write_part

    run = simulate.run(scene, resolution, free_paths, options)
    write_part(draft, run, options)
    return run, [simulate.draw(draft / "simulate", scene, resolution, options)]


def modelled(
    draft: Path, scene: Any, free_paths: Any, options: dict[str, Any], handed: dict[str, Any]
) -> list[Any]:
    """Light of the walk, or of the methods wanted; the report of a walk made goes into `draft`."""
    from msbsdf_cli.cli import walk
    from msbsdf_cli.cli.runs import write_part

    if options["method"] is not None:
        from msbsdf_cli.experiments.method_lobes import method_lobes

        names = ("samples", "seed", "threads", "precision", "quiet", "autocorrelation")
        return method_lobes(scene, options["method"], *(options[name] for name in names))
    if "walk" in handed:
        return [handed["walk"].lobes()]
    return [write_part(draft, walk.run(scene, free_paths, options), options)[0]]


def write(
    report: Any, draft: Path, run: Any, models: list[Any], walk_on: Any
) -> tuple[list[Any], Pictures]:
    """Compare, and write the report into `draft`; the rows of agreement.csv, and what draws. The
    scene `walk_on` is that of the models."""
    from msbsdf_cli.cli import compare_words
    from msbsdf_cli.cli.runs import summary
    from msbsdf_cli.experiments.compare import Row, agreement
    from msbsdf_cli.plots.free_path import draw_free_paths
    from msbsdf_cli.plots.lobes import draw_methods
    from msbsdf_cli.results.files import columns

    simulated, rows, sentences = run.lobes(), [], []
    pictures: Pictures = []
    for model in models:
        mine = agreement(simulated, model)
        rows += mine
        sentences.append(compare_words.in_one_sentence(mine))
        place = draft if report.options["method"] is None else draft / model.label
        pictures += pictures_of_pair(place, mine, simulated, model)
        if model.free_paths is not None:
            pair = simulated.free_paths, model.free_paths
            pictures.append(partial(draw_free_paths, draft / "free_path.png", *pair))
    if report.options["method"] is not None:
        write_methods(draft, models, report.options)
        pictures.append(partial(draw_methods, simulated, models, draft))
    if run.scene.slopes.name == OF_SURFACE:
        sentences.append(compare_words.whose_slopes(run.scene, walk_on))
    table = columns(rows, (f.name for f in fields(Row)))
    figures = run.paths, run.bounces_mean, run.wall_s
    more = {"energies": summary(run), **run.notes, "summary": "\n".join(sentences)}
    report.write(draft, {"agreement.csv": table}, *figures, more)
    return rows, pictures


def pictures_of_pair(place: Path, rows: list[Any], simulated: Any, model: Any) -> Pictures:
    """What draws simulated light and a model's side by side."""
    from msbsdf_cli.plots.agreement import draw_agreement
    from msbsdf_cli.plots.lobes import lobe_comparison

    place.mkdir(exist_ok=True)
    agreement = partial(draw_agreement, rows, place / "agreement.png")
    return [agreement, *lobe_comparison(simulated, model, place)]


def write_methods(draft: Path, models: list[Any], options: dict[str, Any]) -> None:
    """A directory for each method: its energies and lobes in the bins of the simulation."""
    from msbsdf_cli.results.files import write_csv, write_json
    from msbsdf_cli.results.seal import RUN
    from msbsdf_cli.results.tables import energy, lobe

    for model in models:
        place = draft / model.label
        write_csv(place / "energy.csv", energy(model))
        write_csv(place / "lobe.csv", lobe(model))
        what = {"command": "evaluate", "options": options | {"method": [model.label]}}
        write_json(place / RUN, what)
