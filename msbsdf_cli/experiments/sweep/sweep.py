"""A sweep: its pieces, done in any order, and the rows that they add up to."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

from msbsdf_cli.experiments.sweep.plan import Cases
from msbsdf_cli.experiments.sweep.states import State, total
from msbsdf_cli.experiments.sweep.work import Case, Failure, Measured, Piece
from msbsdf_cli.results.files import Table

CASES_OF_PIECE = 128
"""At most so many cases share the work of a piece: what they leave behind stays small."""

Setting = Measured | Failure
"""What is measured of a case, or why nothing can be."""

Read = Callable[[Piece], list[State] | Failure | None]
"""The states of a piece's cases, or why there are none; None where it is not done here."""


@dataclass(frozen=True)
class Sweep:
    """Cases, each measured with every seed. `setting` tells what is measured: of a case's number
    and a seed."""

    cases: Cases
    seeds: tuple[int, ...]
    kinds: tuple[type[Case], ...]
    setting: Callable[[int, int], Setting]
    notes: dict[str, None] = field(default_factory=dict)
    """Sentences on what is measured, which become known with the settings."""

    def groups(self) -> Iterator[list[int]]:
        """Cases that have work in common."""
        return self.cases.groups(frozenset().union(*(kind.shared for kind in self.kinds)))

    def pieces(self) -> Iterator[Piece]:
        """All pieces of work, one after the other, none of which is kept."""
        for seed in self.seeds:
            first = 0
            for group in self.groups():
                settings = {case: self.setting(case, seed) for case in group}
                found = list(self._of_group(settings, seed, first))
                first += len(found)
                yield from found

    def _of_group(self, settings: dict[int, Setting], seed: int, first: int) -> Iterator[Piece]:
        good = {c: s.cases for c, s in settings.items() if not isinstance(s, Failure)}
        for kind in self.kinds:
            of_kind = [case for case, kinds in good.items() if kind.kind in kinds]
            for together in self._shared(of_kind, kind):
                cases = tuple(good[case][kind.kind] for case in together)
                for part in range(cases[0].parts):
                    yield Piece(first, tuple(together), cases, part, seed)
                    first += 1

    def _shared(self, group: list[int], kind: type[Case]) -> Iterator[list[int]]:
        """Cases of a group that one piece of a kind of work takes."""
        sets: dict[tuple[int, ...], list[int]] = {}
        kept = [i for i, axis in enumerate(self.cases.axes) if axis.name not in kind.shared]
        for case in group:
            places = self.cases.places(case)
            sets.setdefault(tuple(places[i] for i in kept), []).append(case)
        for together in sets.values():
            for start in range(0, len(together), CASES_OF_PIECE):
                yield together[start : start + CASES_OF_PIECE]

    def rows(self, read: Read, together: bool) -> Iterator[tuple[int, int, Table | Failure]]:
        """Case, seed, and the rows of its table: of each seed, or with `together` of the sums over
        all of them, under the first. Cases that are not done here are left out."""
        firsts = dict.fromkeys(self.seeds, 0)
        for group in self.groups():
            of_seed: dict[int, dict[int, Any]] = {}
            settings: dict[int, dict[int, Setting]] = {}
            for seed in self.seeds:
                settings[seed] = {case: self.setting(case, seed) for case in group}
                pieces = list(self._of_group(settings[seed], seed, firsts[seed]))
                firsts[seed] += len(pieces)
                of_seed[seed] = _states(pieces, read)
            for case in group:
                for seeds in (self.seeds,) if together else ((seed,) for seed in self.seeds):
                    found = [of_seed[seed].get(case, {}) for seed in seeds]
                    table = self._table(settings[seeds[0]][case], found)
                    if table is not None:
                        yield case, seeds[0], table

    def _table(self, setting: Setting, found: list[dict[str, Any]]) -> Table | Failure | None:
        if isinstance(setting, Failure):
            return setting
        states: dict[str, State] = {}
        for kind in setting.cases:
            each: list[Any] = [one.get(kind) for one in found]
            if None in each:
                return None
            failed = [state for state in each if isinstance(state, Failure)]
            if failed:
                return failed[0]
            states[kind] = total(each)
        return setting.table(states)


def _states(pieces: Iterable[Piece], read: Read) -> dict[int, dict[str, State | Failure | None]]:
    """The sums of each case over the parts of each kind of work; None where a part is missing."""
    found: dict[int, dict[str, State | Failure | None]] = {}
    for piece in pieces:
        states = read(piece)
        for i, case in enumerate(piece.places):
            kinds = found.setdefault(case, {})
            before = kinds.setdefault(piece.kind, {})
            if states is None or before is None:
                kinds[piece.kind] = None
            elif isinstance(states, Failure):
                kinds[piece.kind] = states
            elif not isinstance(before, Failure):
                kinds[piece.kind] = total([before, states[i]])
    return found
