"""`msbsdf recommend`"""

import math
from dataclasses import fields
from typing import Any

import click

from msbsdf_cli.cli.options import REPORT, Real, use


@click.command("recommend")
@click.argument("scene", required=False, metavar="[SCENE]", type=click.Path(dir_okay=False))
@click.option(
    "--tolerance",
    type=Real(lambda t: 0 < t < 1, "a tolerance: a number between 0 and 1"),
    default="0.01",
    show_default=True,
    metavar="T",
    help="Largest error of directional albedo and lobe, over the light that a surface returns.",
)
@use("threads", *REPORT)
def command(**options: Any) -> None:
    """The cheapest model that each surface of a scene needs; without a scene, a sheet for all.

    SCENE is a TOML file with a [[surface]] for each: name, material, slopes, alpha (a number, or a
    range [LOW, HIGH] where it is textured) or alpha_x and alpha_y, metal, eta_k, albedo or ior,
    angles_deg that matter, weight. `roughness = "perceptual"` at its top says that alpha is its
    square. Or it is a Mitsuba 3 scene, in a file that ends in .xml. Errors are against the Smith
    model of all bounces.
    """
    if options["scene"] is None:
        write_sheet(options)
        return
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.experiments.recommend.choice import recommend
    from msbsdf_cli.experiments.recommend.scene_file import SceneFileError, read_scene
    from msbsdf_cli.plots.recommendation import draw_recommendations

    try:
        content = read_scene(options["scene"])
    except SceneFileError as error:
        raise click.BadParameter(f"{error}", param_hint="SCENE") from None
    report = Report("recommend", _slug(options["scene"]), options)
    report.warn([f"{name} is not judged: {reason}." for name, reason in content.left_out])
    report.warn(time_warnings(content.surfaces, options["threads"]))
    if not content.surfaces:
        raise click.ClickException(f"{options['scene']} has no surface that can be judged.")
    with report.draft() as draft:
        settings = (options[name] for name in ("tolerance", "threads", "quiet"))
        found = recommend(content.surfaces, *settings)
        sentences = [sentence(r, options["tolerance"]) for r in found]
        report.warn([s for s, r in zip(sentences, found, strict=True) if r.chosen is None])
        table = rows(found)
        report.write(draft, {"recommendation.csv": table}, 0, more={"summary": sentences})
        draw_recommendations(found, options["tolerance"], draft / "recommendation.png")
    report.end(lambda: click.echo("\n".join(sentences)))


def write_sheet(options: dict[str, Any]) -> None:
    """The report without a scene: bounces that each roughness and angle needs."""
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.experiments.recommend.sheet import Entry, sheet
    from msbsdf_cli.plots.sheet import draw_sheet
    from msbsdf_cli.results.files import columns

    report = Report("recommend", "sheet", options)
    with report.draft() as draft:
        entries = sheet(options["threads"], options["quiet"])
        table = columns(entries, (f.name for f in fields(Entry)))
        report.write(draft, {"sheet.csv": table}, 0)
        draw_sheet(entries, draft / "sheet.png")
    report.end(lambda: show_sheet(entries))


def show_sheet(entries: list[Any]) -> None:
    """Print the most bounces that any roughness and angle of a kind needs."""
    from msbsdf_cli.cli.terminal import show_table

    tolerances = list(dict.fromkeys(e.tolerance for e in entries))
    most: dict[tuple[str, str], list[int]] = {}
    for e in entries:
        row = most.setdefault((e.material, e.slopes), [0] * len(tolerances))
        k = tolerances.index(e.tolerance)
        row[k] = max(row[k], e.bounces)
    click.echo("The most bounces that any roughness and angle needs:")
    lines = [(*kind, *map(str, row)) for kind, row in most.items()]
    show_table(("material", "slopes", *(_percent(t) for t in tolerances)), lines)


def time_warnings(surfaces: list[Any], threads: int) -> list[str]:
    """A sentence where the surfaces of a scene take long."""
    from msbsdf_cli.cli.common import LONG_S, duration
    from msbsdf_cli.experiments.recommend.candidates import seconds

    each = {surface.name: seconds(surface) for surface in surfaces}
    expected = max(sum(each.values()) / threads, max(each.values(), default=0))
    if expected < LONG_S:
        return []
    longest = max(each, key=lambda name: each[name])
    return [
        f"this will take about {duration(expected)}, most of it for {longest}; smooth surfaces and "
        "those of two roughnesses take `solve` long, at each angle and roughness."
    ]


def _slug(scene: str) -> str:
    from pathlib import Path

    return "".join(c if c.isalnum() else "-" for c in Path(scene).stem) or "scene"


def rows(found: list[Any]) -> dict[str, list[Any]]:
    """recommendation.csv"""
    table: dict[str, list[Any]] = {name: [] for name in COLUMNS}
    for r in found:
        for c, verdict in zip(r.candidates, r.verdicts, strict=True):
            what = (r.surface.name, r.surface.weight, c.method, c.bounces or "all")
            figures = (c.facets, c.error, c.uncertainty, c.theta, *c.alpha)
            for column, value in zip(table.values(), (*what, *figures, verdict), strict=True):
                column.append(value)
    return table


COLUMNS = (
    "surface",
    "weight",
    "method",
    "bounces",
    "facets",
    "error",
    "error_uncertainty",
    "theta_i_rad",
    "alpha_x",
    "alpha_y",
    "verdict",
)


def sentence(found: Any, tolerance: float) -> str:
    """What a surface needs, in words."""
    name, chosen = found.surface.name, found.chosen
    if not found.candidates:
        return f"{name}: cannot be judged, because {found.reason}."
    if chosen is None:
        return f"{name}: no model is known to be within {_percent(tolerance)}."
    pairs = zip(found.candidates, found.verdicts, strict=True)
    close = [model(c) for c, verdict in pairs if verdict == "close"]
    text = f"{name} ({roughness(found.surface)}): {model(chosen)}"
    text += " is enough" if chosen.bounces == 1 else ""
    if chosen.error > 0:
        # Where single scattering's bound was enough, nothing else was worked out.
        most = "at most " if len(found.candidates) == 1 else ""
        text += f", {most}{_percent(chosen.error)} at {math.degrees(chosen.theta):.0f} degrees"
    return text + (f"; too close to call: {', '.join(close)}." if close else ".")


def model(candidate: Any) -> str:
    """A candidate in words."""
    if candidate.bounces == 1:
        return "single scattering"
    if candidate.method in ("turquin", "energy-compensated"):
        return f"{candidate.method}"
    if candidate.bounces == 0:
        return f"all bounces of {candidate.method}"
    return f"{candidate.bounces} bounces of {candidate.method}"


def roughness(surface: Any) -> str:
    """Alpha, and what renderers that square it call roughness."""
    ends = surface.slopes[0], surface.slopes[-1]
    pairs = dict.fromkeys((s.alpha_x, s.alpha_y) for s in ends)
    alphas = list(dict.fromkeys(a for pair in pairs for a in pair))
    joined = " to " if len(pairs) > 1 else ", "
    perceptual = joined.join(f"{math.sqrt(a):.3g}" for a in alphas)
    return f"alpha {joined.join(f'{a:.3g}' for a in alphas)}, perceptual {perceptual}"


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %"
