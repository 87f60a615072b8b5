"""What a piece of work leaves behind: sums, which add up to those of one long run."""

from collections.abc import Iterable

import numpy as np

from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.statistics.tally import REST, Tally
from surfaces.facet import Array

State = dict[str, Array]
"""Arrays by name. Two of them add up, but for those whose names say that they are the largest."""

LARGEST = "largest_"
"""Begins the name of what is the largest of its values, and not their sum."""

ENERGIES = ("energy", "side", *REST)
"""Figures of a tally that energies need; directions are a thousand times as many."""


def total(states: Iterable[State]) -> State:
    """The state of all the work together. Raises ValueError where two do not fit together."""
    found: State = {}
    for state in states:
        if not state:
            continue
        if not found:
            found = {name: np.array(array) for name, array in state.items()}
            continue
        if found.keys() != state.keys() or any(found[n].shape != state[n].shape for n in found):
            raise ValueError("the sums are not of one kind of work.")
        for name, array in state.items():
            add = np.maximum if name.startswith(LARGEST) else np.add
            add(found[name], array, out=found[name])
    return found


def of_tally(tally: Tally, directions: bool) -> State:
    """The state of a tally: all of it, or without `directions` its energies alone."""
    arrays = tally.arrays()
    if directions:
        return dict(arrays)
    size, kept = tally.sums.shape[1], _energies(tally)
    return {n: a[..., kept] if a.shape[-1] == size else a for n, a in arrays.items()}


def restore(tally: Tally, state: State) -> None:
    """Put a state into an empty tally; directions that it has not are left empty."""
    size, kept, arrays = tally.sums.shape[1], _energies(tally), tally.arrays()
    for name, empty in arrays.items():
        if empty.shape == state[name].shape:
            arrays[name] = state[name]
        else:
            arrays[name] = np.zeros((*empty.shape[:-1], size))
            arrays[name][..., kept] = state[name]
    tally.restore(arrays)


def _energies(tally: Tally) -> Array:
    """Places of the energies among all figures."""
    places = tally.views(np.arange(tally.sums.shape[1]))
    return np.concatenate([places[name].ravel() for name in ENERGIES])


FREE_PATHS = ("sums", "weights", "units")


MOVED = "moved_"
"""Before the names of what free paths have more than on a mesh of half the cells."""


def of_free_paths(paths: FreePaths, what: str = "") -> State:
    """The state of free paths, apart from others by `what`."""
    state = {f"{what}free_path_{name}": getattr(paths, name) for name in FREE_PATHS}
    return state | {f"{what}free_path_rays": np.array(paths.rays)}


def restore_free_paths(paths: FreePaths, state: State, what: str = "") -> None:
    """Put a state into empty free paths."""
    for name in FREE_PATHS:
        getattr(paths, name)[:] = state[f"{what}free_path_{name}"]
    paths.rays = int(state[f"{what}free_path_rays"])
