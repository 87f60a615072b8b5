"""`msbsdf validate`"""

import sys
from functools import partial
from typing import Any

import click

from msbsdf_cli.cli.help import Page
from msbsdf_cli.cli.options import REPORT, use
from msbsdf_cli.cli.types import Count

SAMPLES, QUICK_SAMPLES = 2_000_000, 50_000


@click.command("validate", cls=Page)
@click.option(
    "--quick", is_flag=True, help="Fewer samples and configurations: half a minute or less."
)
@click.option(
    "--samples",
    type=Count(),
    metavar="N",
    help="Trials of each masking test, at least 1e6; other tests scale with it. "
    f"[default: {SAMPLES:.0e}; quick: {QUICK_SAMPLES:.0e}]",
)
@use("seed", "threads", *REPORT)
def command(**options: Any) -> None:
    """The published identities, each with a figure, a tolerance and a verdict.

    All verdicts hold together: a correct program fails in one run of a thousand. Exit status 0
    when all identities hold, 3 when one fails.
    """
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.plots.identities import draw_identities, draw_reciprocity
    from msbsdf_cli.run.executors import do_all
    from msbsdf_cli.statistics.multiple_testing import FAMILY_ERROR, judge
    from msbsdf_cli.validation.suite import measure
    from msbsdf_cli.validation.table import counts, differences, identities, summary

    if options["samples"] is None:
        options["samples"] = QUICK_SAMPLES if options["quick"] else SAMPLES
    report = Report("validate", "quick" if options["quick"] else "full", options)
    settings = (options[name] for name in ("samples", "seed", "threads", "quick", "quiet"))
    with report.draft() as draft:
        suite = measure(*settings)
        rows = judge(suite.findings)
        more = {
            "summary": summary(rows),
            "verdicts": counts(rows),
            "family_error": FAMILY_ERROR,
            "failed": [f"{r.finding.identity} ({r.finding.section})" for r in rows if r.failed],
        }
        tables = {"identities.csv": identities(rows), "reciprocity.csv": differences(rows)}
        report.write(draft, tables, suite.samples, None, suite.wall_s, more)
        pictures = [
            partial(draw_identities, rows, draft / "identities.png"),
            partial(draw_reciprocity, rows, draft / "reciprocity.png"),
        ]
        do_all(pictures, options["threads"])
    report.end(lambda: show(rows))
    if any(row.failed for row in rows):
        sys.exit(3)


def show(rows: list[Any]) -> None:
    """Print a line for each row that fails, and one for each identity, the worst first."""
    from msbsdf_cli.cli.terminal import show_table
    from msbsdf_cli.validation.table import FAILURE_HEADER, HEADER, failures, lines

    failed = failures(rows)
    if failed:
        show_table(FAILURE_HEADER, failed, "identities.csv")
        click.echo()
    show_table(HEADER, lines(rows), "identities.csv")
