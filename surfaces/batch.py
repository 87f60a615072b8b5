"""Many paths at once, as arrays whose last axis counts the paths."""

from collections.abc import Callable, Iterator
from typing import Any, Self, TypeVar

import numpy as np

from surfaces.facet import Array


class Batch:
    """Base of dataclasses of arrays (..., n); a field may be None throughout."""

    @property
    def size(self) -> int:
        """The number of paths."""
        return max(a.shape[-1] for a in vars(self).values() if a is not None)

    def each(self, pick: Callable[[Array], Array]) -> Self:
        """The same selection from each array that is there."""
        some: dict[str, Any] = {k: None if a is None else pick(a) for k, a in vars(self).items()}
        return type(self)(**some)

    def compress(self, keep: Array) -> Self:
        """The paths for which `keep` (n,) of bool holds."""
        return self.take(np.flatnonzero(keep))

    def take(self, lanes: Array) -> Self:
        """The paths of these numbers (n,)."""
        return self.each(lambda a: a.take(lanes, axis=-1))

    def blocks(self, length: int) -> Iterator[Self]:
        """Runs of at most `length` paths."""
        if 0 < self.size <= length:
            yield self
            return
        for start in range(0, self.size, length):
            part = slice(start, start + length)
            yield self.each(lambda a, part=part: a[..., part])  # type: ignore[misc]


B = TypeVar("B", bound="Batch")


def concatenate(parts: list[B]) -> B:
    """All the paths of several batches, at least one."""
    if len(parts) == 1:
        return parts[0]
    columns: dict[str, Any] = {
        name: None if first is None else np.concatenate([vars(p)[name] for p in parts], axis=-1)
        for name, first in vars(parts[0]).items()
    }
    return type(parts[0])(**columns)
