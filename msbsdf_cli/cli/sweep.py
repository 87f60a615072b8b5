"""`msbsdf sweep`"""

from collections.abc import Sequence
from typing import Any

import click

from msbsdf_cli.cli.help import Page
from msbsdf_cli.cli.options import REPORT, use
from msbsdf_cli.cli.types import Typed, quoted


class Shard(Typed):
    """`K/N`: the K-th of N equal shares."""

    name = "K/N"

    def read(self, text: str) -> tuple[int, int]:
        try:
            k, n = (int(part) for part in text.split("/"))
        except ValueError:
            k, n = 0, 0
        if not 1 <= k <= n:
            raise ValueError(f"{quoted(text)} is not a share of the work: K/N, K from 1 to N.")
        return k, n


DEFAULT = (
    "compare --alpha 0.25:1:4 --theta 0:80deg:5 --samples 2e5 --free-path-theta 1 "
    "--free-path-height 0"
)
"""What is swept where nothing is asked for: a map worth looking at, in less than a minute."""


@click.command("sweep", cls=Page, context_settings={"ignore_unknown_options": True})
@click.argument("command", metavar="COMMAND|FILE.toml", default="")
@click.argument("words", nargs=-1, type=click.UNPROCESSED, metavar="[OPTIONS OF COMMAND]...")
@click.option("--scheduler", metavar="URL", help="Dask scheduler, such as tcp://HOST:PORT.")
@click.option("--shard", type=Shard(), help="Do the K-th of N shares of the work, for `merge`.")
@click.option("--dry-run", is_flag=True, help="Write plan.csv, a row for each piece, and stop.")
@use("threads", *REPORT)
def command(command: str, words: Sequence[str], **options: Any) -> None:
    """Run COMMAND (simulate, walk, compare, evaluate, furnace) for many scenes.

    Each option of COMMAND may be a list (0.1,0.5) or a range (low:high:n, or log:low:high:n for
    equal factors); where a comma has a meaning of its own, as in --alpha, give the option several
    times. A TOML file has them as lists: command = "walk", alpha = ["0.1:1:4", [1, 0.1]].

    Writes sweep.csv, COMMAND's main table with a column for each option that varies, and
    sweep.png. What is done is kept beside the report while it runs: the same command goes on.

    Without arguments: how far the Smith model is from explicit surfaces, over roughness and angle.
    """
    from msbsdf_cli.cli.sweeping import sweep

    if not command:
        command, *words = DEFAULT.split()
    sweep(command, tuple(words), options)
