"""A study done in pieces, on this machine or others, and written as a report."""

import csv
import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any

import click

from msbsdf_cli.cli.common import duration
from msbsdf_cli.cli.meshes import BYTES_PER_CELL
from msbsdf_cli.cli.report import Report
from msbsdf_cli.cli.study import study_of
from msbsdf_cli.cli.sweep_table import TABLE, Rows
from msbsdf_cli.experiments.sweep.files import FileCase
from msbsdf_cli.experiments.sweep.states import State
from msbsdf_cli.experiments.sweep.surfaces import SurfaceCase
from msbsdf_cli.experiments.sweep.sweep import Sweep
from msbsdf_cli.experiments.sweep.work import Failure, Piece
from msbsdf_cli.results.files import json_text
from msbsdf_cli.results.seal import unsealed
from msbsdf_cli.results.sweeps import (
    ARCHIVE,
    Archive,
    Pieces,
    PieceStore,
    name_of,
    pack,
    read,
    refuse_other,
)
from msbsdf_cli.run.cluster import MISSING, cluster, has_dask
from msbsdf_cli.run.completed import Failed, map_completed
from msbsdf_cli.run.executors import Workers
from msbsdf_cli.run.memory import gigabytes
from msbsdf_cli.run.progress import Progress

Options = dict[str, Any]


def sweep(command: str, words: tuple[str, ...], own: Options) -> None:
    """Do a study, or the rest of it, and write its report."""
    if own["scheduler"] is not None and not has_dask():
        raise click.UsageError(f"--scheduler: {MISSING}")
    found = study_of(command, words)
    shard = own["shard"]
    share = "" if shard is None else f"-{shard[0]}-of-{shard[1]}"
    out = Path(own["out"] or f"reports/sweep-{found.slug}{share}")
    plan = found.plan(shard)
    own["force"] = own["force"] or _is_dry(out)
    if not own["force"] and not own["dry_run"] and finished(out, plan):
        _say(own, f"{out} holds this sweep, and it is whole; nothing is left to do.")
        if own["as_json"]:
            click.echo(json_text(unsealed(out) | {"report": str(out)}))
        return
    options = own | {"sweep": command, "seed": list(found.sweep.seeds), **plan}
    report = Report("sweep", f"{found.slug}{share}", options)
    total = announce(found.sweep, own)
    if own["dry_run"]:
        write_plan(report, found.sweep, total)
        return
    store = PieceStore(out, plan)
    with _opened(store), _kept(store, total):
        failures = do(found.sweep, store, own, total)
        write(report, found.sweep, failures, plan, store)
        store.remove()


def finished(out: Path, plan: dict[str, Any]) -> bool:
    """Whether a directory holds this very sweep, done. Raises click.UsageError where it holds
    another one."""
    if not (out / ARCHIVE).is_file():
        return False
    try:
        unsealed(out)
        refuse_other(json.loads(json.dumps(plan)), Archive(out / ARCHIVE).plan, out)
    except ValueError as error:
        raise click.UsageError(f"{error} Name another --out, or replace it with --force.") from None
    return True


def _is_dry(out: Path) -> bool:
    """Whether a directory holds no more than the plan of a sweep."""
    try:
        return bool(unsealed(out).get("dry_run"))
    except ValueError:
        return False


@contextmanager
def _opened(store: PieceStore) -> Iterator[None]:
    try:
        with store.opened():
            yield
    except ValueError as error:
        raise click.ClickException(f"{error}") from None


@contextmanager
def _kept(store: PieceStore, total: int) -> Iterator[None]:
    """Say, where a sweep ends early, that nothing of it is lost."""
    try:
        yield
    except BaseException:
        done = len(store.done()) if store.directory.is_dir() else 0
        if done:
            click.echo(
                f"{done} of {total} pieces are done and kept in {store.directory.name}; "
                "the same command goes on with the rest.",
                err=True,
            )
        raise


def announce(sweep: Sweep, own: Options) -> int:
    """Say how much there is to do, before it begins; the number of pieces.

    Raises click.UsageError where nothing can be done.
    """
    k, n = own["shard"] or (1, 1)
    pieces = sum(1 for _ in sweep.pieces())
    if pieces == 0:
        refusal = sweep.setting(0, sweep.seeds[0])
        assert isinstance(refusal, Failure), "a case that can be measured has a piece"
        raise click.UsageError(refusal.reason)
    mine = len(range(k - 1, pieces, n))
    costs = [seconds for _, seconds in costed(sweep, pieces, FEW) if seconds is not None]
    seconds = (sum(costs) / len(costs) + OVERHEAD_S) * mine / own["threads"]
    results = len(sweep.cases) * len(sweep.seeds)
    share = "" if n == 1 else f", {mine} of them in this share"
    _say(
        own,
        f"{results} cases in {pieces} pieces of work{share}: about {duration(max(seconds, 1))} in "
        f"{own['threads']} processes of {gigabytes(memory_of(next(sweep.pieces())))} each.",
    )
    return mine


OVERHEAD_S = 3e-3
"""Of a piece: handing it over, and keeping what it came to."""

FEW, MANY = 16, 400
"""Pieces whose cost is estimated one by one, of a whole that is announced, and of a plan."""


def costed(sweep: Sweep, pieces: int, most: int) -> Iterator[tuple[Piece, float | None]]:
    """All pieces; for evenly spaced ones, about `most`, also what they cost in seconds."""
    step = -(-pieces // most)
    for i, piece in enumerate(sweep.pieces()):
        yield piece, piece.seconds() if i % step == 0 else None


def memory_of(piece: Piece) -> float:
    """Bytes that a process needs for it, about."""
    case = piece.cases[0]
    if not isinstance(case, SurfaceCase | FileCase):
        return LIBRARIES
    return LIBRARIES + BYTES_PER_CELL * case.cells


LIBRARIES = 2e8
"""Bytes that a process needs for what is imported."""


def write_plan(report: Report, sweep: Sweep, pieces: int) -> None:
    """The report of a dry run: plan.csv, a row for each piece."""
    names = [axis.name for axis in sweep.cases.axes]
    with report.draft() as draft:
        with open(draft / "plan.csv", "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(("piece", "kind", "seed", "part", "cases", *names, "seconds"))
            seconds = 0.0
            for i, (piece, cost) in enumerate(costed(sweep, pieces, MANY)):
                seconds = seconds if cost is None else cost
                first = sweep.cases.labels(piece.places[0])
                what = piece.kind, piece.seed, piece.part, len(piece.places)
                writer.writerow((i, *what, *first, f"{seconds:.3g}"))
        report.write(draft, {}, pieces, more={"dry_run": True})
    report.end()


def do(sweep: Sweep, store: PieceStore, own: Options, total: int) -> dict[str, str]:
    """Do the pieces that are not done, and keep what they come to; why pieces failed, by name."""
    failures: dict[str, str] = {}
    done, (k, n) = store.done(), own["shard"] or (1, 1)
    mine = islice(sweep.pieces(), k - 1, None, n)
    left = (piece for piece in mine if name_of(piece.seed, piece.number) not in done)
    with (
        Progress("sweep", max(total, 1), "pieces", own["quiet"]) as progress,
        workers(own) as executor,
    ):
        progress.skip(len(done))
        for piece, done_piece in map_completed(timed, left, executor):
            name = name_of(piece.seed, piece.number)
            if isinstance(done_piece, Failed):
                failures[name] = done_piece.reason
                progress.advance(1, f"piece {piece.number} failed")
            else:
                states, seconds = done_piece
                store.keep(name, states)
                labels = ", ".join(map(str, sweep.cases.labels(piece.places[0])))
                progress.advance(1, f"{piece.kind} {labels} took {seconds:.2g} s")
    return failures


def timed(piece: Piece) -> tuple[list[State], float]:
    """What a piece comes to, and the seconds that it took whoever did it."""
    started = time.perf_counter()
    return piece.do(), time.perf_counter() - started


@contextmanager
def workers(own: Options) -> Iterator[Workers]:
    """Processes of this machine, or those of a cluster."""
    if own["scheduler"] is None:
        yield own["threads"]
        return
    with cluster(own["scheduler"]) as executor:
        yield executor


def write(
    report: Report,
    sweep: Sweep,
    failures: dict[str, str],
    plan: dict[str, Any],
    *parts: Pieces,
    together: bool = False,
) -> None:
    """Write sweep.csv, its picture and an archive of all pieces as a report; with `together`, rows
    of the sums over all seeds."""
    from msbsdf_cli.plots.sweep import draw_sweep

    home = {name: part for part in parts for name in part.done()}

    def states(piece: Piece) -> Any:
        name = name_of(piece.seed, piece.number)
        if name in failures:
            return Failure(failures[name])
        return read(home[name], name) if name in home else None

    with report.draft() as draft:
        rows = Rows(draft / TABLE, sweep, together)
        rows.write(states)
        pack(draft / ARCHIVE, plan, failures, *parts)
        report.warn([*sweep.notes, *rows.warnings()])
        grid = draw_sweep(draft / TABLE, draft / "sweep.png") if rows.rows else None
        said = f"{rows.cases - rows.failures} of {rows.cases} cases were measured."
        if grid is not None:
            said += f" {grid.extreme()}"
        figures = {"cases": rows.cases, "rows": rows.rows, "failures": rows.failures}
        report.write(draft, {}, max(rows.cases, 1), more={"summary": said, **figures})
    report.end()
    if rows.cases and rows.failures == rows.cases:
        raise click.ClickException(f"every case failed: {rows.reason}")


def _say(own: Options, sentence: str) -> None:
    if not (own["quiet"] or own["as_json"]):
        click.echo(sentence, err=True)
