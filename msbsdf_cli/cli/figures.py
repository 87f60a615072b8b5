"""`msbsdf figures`"""

from functools import partial
from pathlib import Path
from typing import Any

import click

from msbsdf_cli.cli.gallery import GALLERY
from msbsdf_cli.cli.help import Page
from msbsdf_cli.cli.options import REPORT, use
from msbsdf_cli.experiments.figures.catalogue import FIGURES, Figure

CHEAP = tuple(name for name, figure in FIGURES.items() if figure.cheap)


@click.command("figures", cls=Page)
@click.argument(
    "names",
    nargs=-1,
    type=click.Choice(tuple(dict.fromkeys((*FIGURES, *GALLERY)))),
    metavar="[NAME...]",
)
@click.option("--list", is_flag=True, help="Which figure is which, and what it shows.")
@click.option("--all", is_flag=True, help="All of them, which takes a quarter of an hour.")
@click.option("--quick", is_flag=True, help="Drafts; of all, where no NAME is given.")
@click.option(
    "--gallery",
    is_flag=True,
    help="Make the pictures of reports/gallery again, into --out; NAME is a folder of it.",
)
@use("seed", "threads", *REPORT)
def command(**options: Any) -> None:
    """The figures of [HHdD16] and [WJFYHY22 supp.], remade: tables, and pictures drawn from them.

    NAME is a figure, as --list names them, or `claims`: what the papers state, beside what is
    measured here. Without NAME, those that take a few seconds.
    """
    if options.pop("list"):
        show_list()
    elif options.pop("gallery"):
        make_gallery(options)
    else:
        make_figures(options)


def show_list() -> None:
    """Print each figure, what it shows and what the paper says of it."""
    for figure in FIGURES.values():
        click.echo(f"msbsdf figures {figure.name}\n    {figure.source}: {figure.shows}")
        click.echo(f"    says: {figure.says}")


def chosen(options: dict[str, Any]) -> list[Figure]:
    """The figures wanted. Raises click.BadParameter for a folder of the gallery."""
    if options["names"] and options["all"]:
        raise click.UsageError("--all beside a NAME: give one of them.")
    for name in options["names"]:
        if name not in FIGURES:
            message = f"{name} is a folder of the gallery; its figures are made with --gallery."
            raise click.BadParameter(message, param_hint="NAME")
    without = FIGURES if options["all"] or options["quick"] else CHEAP
    options["names"] = tuple(dict.fromkeys(options["names"] or without))
    return [FIGURES[name] for name in options["names"]]


def make_figures(options: dict[str, Any]) -> None:
    """The report."""
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.experiments.figures.settings import Settings
    from msbsdf_cli.plots.figures import draw
    from msbsdf_cli.run.executors import do_all

    figures = chosen(options)
    report = Report("figures", slug(options), options)
    around = options["threads"], options["quick"], options["quiet"]
    with report.draft() as draft:
        files: dict[str, tuple[str, ...]] = {}
        tables: dict[str, Any] = {}
        for figure in figures:
            made = figure.make(Settings(options["seed"], *around))
            files[figure.name] = tuple(made)
            tables |= {f"{name}.csv": table for name, table in made.items()}
        more = {"summary": summary(tables.get("claims.csv")), "figures": about(figures)}
        report.write(draft, tables, 0, more=more)
        drawn = [partial(draw, f.name, files[f.name], draft) for f in figures if f.drawn]
        do_all(drawn, options["threads"])
    report.end(lambda: show(figures, tables.get("claims.csv")))


def slug(options: dict[str, Any]) -> str:
    """What was made, as the name of a directory."""
    names = options["names"]
    what = {tuple(FIGURES): "all", CHEAP: "cheap"}.get(names, "-".join(names))
    return (what if len(what) < 60 else f"{len(names)}") + "-quick" * options["quick"]


def about(figures: list[Figure]) -> list[str]:
    """What each figure is, for run.json."""
    return [f"{f.name}: {f.source}, {f.shows}" for f in figures]


def summary(claims: Any) -> str:
    """How many claims hold."""
    if claims is None:
        return ""
    verdicts = claims["verdict"]
    counts = [f"{verdicts.count(v)} {w}" for v, w in WORDS.items()]
    return f"Of {len(verdicts)} claims {', '.join(counts)}."


WORDS = {
    "holds": "hold",
    "does not hold": "do not hold",
    "not comparable": "are not comparable",
}


def show(figures: list[Figure], claims: Any) -> None:
    """Print what was made, and every claim."""
    from msbsdf_cli.cli.terminal import measured, say, show_table

    if claims is not None:
        say(summary(claims))
    for figure in figures:
        say(f"{figure.name}: {figure.source}, {figure.shows}")
    if claims is not None:
        columns = ("claim", "published", "measured", "stderr", "verdict")
        rows = [
            (verdict, claim, f"{published:g}", measured(value, error))
            for claim, published, value, error, verdict in zip(
                *(claims[name] for name in columns), strict=True
            )
        ]
        show_table(("verdict", "claim", "published", "measured"), rows, "claims.csv")
    if figures and all(figure.cheap for figure in figures):
        say(f"{len(FIGURES) - len(CHEAP)} more take longer: --list, --quick, --all.")


def make_gallery(options: dict[str, Any]) -> None:
    """Make folders of the gallery again. Raises click.BadParameter for what is none."""
    from msbsdf_cli.cli.gallery import MOST_BYTES, PLACE, make

    for name in options["names"]:
        if name not in GALLERY or not GALLERY[name].remade:
            raise click.BadParameter(
                f"{name} is no folder of the gallery that commands make.", param_hint="NAME"
            )
    place = Path(options["out"] or PLACE)
    size = make(options["names"], place)
    if size > MOST_BYTES:
        raise click.ClickException(
            f"{place} holds {size / 1e6:.2f} MB, and no more than {MOST_BYTES / 1e6:g} is wanted."
        )
    if not options["quiet"]:
        click.echo(f"Gallery: {place}, {size / 1e6:.2f} MB")
