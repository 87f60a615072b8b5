"""What a command measures, divided into pieces that anybody may do, in any order."""

from dataclasses import dataclass
from hashlib import sha256
from typing import Any, ClassVar, Protocol

from msbsdf_cli.experiments.sweep.states import State
from msbsdf_cli.results.files import Table
from surfaces.streams import seed_sequence

PLACES = 1 << 62
"""Places in a random stream that the work of a sweep takes."""


class Case(Protocol):
    """What is measured of one case: settings, which processes hand to each other. A class for each
    kind of work."""

    kind: ClassVar[str]
    shared: ClassVar[frozenset[str]]
    """Options in which cases of one piece may differ: they have much of the work in common."""

    @property
    def parts(self) -> int:
        """Parts that the work is divided into, each with sums of its own."""
        ...

    @staticmethod
    def seconds(cases: list[Any]) -> float:
        """About how long one core needs for a part of the cases together."""
        ...

    @staticmethod
    def measure(cases: list[Any], part: int) -> list[State]:
        """A state for each of the cases, of one of the parts. Raises ValueError for what cannot be
        measured."""
        ...


class Measured(Protocol):
    """What a command measures of one case: some kinds of work, and what is made of them."""

    @property
    def cases(self) -> dict[str, Any]:
        """The `Case` of each kind of work, by its name."""
        ...

    def table(self, states: dict[str, State]) -> Table:
        """The rows of the command's main table, from the sums of each kind of work."""
        ...


@dataclass(frozen=True)
class Alone:
    """What takes one kind of work only."""

    case: Any

    @property
    def cases(self) -> dict[str, Any]:
        return {self.case.kind: self.case}

    def table(self, states: dict[str, State]) -> Table:
        table: Table = self.case.table(states[self.case.kind])
        return table


@dataclass(frozen=True)
class Failure:
    """Why a case has no result."""

    reason: str


@dataclass(frozen=True)
class Piece:
    """Work for one process."""

    number: int
    """Its place among all pieces of the sweep."""
    places: tuple[int, ...]
    """Numbers of its cases."""
    cases: tuple[Any, ...]
    """The cases, of one class."""
    part: int
    seed: int

    @property
    def kind(self) -> str:
        """What kind of work it is."""
        return str(self.cases[0].kind)

    def seconds(self) -> float:
        """About how long one core needs for it."""
        return float(type(self.cases[0]).seconds(list(self.cases)))

    def do(self) -> list[State]:
        """Do it: a state for each case."""
        states: list[State] = type(self.cases[0]).measure(list(self.cases), self.part)
        return states


def place_of(identity: str) -> int:
    """A place in a random stream for what `identity` describes, and for nothing else."""
    return int(sha256(identity.encode()).hexdigest()[:16], 16) % PLACES


def seed_of(seed: int, identity: str) -> int:
    """The seed of a piece of work, whoever does it, and whatever else is done."""
    words = seed_sequence(seed, "sweep", place_of(identity)).generate_state(2)
    return (int(words[0]) << 31 ^ int(words[1])) % PLACES
