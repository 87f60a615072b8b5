"""`msbsdf furnace`"""

from collections.abc import Iterable
from functools import partial
from typing import Any

import click

from msbsdf_cli.cli.help import Page
from msbsdf_cli.cli.options import MODEL_IN_COLOUR, REPORT, samples, use
from msbsdf_cli.cli.types import Roughness


@click.command("furnace", cls=Page)
@click.option(
    "--alpha",
    type=Roughness(),
    multiple=True,
    default=("0.1", "0.3", "0.6", "1"),
    show_default=True,
    help="Roughness, along x and y; repeat it for several.",
)
@use("method", *(name for name in MODEL_IN_COLOUR if name not in ("alpha", "theta")))
@use("theta-furnace", "orders", "accuracy-of-solve", "remembered")
@samples("4096")
@use("seed", "threads", *REPORT)
def command(**options: Any) -> None:
    """Directional albedo of every method, order by order, over angle and roughness; the white
    sphere.

    Without --method: all methods that hold for the material. A sphere as white as the light around
    it conserves energy.
    """
    from msbsdf_cli.cli import common
    from msbsdf_cli.cli.render import effort
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.experiments.furnace import furnace, furnace_table
    from msbsdf_cli.experiments.white_sphere import PIXELS, SAMPLES, white_spheres
    from msbsdf_cli.methods.solve import Solve
    from msbsdf_cli.plots.furnace import draw_furnace
    from msbsdf_cli.plots.white_sphere import draw_spheres
    from msbsdf_cli.run.executors import do_all

    alphas, accuracy = options["alpha"], options["accuracy"]
    scene = common.scene_from(options | {"alpha": alphas[0]})
    options["method"] = methods = common.methods_for(scene, options["method"])
    report = Report("furnace", f"{scene.material.name}-{scene.slopes.name}", options)
    report.warn(common.scene_warnings(options))
    report.warn(common.method_warnings([scene.of_roughness(alpha) for alpha in alphas], methods))
    points = len(alphas) * len(scene.theta) * len(methods)
    work_s = points * options["samples"] / WALKS_PER_S
    paths = len(methods) * PIXELS**2 * SAMPLES
    of_spheres = options | {"texture": "none"}
    work_s += sum(effort(scene.of_roughness(a), of_spheres, paths)[0] for a in alphas)
    work = f"{len(methods)} methods at {len(alphas)} roughnesses and {len(scene.theta)} angles"
    work += ", and a sphere of each"
    report.warn(common.long_warnings(options, work_s, work))
    report.warn(common.not_remembered(options))
    if accuracy is not None and Solve.name not in methods:
        report.warn(["--accuracy has no effect: it is for --method solve."])
    settings = options["samples"], options["seed"], accuracy, options["threads"], options["quiet"]
    with report.draft() as draft:
        results = furnace(scene, alphas, methods, *settings, options["autocorrelation"])
        known = not_reached(results, accuracy) if accuracy else hardly_known(scene, results)
        report.warn(known)
        of_methods = options["seed"], options["threads"], options["quiet"]
        spheres, refused = white_spheres(scene, alphas, methods, *of_methods)
        report.warn(refused)
        table = furnace_table(scene, results)
        walks = options["samples"] * len(results) * len(scene.theta)
        more = {"summary": in_one_sentence(scene, results)}
        report.write(draft, {"furnace.csv": table}, walks, more=more)
        held = against(scene, methods)
        pictures = [partial(draw_furnace, table, draft / "furnace.png", held)]
        if spheres:
            pictures.append(partial(draw_spheres, spheres, draft / "sphere.png"))
        do_all(pictures, options["threads"])
    report.end(lambda: show(scene, results))


WALKS_PER_S = 2e4
"""Rough rate of one core in walks of `--samples`, of any method."""


def hardly_known(scene: Any, results: list[Any]) -> list[str]:
    """Sentences on where `solve` states a large error of an order's energy."""
    from msbsdf_cli.methods.solve import ENERGY_KNOWN, Solve
    from msbsdf_cli.scene import in_degrees

    errors = (
        (r.alpha, theta, stderr[:, :-1].max())
        for r in results
        if r.method == Solve.name
        for theta, stderr in zip(scene.theta, r.stderr.max(axis=0), strict=True)
    )
    return [
        f"method solve knows the energies of alpha {alpha[0]:g},{alpha[1]:g} at theta "
        f"{in_degrees(theta)} to {error:.1g} only; --accuracy asks for more nodes."
        for alpha, theta, error in errors
        if error > ENERGY_KNOWN
    ]


def not_reached(results: list[Any], accuracy: float) -> list[str]:
    """Sentences on where `solve` does not know an order's energy as well as was wanted."""
    from msbsdf_cli.methods.solve import Solve

    solved = (r for r in results if r.method == Solve.name)
    errors = ((r.alpha, r.stderr[..., :-1].max()) for r in solved)
    return [
        f"method solve reached an error of {error:.2g} at alpha {alpha[0]:g},{alpha[1]:g}, "
        f"not {accuracy:g}."
        for alpha, error in errors
        if error > accuracy
    ]


def against(scene: Any, methods: Iterable[str]) -> str | None:
    """What albedos are held against: 1, or, where facets absorb, the most trustworthy of several
    methods."""
    from msbsdf_cli.methods.registry import most_trusted

    names = tuple(methods)
    # Alone, a method is held against nothing but what came in.
    return most_trusted(names) if scene.material.absorbs and len(names) > 1 else None


def in_one_sentence(scene: Any, results: list[Any]) -> str:
    """Where each method loses most light: of what comes in, or, where facets absorb, of what the
    most trustworthy one sends back."""
    from math import hypot

    import numpy as np

    from msbsdf_cli.cli.terminal import in_percent
    from msbsdf_cli.scene import in_degrees

    trusted = against(scene, (r.method for r in results))
    truth = {r.alpha: r for r in results if r.method == trusted}
    worst: dict[str, tuple[float, float, str]] = {}
    for r in (r for r in results if r.method != trusted):
        value, stderr = r.value[..., -1], r.stderr[..., -1]
        for place in np.ndindex(value.shape):
            whole, doubt = 1.0, 0.0
            if trusted is not None:
                of = truth[r.alpha]
                whole, doubt = float(of.value[place][-1]), float(of.stderr[place][-1])
            lost = 1 - float(value[place]) / whole
            error = hypot(float(stderr[place]), (1 - lost) * doubt) / whole
            alpha = ",".join(f"{a:g}" for a in dict.fromkeys(r.alpha))
            where = f"alpha {alpha}, theta {in_degrees(scene.theta[place[1]])}"
            worst[r.method] = max(worst.get(r.method, (-1.0, 0.0, "")), (lost, error, where))
    of_what = f" of the light that {trusted} sends back" if trusted else ""
    order = sorted(worst, key=lambda name: -worst[name][0])
    parts = [f"{name} {in_percent(*worst[name][:2])} ({worst[name][2]})" for name in order]
    return f"The most that each method loses{of_what}: {'; '.join(parts)}."


def show(scene: Any, results: list[Any]) -> None:
    """Print the albedo of the first channel, a line for each method and roughness."""
    from msbsdf_cli.cli.terminal import measured, show_table
    from msbsdf_cli.scene import in_degrees

    lines = [
        (
            r.method,
            ",".join(f"{a:g}" for a in dict.fromkeys(r.alpha)),
            *(
                measured(float(v[0, -1]), float(e[0, -1]))
                for v, e in zip(r.value[0], r.stderr[0], strict=True)
            ),
        )
        for r in results
    ]
    show_table(("method", "alpha", *map(in_degrees, scene.theta)), lines, "furnace.csv")
