"""What remembering the last facet is worth: `python -m tests.benchmarks.memory REPORT...`

Each REPORT is a directory that `msbsdf simulate` wrote. Prints a table for all of them as CSV, and
how often the targets of the walk that remembers are met.
"""

import csv
import os
import sys
from dataclasses import asdict, fields
from pathlib import Path

from msbsdf_cli.experiments.against_surfaces import Row, rows
from msbsdf_cli.results.run import load_run
from msbsdf_cli.run.executors import map_ordered
from surfaces.spectrum import GAUSSIAN

WALKS = 5_000_000
"""Of each model from each angle: they leave less noise than 100 surfaces do."""
TARGETS = {"wrong_order": 1 / 3, "total_variation": 1 / 2, "free_path_ks": 1 / 3}
"""At most so much of Smith's."""


def of_report(report: str) -> list[Row]:
    """All rows of one report."""
    place = Path(report)
    run = load_run(place / "sums.npz" if place.is_dir() else place)
    return rows(run, GAUSSIAN, WALKS, 0)


def main(reports: list[str]) -> None:
    table = csv.DictWriter(sys.stdout, [f.name for f in fields(Row)])
    table.writeheader()
    found: list[Row] = []
    for mine in map_ordered(of_report, reports, os.cpu_count() or 1):
        table.writerows(asdict(row) for row in mine)
        sys.stdout.flush()
        found += mine
    for quantity, share in TARGETS.items():
        # A cell tells something where Smith's error is known to a third of itself or better.
        told = [r for r in found if r.quantity == quantity and r.smith > 3 * r.stderr]
        for name in ("memory", "memory_2"):
            error = [(getattr(r, name), r.stderr, r.smith) for r in told]
            met, near, sure = (
                sum(e + sign * noise <= share * smith for e, noise, smith in error)
                for sign in (0, -1, 1)
            )
            worse = sum(e - 2 * noise > smith for e, noise, smith in error)
            print(
                f"{name}, {quantity}: at most {share:.2g} of Smith's in {met} of {len(told)} cells "
                f"(within a standard error {near}, by more {sure}), more than Smith's in {worse}",
                file=sys.stderr,
            )


if __name__ == "__main__":
    main(sys.argv[1:])
