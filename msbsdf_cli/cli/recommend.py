"""`msbsdf recommend`"""

import math
from dataclasses import fields
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import click

from msbsdf_cli.cli.help import Page
from msbsdf_cli.cli.options import REPORT, samples, use
from msbsdf_cli.cli.types import Real
from msbsdf_cli.experiments.render.scenes import NAMES as SCENES
from msbsdf_cli.results.files import columns


@click.command("recommend", cls=Page)
@click.argument("scene", required=False, metavar="[SCENE]", type=click.Path(dir_okay=False))
@click.option(
    "--against",
    type=click.Choice(["smith", "surfaces"]),
    default="smith",
    show_default=True,
    help="What errors are against: the Smith model of all bounces, or traced surfaces (Beckmann).",
)
@click.option(
    "--tolerance",
    type=Real(lambda t: 0 < t < 1, "a tolerance: a number between 0 and 1"),
    metavar="T",
    help="Largest error of directional albedo and lobe, over the light that a surface returns; "
    "default: that of the scene's file, or 0.01.",
)
@click.option(
    "--colour-tolerance",
    type=Real(lambda t: t > 0, "a colour difference: a number above 0"),
    default="1",
    show_default=True,
    metavar="DE",
    help="Largest colour difference of surfaces in red, green and blue, CIEDE2000; 1 is just "
    "noticeable.",
)
@samples("1e6")
@use("seed", "threads", *REPORT)
def command(**options: Any) -> None:
    """The cheapest model that each surface of a scene needs; without a scene, a sheet for all.

    SCENE is a scene of `render` (plate, furnace, sphere, bottle or slab), whose picture is judged
    too; or a TOML file with a [[surface]] for each: name, material, slopes, alpha (a number, or a
    range [LOW, HIGH] where it is textured) or alpha_x and alpha_y, metal, eta_k, albedo or ior,
    theta (angles that matter, radians or "60deg"), weight; at its top may stand a tolerance, and
    `roughness = "perceptual"`, which says that alpha is its square. Or it is a Mitsuba 3 scene, in
    a file that ends in .xml. --samples is for light traced on surfaces.
    """
    if options["scene"] is None:
        write_sheet(options)
        return
    from msbsdf_cli.cli.recommend_words import picture_sentence, sentence
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.experiments.recommend.choice import Wanted
    from msbsdf_cli.experiments.recommend.rendered import picture_errors, scene_of
    from msbsdf_cli.experiments.recommend.scene_file import read_scene
    from msbsdf_cli.experiments.recommend.scene_surface import SceneFileError
    from msbsdf_cli.plots.recommendation import draw_recommendations
    from msbsdf_cli.run.executors import do_all

    rendered = options["scene"] in SCENES
    if not (rendered or Path(options["scene"]).exists()):
        raise click.BadParameter(
            f"{options['scene']} is no file, and none of the scenes {', '.join(SCENES)}.",
            param_hint="SCENE",
        )
    try:
        content = scene_of(options["scene"]) if rendered else read_scene(options["scene"])
    except SceneFileError as error:
        raise click.BadParameter(f"{error}", param_hint="SCENE") from None
    options["tolerance"] = options["tolerance"] or content.tolerance or TOLERANCE
    wanted = Wanted(options["tolerance"], options["colour_tolerance"])
    report = Report("recommend", _slug(options["scene"]), options)
    report.warn([f"{name} is not judged: {reason}." for name, reason in content.left_out])
    report.warn(content.notes)
    report.warn(time_warnings(content.surfaces, wanted, options))
    if not content.surfaces:
        raise click.ClickException(f"{options['scene']} has no surface that can be judged.")
    with report.draft() as draft:
        found = judge(content.surfaces, wanted, options)
        sentences = [sentence(r, wanted) for r in found]
        report.warn([s for s, r in zip(sentences, found, strict=True) if r.chosen is None])
        if all(r.chosen is None for r in found):
            raise click.ClickException(f"{options['scene']} has no surface that can be judged.")
        tables = {"recommendation.csv": columns(rows(found, wanted), COLUMNS)}
        if rendered:
            how = options["seed"], options["threads"], options["quiet"]
            pictures = picture_errors(content.surfaces[0], *how)
            sentences.append(picture_sentence(pictures))
            tables["picture.csv"] = columns(pictures, ("surface", "method", "error", "error_bound"))
        report.write(draft, tables, 0, more={"summary": sentences})
        drawn = found, wanted, options["against"], draft / "recommendation.png"
        do_all([partial(draw_recommendations, *drawn)], options["threads"])
    report.end()


TOLERANCE = 0.01
"""Where neither the command line nor the scene says one."""


def judge(surfaces: list[Any], wanted: Any, options: dict[str, Any]) -> list[Any]:
    """What each surface needs, against what the user wants."""
    from msbsdf_cli.experiments.recommend.choice import recommend, recommend_by_surfaces

    how = options["seed"], options["threads"], options["quiet"]
    if options["against"] == "smith":
        return recommend(surfaces, wanted, *how)
    return recommend_by_surfaces(surfaces, wanted, options["samples"], *how)


def write_sheet(options: dict[str, Any]) -> None:
    """The report without a scene: bounces that each roughness and angle needs."""
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.experiments.recommend.sheet import Entry, sheet
    from msbsdf_cli.plots.sheet import draw_sheet
    from msbsdf_cli.results.files import columns

    report = Report("recommend", "sheet", options)
    given = click.get_current_context().get_parameter_source
    report.warn(
        [
            f"--{name.replace('_', '-')} has no effect without a SCENE: the sheet is one for all."
            for name in ("against", "tolerance", "colour_tolerance", "samples", "seed")
            if given(name) is click.core.ParameterSource.COMMANDLINE
        ]
    )
    with report.draft() as draft:
        entries = sheet(options["threads"], options["quiet"])
        table = columns(entries, (f.name for f in fields(Entry)))
        report.write(draft, {"sheet.csv": table}, 0, more={"summary": of_sheet(entries)})
        draw_sheet(entries, draft / "sheet.png")
    report.end(lambda: show_sheet(entries))


def of_sheet(entries: list[Any]) -> str:
    """How often a single bounce is enough, and where most are needed, at the middle tolerance."""
    from msbsdf_cli.cli.recommend_words import percent
    from msbsdf_cli.scene import in_degrees

    tolerances = sorted({e.tolerance for e in entries})
    mine = [e for e in entries if e.tolerance == tolerances[len(tolerances) // 2]]
    once = sum(e.bounces == 1 for e in mine)
    most = max(mine, key=lambda e: e.bounces)
    return (
        f"Within {percent(most.tolerance)} one bounce is enough in {once} of {len(mine)} cases; "
        f"{most.material} of {most.slopes} slopes at alpha {most.alpha:.3g} and theta "
        f"{in_degrees(most.theta_i_rad)} needs most, {most.bounces} bounces."
    )


def show_sheet(entries: list[Any]) -> None:
    """Print the most bounces that any roughness and angle of a kind needs."""
    from msbsdf_cli.cli.recommend_words import percent
    from msbsdf_cli.cli.terminal import show_table

    tolerances = list(dict.fromkeys(e.tolerance for e in entries))
    most: dict[tuple[str, str], list[int]] = {}
    for e in entries:
        row = most.setdefault((e.material, e.slopes), [0] * len(tolerances))
        k = tolerances.index(e.tolerance)
        row[k] = max(row[k], e.bounces)
    click.echo("The most bounces that any roughness and angle needs:")
    lines = [(*kind, *map(str, row)) for kind, row in most.items()]
    show_table(("material", "slopes", *(percent(t) for t in tolerances)), lines, "sheet.csv")


def time_warnings(surfaces: list[Any], wanted: Any, options: dict[str, Any]) -> list[str]:
    """A sentence where the surfaces of a scene take long."""
    from msbsdf_cli.cli.common import LONG_S, duration
    from msbsdf_cli.experiments.recommend import surfaces as explicit

    threads, reason = options["threads"], "smooth surfaces and those of two roughnesses take long"
    if options["against"] == "smith":
        each = {s.name: seconds_of(s, wanted, LONG_S / len(surfaces)) for s in surfaces}
        expected = max(sum(each.values()) / threads, max(each.values(), default=0))
    else:
        each = {s.name: explicit.seconds(s, options["samples"]) for s in surfaces}
        expected, reason = sum(each.values()) / threads, "fewer --samples take less"
    if expected < LONG_S:
        return []
    longest = max(each, key=lambda name: each[name])
    about = f"this will take about {duration(expected)}, most of it for {longest}"
    return [f"{about}; {reason}, at each angle, roughness and channel."]


def seconds_of(surface: Any, wanted: Any, long: float) -> float:
    """About how many seconds of one core a surface takes; where that is `long`, it is asked whether
    the bound of single scattering ends it at once."""
    from msbsdf_cli.experiments.recommend import candidates

    found = candidates.seconds(surface)
    if found < long:
        return found
    bound = candidates.single_bound(surface, wanted.scale).bound
    return 0.0 if bound <= wanted.tolerance else found


def _slug(scene: str) -> str:
    return "".join(c if c.isalnum() else "-" for c in Path(scene).stem) or "scene"


COLUMNS = (
    *("surface", "material", "slopes", "alpha_x", "alpha_y", "method", "orders", "error"),
    *("error_bound", "cost_ns", "meets_tolerance", "chosen", "verdict", "weight", "facets"),
    *("albedo_error", "lobe_error", "colour_difference", "theta_i_rad", "phi_i_rad"),
    *("perceptual_x", "perceptual_y"),
)


def rows(found: list[Any], wanted: Any) -> list[Any]:
    """The lines of recommendation.csv."""
    from msbsdf_cli.experiments.recommend.cost import costs_ns

    lines = []
    for r in found:
        costs = costs_ns(r.surface, r.candidates)
        for c, verdict, cost in zip(r.candidates, r.verdicts, costs, strict=True):
            alpha = c.place.alpha
            what = r.surface.name, r.surface.material.name, r.surface.slopes[0].name, *alpha
            judged = c.method, c.bounces or "all", c.error, c.bound, cost
            marks = c.bound <= wanted.tolerance, c is r.chosen, verdict
            parts = c.albedo, c.lobe, c.colour, c.place.theta, c.place.phi
            more = r.surface.weight, c.facets, *parts, *map(math.sqrt, alpha)
            values = (*what, *judged, *marks, *more)
            lines.append(SimpleNamespace(**dict(zip(COLUMNS, values, strict=True))))
    return lines
