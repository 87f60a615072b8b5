"""Reports of other seeds, shares and machines, put together from their sums."""

from pathlib import Path
from typing import Any

from msbsdf_cli.cli.report import Report
from msbsdf_cli.cli.runs import read_run, show_run, write_run
from msbsdf_cli.cli.study import study
from msbsdf_cli.cli.sweeping import write
from msbsdf_cli.experiments.sweep.sweep import Sweep
from msbsdf_cli.results.sweeps import ARCHIVE, Archive, name_of, refuse_other
from msbsdf_cli.run.executors import do_all

Options = dict[str, Any]

OF_ONE_REPORT = (
    *("seed", "out", "force", "format", "quiet", "as_json", "threads"),
    *("samples", "save_mesh"),
)
"""Options in which runs that are put together may differ."""

OF_ONE_SHARE = "seeds", "shard"
"""Parts of plans in which sweeps that are put together may differ."""


def merge_runs(places: list[Path], records: list[Options], options: Options) -> None:
    """Put together reports of `simulate` or of `walk`.

    Raises ValueError, with the name of a directory, for what is not of the same light.
    """
    first, seeds = records[0], []
    for place, record in zip(places, records, strict=True):
        _refuse_versions(place, record, first)
        if record["command"] != first["command"]:
            commands = f"`{record['command']}`, {places[0]} of `{first['command']}`"
            raise ValueError(f"{place} is a report of {commands}: they do not add up.")
        _refuse_options(place, record["options"], first["options"])
        own = record["seed"] if isinstance(record["seed"], list) else [record["seed"]]
        for seed in (seed for seed in own if seed in seeds):
            raise ValueError(f"{place}: the seed {seed} is in two of the reports.")
        seeds += own
    _, total = read_run(places[0])
    for place in places[1:]:
        total.merge(read_run(place)[1])
    report = Report(
        f"merge-{total.kind}", total.scene.slug(), options | {"merged": list(map(str, places))}
    )
    report.command = total.kind
    report.options = first["options"] | options | {"seed": seeds}
    with report.draft() as draft:
        lobes, pictures = write_run(report, draft, total)
        do_all(pictures, 1)
    unit = "rays" if total.kind == "simulate" else "walks"
    report.end(lambda: show_run(lobes, total, unit))


def _refuse_versions(place: Path, record: Options, first: Options) -> None:
    mine, theirs = (r["versions"]["msbsdf"] for r in (record, first))
    if mine != theirs:
        raise ValueError(f"{place} is of version {mine}, and others are of {theirs}.")


def _refuse_options(place: Path, mine: Options, theirs: Options) -> None:
    for name in sorted({*mine, *theirs} - {*OF_ONE_REPORT, "realisations"}):
        if mine.get(name) != theirs.get(name):
            raise ValueError(
                f"{place} has --{name.replace('_', '-')} {mine.get(name)}, and others have "
                f"{theirs.get(name)}: they do not add up."
            )


def merge_sweeps(places: list[Path], records: list[Options], options: Options) -> None:
    """Put together sweeps of the same cases: their shares, and their seeds.

    Raises ValueError, with the name of a directory, for what is not of the same sweep, and where a
    share is missing.
    """
    archives = [_archive(place) for place in places]
    first = archives[0].plan
    for place, archive in zip(places, archives, strict=True):
        refuse_other(first, archive.plan, place, *OF_ONE_SHARE)
    seeds = tuple(dict.fromkeys(seed for archive in archives for seed in archive.plan["seeds"]))
    found = study(first["command"], first["options"], seeds)
    failures = {name: why for archive in archives for name, why in archive.failures.items()}
    check_whole(found.sweep, places, archives, failures)
    plan = found.plan(None)
    merged = options | {"merged": list(map(str, places)), "seed": list(seeds), **plan}
    report = Report("merge", f"sweep-{found.slug}", merged)
    report.command = "sweep"
    write(report, found.sweep, failures, plan, *archives, together=True)


def _archive(place: Path) -> Archive:
    if not (place / ARCHIVE).is_file():
        raise ValueError(f"{place} is no report of a sweep that was done, as others are.")
    return Archive(place / ARCHIVE)


def check_whole(
    sweep: Sweep, places: list[Path], archives: list[Archive], failures: dict[str, str]
) -> None:
    """Raise ValueError where a piece is there twice, or not at all."""
    home: dict[str, Path] = {}
    for place, archive in zip(places, archives, strict=True):
        for name in archive.done() | archive.failures.keys():
            if name in home:
                raise ValueError(
                    f"{place} and {home[name]} hold the same pieces of work: their light would "
                    "count twice."
                )
            home[name] = place
    missing = [p for p in sweep.pieces() if name_of(p.seed, p.number) not in home]
    if missing:
        raise ValueError(
            f"{len(missing)} pieces of the sweep are in none of the directories, such as number "
            f"{missing[0].number} of seed {missing[0].seed}: name all shares, each with all seeds."
        )
