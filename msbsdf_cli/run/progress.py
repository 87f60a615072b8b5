"""Progress of long work."""

import sys
import time
from typing import Any

import click


class Progress:
    """A line on standard error with the share done, the rate and the time left."""

    def __init__(self, label: str, total: float, unit: str, quiet: bool) -> None:
        self.started = time.monotonic()
        self.done = 0.0
        self.unit = unit
        self.bar: Any = click.progressbar(
            length=1000,
            label=label,
            file=sys.stderr,
            hidden=quiet or not sys.stderr.isatty(),
            item_show_func=lambda _: f"{self.rate:.3g} {unit}/s",
        )
        self.total = total

    @property
    def rate(self) -> float:
        """Units done a second."""
        return self.done / max(time.monotonic() - self.started, 1e-9)

    def __enter__(self) -> "Progress":
        self.bar.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        self.bar.__exit__(None, None, None)

    def advance(self, amount: float) -> None:
        """Count work as done."""
        before = int(1000 * self.done / self.total)
        self.done += amount
        self.bar.update(int(1000 * self.done / self.total) - before, self.unit)
