"""`msbsdf evaluate`"""

from dataclasses import fields
from functools import partial
from typing import Any

import click

from msbsdf_cli.cli.help import Page
from msbsdf_cli.cli.options import MODEL_IN_COLOUR, REPORT, samples, use


@click.command("evaluate", cls=Page)
@use("method", "bidirectional", "remembered", *MODEL_IN_COLOUR, "phi-o", "points", "orders")
@samples("1e5")
@use("seed", "threads", "precision", *REPORT)
def command(**options: Any) -> None:
    """Evaluate the BSDF along a slice of directions, by any method.

    Writes BSDF x cos(theta_o) of each method, order by order and in total, with standard errors,
    a picture, and how far each is from the most trustworthy of them, which is solve where that is
    named. Without --method: all methods that hold for the material.
    """
    from msbsdf_cli.cli import common
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.experiments.evaluate import evaluate
    from msbsdf_cli.experiments.pilot import pilot
    from msbsdf_cli.experiments.slice_errors import SliceError, slice_errors
    from msbsdf_cli.experiments.slices import slice_directions, slice_table
    from msbsdf_cli.plots.slices import draw_slices
    from msbsdf_cli.results.files import Table, columns
    from msbsdf_cli.run.executors import do_all

    scene = common.scene_from(options)
    options["method"] = methods = common.methods_for(scene, options["method"])
    report = Report("evaluate", scene.slug(), options)
    walks = options["samples"] * len(options["theta"]) * len(methods)
    facets = pilot(scene)[1]
    work_s = walks * options["points"] * max(facets, 1) / common.EVALUATIONS_PER_S
    walking = (
        f"{walks:.2g} walks of {facets:.2g} facets in the mean to {options['points']} directions"
    )
    report.warn(common.scene_warnings(options) + without_effect(options))
    report.warn(common.not_remembered(options))
    report.warn(common.method_warnings([scene], methods))
    report.warn(common.long_warnings(options, work_s, walking))
    directions = slice_directions(scene, options["phi_o"], options["points"])
    with report.draft() as draft:
        work = scene, methods, directions.wo, options["samples"]
        both_ends = options["bidirectional"]
        arithmetic = options["seed"], options["threads"], options["precision"], options["quiet"]
        of = options["autocorrelation"]
        values = evaluate(*work, *arithmetic, bidirectional=both_ends, autocorrelation=of)
        report.warn(hardly_known(values) + dark_slices(values))
        table = slice_table(scene, directions, values)
        errors = slice_errors(values, scene.phi)
        tables: dict[str, Table] = {"slice.csv": table}
        if errors:
            tables["errors.csv"] = columns(errors, (f.name for f in fields(SliceError)))
        went = [how_it_went(v) for v in values]
        more = {"summary": in_one_sentence(values, errors), "methods": went}
        report.write(draft, tables, walks, more=more)
        do_all([partial(draw_slices, table, draft / "slice.png")], options["threads"])
    report.end(lambda: show_errors(errors) if errors else show(values))


def without_effect(options: dict[str, Any]) -> list[str]:
    """A sentence on --bidirectional where no method takes it."""
    from msbsdf_cli.methods.position_free import PositionFree
    from msbsdf_cli.methods.registry import METHODS

    takes = any(issubclass(METHODS[name], PositionFree) for name in options["method"])
    if takes or not options["bidirectional"]:
        return []
    return ["--bidirectional has no effect: it is for the position-free methods."]


def how_it_went(values: Any) -> dict[str, Any]:
    """What run.json says of a method at an angle of incidence."""
    return {
        "method": values.method,
        "theta_i_rad": values.theta,
        "unresolved": values.unresolved,
        "seconds": values.seconds,
    }


def hardly_known(values: list[Any]) -> list[str]:
    """Sentences on where `solve` states a large error of the sum over orders."""
    from msbsdf_cli.methods.solve import VALUE_KNOWN, Solve
    from msbsdf_cli.scene import in_degrees

    errors = (
        (v.theta, v.stderr[:, -1].max() / v.value[:, -1].max())
        for v in values
        if v.method == Solve.name and v.value[:, -1].max() > 0
    )
    return [
        f"method solve knows values at theta {in_degrees(theta)} to {error:.1g} of the largest "
        "only."
        for theta, error in errors
        if error > VALUE_KNOWN
    ]


def dark_slices(values: list[Any]) -> list[str]:
    """Sentences on slices that hardly any light goes to, by the method that others are held
    against; without one, by the first."""
    from msbsdf_cli.experiments.slice_errors import dark
    from msbsdf_cli.methods.registry import most_trusted
    from msbsdf_cli.scene import in_degrees

    against = most_trusted(v.method for v in values) or values[0].method
    mine = (v for v in values if v.method == against)
    return [
        f"light of theta {in_degrees(v.theta)} goes between the directions of the slice: what goes "
        "to them is less than its noise; more --points would have one where the light is."
        for v in mine
        if any(dark(v, c) for c in range(len(v.value)))
    ]


def in_one_sentence(values: list[Any], errors: list[Any]) -> str:
    """How wrong each method is, from the angle and channel where it is least so to where most; of
    one alone how bright it is."""
    from msbsdf_cli.cli.terminal import in_percent, measured
    from msbsdf_cli.scene import in_degrees

    if not errors:
        v, value, stderr = max((_largest(v) for v in values), key=lambda found: found[1])
        return (
            f"BSDF x cos(theta_o) is at most {measured(value, stderr)} a steradian, by {v.method} "
            f"at theta {in_degrees(v.theta)}; with another method beside it, such as solve, this "
            "says how wrong one is."
        )
    parts = []
    for method in dict.fromkeys(e.method for e in errors):
        mine = sorted((e for e in errors if e.method == method), key=lambda e: e.error)
        said = [
            f"{in_percent(max(e.error, 0), e.stderr)} (theta {in_degrees(e.theta_i_rad)}"
            f"{e.channel and f', {e.channel}'})"
            for e in dict.fromkeys((mine[0], mine[-1]))
        ]
        parts.append(f"{method} by {' to '.join(said)}")
    return f"Against {errors[0].against}, of the light along the slice: {'; '.join(parts)}."


def show_errors(errors: list[Any]) -> None:
    """Print a line for each angle and method, the errors of all channels side by side."""
    from msbsdf_cli.cli.terminal import in_percent, show_table
    from msbsdf_cli.scene import in_degrees

    channels = list(dict.fromkeys(e.channel for e in errors))
    rows: dict[tuple[str, str], list[str]] = {}
    for e in errors:
        place = in_degrees(e.theta_i_rad), e.method
        rows.setdefault(place, []).append(in_percent(max(e.error, 0), e.stderr))
    header = ("theta", "method", *(f"error {channel}".rstrip() for channel in channels))
    show_table(header, [(*place, *cells) for place, cells in rows.items()], "errors.csv")


def _largest(values: Any) -> tuple[Any, float, float]:
    """The largest total and its standard error."""
    total, stderr = values.value[0, -1], values.stderr[0, -1]
    top = int(total.argmax())
    return values, float(total[top]), float(stderr[top])


def show(values: list[Any]) -> None:
    """Print the largest total of each method and its standard error, and the time it took."""
    from msbsdf_cli.cli.terminal import measured, show_table
    from msbsdf_cli.scene import in_degrees

    lines = [
        (in_degrees(v.theta), v.method, measured(value, stderr), f"{v.seconds:.2f}")
        for v, value, stderr in map(_largest, values)
    ]
    show_table(("theta", "method", "largest value [1/sr]", "seconds"), lines, "slice.csv")
