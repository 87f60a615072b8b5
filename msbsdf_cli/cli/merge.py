"""`msbsdf merge`"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from msbsdf_cli.cli.help import Page
from msbsdf_cli.cli.options import REPORT, use


@click.command("merge", cls=Page)
@click.argument("directories", nargs=-1, required=True, metavar="DIR...", type=click.Path())
@use(*REPORT)
def command(directories: tuple[str, ...], **options: Any) -> None:
    """Put together the reports of other seeds, shares and machines.

    DIR are reports of `simulate` or of `walk` of one scene, or of sweeps of the same cases, each
    with a seed of its own, or a share of the work. Error bars are those of one long run: they come
    from the sums, and not from the bars of the parts.
    """
    from msbsdf_cli.cli.merging import merge_runs, merge_sweeps
    from msbsdf_cli.results.seal import unsealed

    places = [Path(name) for name in directories]
    try:
        records = [unsealed(place) for place in places]
        if len({place.resolve() for place in places}) < len(places):
            raise ValueError("a report is named twice: its light would count twice.")
        merge: Callable[..., None] = merge_runs
        if any(record["command"] == "sweep" for record in records):
            merge = merge_sweeps
        merge(places, records, options)
    except ValueError as error:
        raise click.ClickException(f"{error}") from None
