"""The table of a sweep, written row by row."""

import csv
from math import isfinite
from pathlib import Path
from typing import Any

from msbsdf_cli.experiments.sweep.sweep import Read, Sweep
from msbsdf_cli.experiments.sweep.work import Failure

TABLE = "sweep.csv"


class Rows:
    """sweep.csv: the options that vary, the command's main table, and why a case has no rows."""

    def __init__(self, path: Path, sweep: Sweep, together: bool) -> None:
        self.path, self.sweep, self.together = path, sweep, together
        self.cases = self.rows = self.failures = self.bad = 0
        self.reason = ""

    def write(self, read: Read) -> None:
        """Write row by row: all of them at once are more than memory should hold."""
        seeds = len(self.sweep.seeds) > 1 and not self.together
        names = [axis.name for axis in self.sweep.cases.axes] + ["seed"] * seeds
        failed, columns = [], None
        with open(self.path, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            for case, seed, table in self.sweep.rows(read, self.together):
                self.cases += 1
                key = [*self.sweep.cases.labels(case), *[seed] * seeds]
                if isinstance(table, Failure):
                    self.failures, self.reason = self.failures + 1, self.reason or table.reason
                    failed.append((key, table.reason))
                    if columns is not None:
                        failed = self._failed(writer, failed, columns)
                    continue
                if columns is None:
                    columns = [name for name in table if name not in names]
                    writer.writerow((*names, *columns, "failure"))
                    failed = self._failed(writer, failed, columns)
                for row in zip(*(table[name] for name in columns), strict=True):
                    self.bad += any(isinstance(x, float) and not isfinite(x) for x in row)
                    writer.writerow((*key, *row, ""))
                    self.rows += 1
            if columns is None:
                writer.writerow((*names, "failure"))
                self._failed(writer, failed, [])

    def _failed(self, writer: Any, failed: list[Any], columns: list[str]) -> list[Any]:
        """Write cases without rows, and none are left to write."""
        writer.writerows((*key, *[""] * len(columns), reason) for key, reason in failed)
        return []

    def warnings(self) -> list[str]:
        """Sentences on what is missing or not finite."""
        sentences = []
        if self.failures:
            sentences.append(
                f"{self.failures} of {self.cases} cases failed; the column failure says why, the "
                f"first because {self.reason.rstrip('.')}."
            )
        if self.bad:
            sentences.append(f"{TABLE}: {self.bad} of {self.rows} rows hold what is not finite.")
        return sentences
