"""How figures are made."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

from msbsdf_cli.results.files import Table
from msbsdf_cli.run.executors import Workers

Tables = Mapping[str, Table]
"""The tables of a figure, by the names of their files without .csv."""

T = TypeVar("T")


@dataclass(frozen=True)
class Settings:
    """What all figures share."""

    seed: int = 0
    workers: Workers = 1
    quick: bool = False
    """Whether a draft is enough."""
    quiet: bool = True

    def of_scene(self, number: int) -> "Settings":
        """The same with a seed for the scene of this number, whose noise is then its own."""
        return replace(self, seed=self.seed + number)

    def pick(self, draft: T, full: T) -> T:
        """The setting for a draft, or for print."""
        return draft if self.quick else full
