"""`msbsdf stability`"""

from typing import Any

import click

from msbsdf_cli.cli.help import Page
from msbsdf_cli.cli.options import REPORT, use

FULL_MINUTES = 20
"""About how long the full map takes on two cores."""


@click.command("stability", cls=Page)
@click.option(
    "--full", is_flag=True, help="Every value, material and slope distribution: some 20 minutes."
)
@click.option(
    "--cell",
    metavar="CELL",
    help="One cell alone, by the name that stability.csv has for it.",
)
@use("method", "seed", "threads", *REPORT)
def command(**options: Any) -> None:
    """Where each method stops working: every parameter driven to its ends, in both precisions.

    A cell works, is degraded, fails or is refused, by a truth that does not come from the method;
    a cell without one is unknown. Without --method: all methods, and the simulation on surfaces.
    A run that is stopped goes on from its last cell when it is called again.
    """
    from msbsdf_cli import __version__
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.experiments.stability.points import points
    from msbsdf_cli.experiments.stability.simulation import METHOD, simulation
    from msbsdf_cli.experiments.stability.study import PRECISIONS, Row, study
    from msbsdf_cli.methods.registry import METHODS
    from msbsdf_cli.plots.stability import draw_stability
    from msbsdf_cli.results.files import columns
    from msbsdf_cli.results.pieces import Pieces

    methods, precisions = options["method"] or tuple(METHODS), tuple(PRECISIONS)
    chosen, surfaces = points(options["full"]), options["method"] is None
    if options["cell"] is not None:
        methods, precisions, chosen, surfaces = _one(options)
    options["method"] = methods
    slug = "cell" if options["cell"] is not None else "full" if options["full"] else "draft"
    report = Report("stability", slug, options)
    if options["full"]:
        report.warn([f"the full map takes about {FULL_MINUTES} minutes on two cores."])
    settings = {"version": __version__, "methods": methods, "seed": options["seed"]}
    pieces = Pieces(report.place.out, settings)
    done = pieces.done()
    how = options["seed"], options["threads"], options["quiet"]
    with report.draft() as draft:
        rows: list[Row] = []
        if chosen:
            draft_only = not options["full"] and options["cell"] is None
            try:
                rows = study(chosen, methods, precisions, draft_only, *how, done, pieces.keep)
            except BaseException:
                click.echo(kept(pieces), err=True)
                raise
        if surfaces:
            rows += simulation(options["full"], *how)
            if options["cell"] is not None:
                rows = [row for row in rows if row.cell == options["cell"]]
        table = columns(rows, Row.__dataclass_fields__)
        counted = counts(rows)
        report.write(
            draft,
            {"stability.csv": table},
            len(rows),
            more={"summary": in_one_sentence(counted), "verdicts": counted},
        )
        if options["cell"] is None:
            draw_stability(rows, METHOD, draft)
    pieces.remove()
    report.end(lambda: show(rows, counted))


def kept(pieces: Any) -> str:
    """A sentence on what is left of a run that was stopped."""
    finished = len(pieces.done())
    return (
        f"{finished} finished points are kept in {pieces.directory}; the same command goes on "
        "from there."
    )


def _one(options: dict[str, Any]) -> tuple[Any, Any, Any, bool]:
    """Method, precision and point of one cell, and whether it is of the simulation."""
    from msbsdf_cli.experiments.stability.points import find
    from msbsdf_cli.experiments.stability.simulation import METHOD, cells
    from msbsdf_cli.methods.registry import METHODS

    method, _, rest = options["cell"].partition(",")
    precision, _, place = rest.partition(",")
    if method == METHOD and options["cell"] in cells(options["full"]):
        return (), (), [], True
    try:
        if method not in METHODS or precision not in ("float64", "float32"):
            raise KeyError(method)
        return (method,), (precision,), [find(tuple(place.split(",")))], False
    except KeyError:
        raise click.BadParameter(
            f"{options['cell']!r} is not a cell; the column `cell` of stability.csv names them.",
            param_hint="--cell",
        ) from None


def counts(rows: list[Any]) -> dict[str, dict[str, int]]:
    """How many cells have which verdict, by method and precision."""
    from msbsdf_cli.experiments.stability.verdicts import VERDICTS

    found: dict[str, dict[str, int]] = {}
    for row in rows:
        of = found.setdefault(f"{row.method} {row.precision}", dict.fromkeys(VERDICTS, 0))
        of[row.verdict] += 1
    return found


def in_one_sentence(counted: dict[str, dict[str, int]]) -> str:
    """How many cells have which verdict, and who fails most."""
    from collections import Counter

    from msbsdf_cli.experiments.stability.verdicts import FAILS, VERDICTS

    total: Counter[str] = sum((Counter(of) for of in counted.values()), Counter())
    verbs = "work", "are degraded", "fail", "are refused", "are unknown"
    said = zip(VERDICTS, verbs, strict=True)
    parts = [f"{total[verdict]} {verb}" for verdict, verb in said if total[verdict]]
    most = max(counted, key=lambda name: counted[name][FAILS], default="")
    text = f"Of {total.total()} cells: {', '.join(parts)}"
    return text + (f"; {most} fails most, in {counted[most][FAILS]}." if total[FAILS] else ".")


def show(rows: list[Any], counted: dict[str, dict[str, int]]) -> None:
    """Print how often each verdict was given; of one cell all that is known."""
    from msbsdf_cli.cli.terminal import show_table
    from msbsdf_cli.experiments.stability.verdicts import FAILS, VERDICTS

    if len(rows) == 1:
        for name, value in vars(rows[0]).items():
            click.echo(f"{name}: {value}")
        return
    order = sorted(counted.items(), key=lambda each: -each[1][FAILS])
    lines = [(*name.rsplit(" ", 1), *(f"{of[v]}" for v in VERDICTS)) for name, of in order]
    show_table(("method", "precision", *VERDICTS), lines, "stability.csv")
