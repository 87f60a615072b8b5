"""The cases of a sweep, and the pieces of work that they fall into."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any


@dataclass(frozen=True)
class Axis:
    """An option that varies."""

    name: str
    values: tuple[Any, ...]
    """What the option is, in each place."""
    labels: tuple[float | str, ...]
    """The same, as tables and pictures have it."""


@dataclass(frozen=True)
class Cases:
    """All combinations of the values of axes, numbered with the last axis running fastest."""

    axes: tuple[Axis, ...]

    def __len__(self) -> int:
        return math.prod(len(axis.values) for axis in self.axes)

    def places(self, case: int) -> tuple[int, ...]:
        """Where on each axis the case is."""
        places = []
        for axis in reversed(self.axes):
            case, place = divmod(case, len(axis.values))
            places.append(place)
        return tuple(reversed(places))

    def values(self, case: int) -> dict[str, Any]:
        """What each option is."""
        return {a.name: a.values[k] for a, k in zip(self.axes, self.places(case), strict=True)}

    def labels(self, case: int) -> list[float | str]:
        """The same, as the columns of tables."""
        return [a.labels[k] for a, k in zip(self.axes, self.places(case), strict=True)]

    def groups(self, shared: frozenset[str]) -> Iterator[list[int]]:
        """Cases that differ in the options `shared` alone, group by group."""
        strides, stride = {}, 1
        for axis in reversed(self.axes):
            strides[axis.name] = stride
            stride *= len(axis.values)

        def offsets(wanted: bool) -> Iterator[int]:
            axes = [a for a in self.axes if (a.name in shared) == wanted]
            steps = [[strides[a.name] * k for k in range(len(a.values))] for a in axes]
            return map(sum, product(*steps))

        for start in offsets(False):
            yield sorted(start + step for step in offsets(True))
