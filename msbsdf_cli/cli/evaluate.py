"""`msbsdf evaluate`"""

from typing import Any

import click

from msbsdf_cli.cli.options import MODEL_IN_COLOUR, REPORT, samples, use


@click.command("evaluate")
@use("method", "bidirectional", *MODEL_IN_COLOUR, "phi-o", "points", "orders")
@samples("1e5")
@use("seed", "threads", "precision", *REPORT)
def command(**options: Any) -> None:
    """Evaluate the BSDF along a slice of directions, by any method.

    Writes BSDF x cos(theta_o) of each method, order by order and in total, with standard errors,
    and a picture. Without --method: all methods that hold for the material.
    """
    from msbsdf_cli.cli import common
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.experiments.evaluate import evaluate
    from msbsdf_cli.experiments.pilot import pilot
    from msbsdf_cli.experiments.slices import slice_directions, slice_table
    from msbsdf_cli.plots.slices import draw_slices

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
    report.warn(common.method_warnings([scene], methods))
    report.warn(common.long_warnings(options, work_s, walking))
    directions = slice_directions(scene, options["phi_o"], options["points"])
    with report.draft() as draft:
        work = scene, methods, directions.wo, options["samples"]
        both_ends = options["bidirectional"]
        arithmetic = options["seed"], options["threads"], options["precision"], options["quiet"]
        values = evaluate(*work, *arithmetic, bidirectional=both_ends)
        report.warn(hardly_known(values))
        table = slice_table(scene, directions, values)
        more = {"methods": [how_it_went(v) for v in values]}
        report.write(draft, {"slice.csv": table}, walks, more=more)
        draw_slices(table, draft / "slice.png")
    report.end(lambda: show(values))


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

    errors = (
        (v.theta, v.stderr[:, -1].max() / v.value[:, -1].max())
        for v in values
        if v.method == Solve.name and v.value[:, -1].max() > 0
    )
    return [
        f"method solve knows values at theta {theta:.4g} to {error:.1g} of the largest only."
        for theta, error in errors
        if error > VALUE_KNOWN
    ]


def show(values: list[Any]) -> None:
    """Print the largest total of each method and its standard error, and the time it took."""
    from msbsdf_cli.cli.terminal import measured, show_table

    lines = []
    for v in values:
        total, stderr = v.value[0, -1], v.stderr[0, -1]
        top = int(total.argmax())
        lines.append(
            (
                f"{v.theta:.4g}",
                v.method,
                measured(float(total[top]), float(stderr[top])),
                f"{v.unresolved:.2g}",
                f"{v.seconds:.2f}",
            )
        )
    show_table(("theta", "method", "largest value [1/sr]", "unresolved", "seconds"), lines)
