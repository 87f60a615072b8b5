"""`msbsdf compare --surface FILE`"""

from dataclasses import fields, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from msbsdf_cli.cli import own_surface
from msbsdf_cli.smith.slopes import OF_SURFACE

if TYPE_CHECKING:
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.experiments.compare import Row


def check_options(runs: tuple[str, ...], options: dict[str, Any]) -> None:
    """Refuse options that belong to other comparisons. Raises click.UsageError."""
    own_surface.check_options(options)
    if options["surface"] is None:
        check_slopes(options)
    elif runs:
        raise click.UsageError("reports beside --surface: light is traced on the surface itself.")
    elif options["method"] is not None:
        raise click.UsageError("--method beside --surface: its parts are those of the walk.")
    elif options["memory"]:
        raise click.UsageError("--memory beside --surface: it is for Gaussian surfaces.")
    check_memory(options)
    check_gamma(options, _given("gamma"))


def check_slopes(options: dict[str, Any]) -> None:
    """Refuse slopes that random surfaces do not have. Raises click.UsageError."""
    if options["slopes"] != "beckmann" and options["heights_of"] == "gaussian":
        raise click.UsageError(
            f"--slopes {options['slopes']} without --surface: random surfaces are beckmann."
        )


def check_gamma(options: dict[str, Any], given: bool) -> None:
    """Refuse a parameter of other slopes. Raises click.UsageError."""
    if given and options["slopes"] != "student-t":
        raise click.UsageError("--gamma without --slopes student-t: no other slopes have one.")


def check_memory(options: dict[str, Any]) -> None:
    """Refuse methods beside a walk that remembers. Raises click.UsageError."""
    if options["memory"] and options["method"] is not None:
        raise click.UsageError("--memory beside --method: there it is the method walk-memory.")


def _given(option: str) -> bool:
    source = click.get_current_context().get_parameter_source(option)
    return source is click.core.ParameterSource.COMMANDLINE


def compare(options: dict[str, Any]) -> None:
    """Read the surface, describe it, trace and walk on it, and write the report."""
    from msbsdf_cli.cli import common
    from msbsdf_cli.cli.meshes import refuse_mesh
    from msbsdf_cli.cli.runs import write_part
    from msbsdf_cli.experiments.fitted_walks import traced, walks_on
    from msbsdf_cli.experiments.own_surface import simulate_surface
    from msbsdf_cli.experiments.parts import parts
    from msbsdf_cli.experiments.resolution import LEAST_RAYS
    from msbsdf_cli.run.executors import do_all

    place = own_surface.report("compare", options)
    refuse_mesh(options)
    free_paths = common.free_paths_from(options, "gaussian")
    options["samples"] = options["samples"] or LEAST_RAYS
    field = own_surface.read(options)
    own_surface.refuse_size(field, options["threads"])
    about = own_surface.described(field, options)
    models, name = models_from(field.patch.slopes, about, options)
    scene = common.scene_from(options, models[name][0])
    options |= {"slopes": name, "alpha": scene.alpha, "gamma": getattr(scene.slopes, "gamma", None)}
    warn(place, scene, options, [*field.notes, *about.warnings], len(models))
    names = ("seed", "threads", "max_order", "quiet")
    with place.draft() as draft:
        own = replace(scene, slopes=models[OF_SURFACE][0])
        work = own, field, options["samples"], free_paths
        run = simulate_surface(*work, *(options[n] for n in names))
        lobes, pictures = write_part(draft, run, options)
        own_surface.draw(draft, scene, field, options)
        of_walks = ("samples", "seed", "threads", "precision", "max_order", "quiet")
        walks = walks_on(scene, models, *(options[n] for n in of_walks))
        found = parts(scene, traced(lobes, run.paths // len(scene.theta)), walks, name)
        pictures += write(place, draft, run, found, models, about)
        do_all(pictures, options["threads"])

    def show() -> None:
        show_parts(found)
        own_surface.show_roughness(about, field)

    place.end(show)


def models_from(slopes: Any, about: Any, options: dict[str, Any]) -> tuple[Any, str]:
    """Slopes of the surface and distributions fitted to them; the name of the one to be judged,
    which is the one wanted, or the best. Raises click.BadParameter where nothing can be fitted."""
    from msbsdf_cli.experiments.fitted_walks import best_fit, kinds, models_of

    try:
        models = models_of(slopes, kinds(options["gamma"] if _given("gamma") else None))
    except ValueError as error:
        raise click.BadParameter(f"{options['surface']}: {error}", param_hint="--surface") from None
    return models, options["slopes"] if _given("slopes") else best_fit(about)


def warn(
    place: "Report", scene: Any, options: dict[str, Any], sentences: list[str], models: int
) -> None:
    """Say what the surface is like, has no effect, or takes long."""
    from msbsdf_cli.cli import common, walk

    seconds, words = walk.effort(scene, options)
    # On all of the surface, and again on its pieces.
    long = common.long_warnings(options, 2 * models * seconds, f"{2 * models} times {words}")
    place.warn([*common.scene_warnings(options), *sentences, *common.facet_warnings(scene), *long])


def write(place: "Report", draft: Any, run: Any, found: Any, models: Any, about: Any) -> list[Any]:
    """Write the report into `draft`; what draws."""
    from msbsdf_cli.cli.runs import summary
    from msbsdf_cli.experiments.compare import Row
    from msbsdf_cli.plots.parts import draw_parts
    from msbsdf_cli.results.files import columns

    tables = {
        "agreement.csv": columns(found.rows, (f.name for f in fields(Row))),
        "roughness.csv": about.to_columns(),
    }
    more = {"energies": summary(run), **run.notes, "summary": in_one_sentence(found, models)}
    place.write(draft, tables, run.paths, run.bounces_mean, run.wall_s, more)
    return [partial(draw_parts, found.rows, draft / "parts.png")]


def in_one_sentence(found: Any, models: Any) -> str:
    """What a reader would want to know first: each part where it is largest."""
    from msbsdf_cli.experiments.parts import PARTS

    of_slopes, of_heights, of_bounces, whole = map(found.worst, (*PARTS, "whole"))
    text = (
        f"Of the light, {share(of_slopes)} goes elsewhere because the slopes are not those of "
        f"{named(models[found.fitted][0])}, {share(of_heights)} because heights are correlated, "
        f"together {share(whole)}, and {share(of_bounces)} would because single scattering leaves "
        "out later bounces; "
    )
    if found.least is None:
        return text + "no fitted distribution is within the part of correlated heights."
    name, bounces = found.least
    walk = {None: "all bounces of the walk", 1: "one bounce"}
    words = walk.get(bounces, f"{bounces} bounces of the walk")
    return (
        text + "the least model that is within the part of correlated heights is "
        f"{named(models[name][0])} with {words}."
    )


def share(row: "Row") -> str:
    """A share of the light in percent, with its error bar, and where."""
    from math import floor, log10

    from msbsdf_cli.scene import in_degrees

    value, error = 100 * max(row.own, 0), 100 * row.own_stderr
    digits = min(max(-floor(log10(error)), 0), 4) if 0 < error < float("inf") else 3
    return f"{value:.{digits}f} +- {error:.{digits}f} % (theta {in_degrees(row.theta_i_rad)})"


TITLES = {
    "beckmann": "Beckmann",
    "ggx": "GGX",
    "student-t": "Student-T",
    OF_SURFACE: "the slopes of a surface, of roughness",
}


def named(slopes: Any) -> str:
    """A distribution with its roughness, as people say it."""
    alpha = ", ".join(dict.fromkeys(f"{a:.3g}" for a in slopes.alpha))
    gamma = f" (gamma {slopes.gamma:.3g})" if hasattr(slopes, "gamma") else ""
    return f"{TITLES[slopes.name]} {alpha}{gamma}"


def show_parts(found: Any) -> None:
    """Print the parts, and what each model would leave out."""
    from msbsdf_cli.cli.terminal import measured, show_table
    from msbsdf_cli.scene import in_degrees

    lines = [
        (
            r.quantity,
            in_degrees(r.theta_i_rad),
            r.method,
            r.order,
            measured(r.own, r.own_stderr),
            f"{r.z:.1f}",
        )
        for r in found.rows
        if r.side == "all"
    ]
    header = ("quantity", "theta", "slopes", "bounces", "share elsewhere", "z")
    show_table(header, lines, "agreement.csv", len(found.rows))
