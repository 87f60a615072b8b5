"""The reports of both producers of light: written, read, and shown."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import click

from msbsdf_cli.cli.report import Part
from msbsdf_cli.cli.terminal import in_percent, measured, show_table
from msbsdf_cli.results.files import Table
from msbsdf_cli.results.lobes import Lobes
from msbsdf_cli.results.run import Run, load_run
from msbsdf_cli.results.seal import unsealed
from msbsdf_cli.scene import in_degrees
from msbsdf_cli.statistics.tally import REST, SIDES

PRODUCERS = "simulate", "walk"
"""Commands whose reports hold a run."""

SUMS = "sums.npz"
"""The sums that the tables of a run were made of."""


def write_run(
    report: Part, draft: Path, run: Run, tables: dict[str, Table] | None = None
) -> tuple[Lobes, list[Callable[[], None]]]:
    """Write the report of a run into `draft`, with more `tables` by file name; the light that left,
    and what draws its pictures."""
    from msbsdf_cli.plots.free_path import draw_free_paths
    from msbsdf_cli.plots.lobes import draw_lobes
    from msbsdf_cli.results.tables import all_tables

    lobes = run.lobes()
    figures = run.paths, run.bounces_mean, run.wall_s
    more = {"energies": summary(run), "summary": in_one_sentence(run)} | run.notes
    report.write(draft, all_tables(run, lobes) | (tables or {}), *figures, more)
    run.save(draft / SUMS)
    pictures: list[Callable[[], None]] = [
        partial(draw_lobes, lobes, draft),
        partial(draw_free_paths, draft / "free_path.png", run.free_paths),
    ]
    return lobes, pictures


def write_part(
    draft: Path, run: Run, options: dict[str, Any], name: str | None = None
) -> tuple[Lobes, list[Callable[[], None]]]:
    """The report of a run within another one, in a directory of that `name`, by default the kind of
    the run; the light that left, and what draws it."""
    place = draft / (name or run.kind)
    place.mkdir()
    return write_run(Part(run.kind, options), place, run)


def read_run(directory: Path) -> tuple[dict[str, Any], Run]:
    """What run.json says, and the run. Raises click.ClickException where there is none, or one
    that is no longer as it was written."""
    try:
        record = unsealed(directory)
        if record["command"] not in PRODUCERS:
            raise ValueError(
                f"{directory} is a report of `{record['command']}`: one of "
                f"{' or '.join(f'`{name}`' for name in PRODUCERS)} is wanted."
            )
        return record, load_run(directory / SUMS)
    except ValueError as error:
        raise click.ClickException(f"{error}") from None


def summary(run: Run) -> list[dict[str, Any]]:
    """Energies in total, one entry for each incident angle."""
    entries = []
    sides = SIDES[: 1 + run.scene.material.transmits]
    for theta, tally in zip(run.scene.theta, run.tallies, strict=True):
        side = tally.estimate("side")
        entry: dict[str, Any] = {"theta_i_rad": theta, "phi_i_rad": run.scene.phi}
        for i, name in enumerate(sides):
            entry[name] = float(side.value[i])
            entry[f"{name}_stderr"] = float(side.stderr[i])
        for name in REST:
            entry[name] = float(tally.estimate(name).value)
        entries.append(entry)
    return entries


def in_one_sentence(run: Run) -> str:
    """How much light leaves after one bounce and after more, at the angles where that is least and
    most."""
    shares = [
        (more, once, theta)
        for theta, (once, more) in zip(run.scene.theta, run.bounces(), strict=True)
    ]
    most, *others = dict.fromkeys((max(shares), min(shares)))
    text = (
        f"At theta {in_degrees(most[-1])} {in_percent(*most[1])} of the light leaves after one "
        f"bounce and {in_percent(*most[0])} after more"
    )
    for more, once, theta in others:
        text += f"; at {in_degrees(theta)} {in_percent(*once)} and {in_percent(*more)}"
    return f"{text}."


def show_run(lobes: Lobes, run: Run, unit: str) -> None:
    """Print energies per order and side, with standard errors in the last digits."""
    prefixes = [""] if len(lobes.sides) == 1 else ["R ", "T "]
    names = [f"{p}{order}" for p in prefixes for order in lobes.names]
    rows = []
    for i, theta in enumerate(lobes.theta):
        value, stderr = (a[i].T.ravel() for a in (lobes.energy.value, lobes.energy.stderr))
        cells = [measured(v, e) for v, e in zip(value, stderr, strict=True)][: len(names)]
        rest = [measured(lobes.rest[n].value[i], lobes.rest[n].stderr[i]) for n in REST]
        rows.append([in_degrees(theta), *cells, *rest])
    show_table(["theta", *names, *REST], rows, "energy.csv")
    click.echo(
        f"{run.paths / run.wall_s:.3g} {unit} a second for {run.wall_s:.1f} s, "
        f"{run.bounces_mean:.3f} facets each."
    )
