"""Figures of the papers, each drawn from its tables alone; files are named as those that make them
in `experiments/figures`."""

from pathlib import Path

from msbsdf_cli.experiments.figures.catalogue import FIGURES
from msbsdf_cli.results.files import read_csv


def draw(name: str, tables: tuple[str, ...], directory: Path) -> None:
    """Draw the figure `name` from the files of its tables in `directory`, next to them."""
    FIGURES[name].draw({t: read_csv(directory / f"{t}.csv") for t in tables}, directory)
