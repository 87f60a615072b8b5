"""What public functions refuse at once: arguments that could only give a wrong number."""

from collections.abc import Iterable
from numbers import Real

import numpy as np

from surfaces.facet import Array

UNIT = 1e-5
"""How far the length of a direction may be from 1: single precision keeps 1e-7 of it, and the
values that a wrong length spoils change by as much."""


def direction_in(w: Array, name: str = "wi") -> Array:
    """An incident direction: a unit vector (3,) above the horizon, as floats.

    Raises ValueError for anything else.
    """
    w = np.asarray(w)
    if w.shape != (3,):
        raise ValueError(f"{name} has the shape {w.shape}: one direction, (3,), is wanted.")
    w = _unit(w, name)
    if not w[2] > 0:
        raise ValueError(
            f"{name} has z = {w[2]:g}: a direction of incidence points away from the surface, "
            "z above 0."
        )
    return w


def directions_out(w: Array, name: str = "wo") -> Array:
    """Outgoing directions: unit vectors (3,) or (3, n) on either side, as (3, n) floats.

    Raises ValueError for anything else.
    """
    w = np.asarray(w)
    if w.ndim not in (1, 2) or w.shape[0] != 3:
        raise ValueError(f"{name} has the shape {w.shape}: directions are (3,) or (3, n).")
    return _unit(w, name).reshape(3, -1)


def count(n: float, name: str, least: int = 1, most: int | None = None) -> int:
    """A whole number from `least` to `most`. Raises ValueError for anything else."""
    if isinstance(n, Real) and np.isfinite(n) and n == int(n) and least <= n <= (most or n):
        return int(n)
    wanted = f"of at least {least}" if most is None else f"from {least} to {most}"
    raise ValueError(f"{name} is {n!r}: a whole number {wanted} is wanted.")


def kind_of(value: object, kind: type, what: str) -> None:
    """Raises ValueError for what is no `kind`; the sentence says `what` would be right."""
    if not isinstance(value, kind):
        raise ValueError(f"{what} is wanted, and not {type(value).__name__}.")


def one_of(value: str, names: Iterable[str], what: str) -> str:
    """One of some names. Raises ValueError for any other."""
    if value not in (known := tuple(names)):
        raise ValueError(f"{value!r} is not {what}: one of {', '.join(known)}.")
    return value


def _unit(w: Array, name: str) -> Array:
    if not np.issubdtype(w.dtype, np.floating):
        w = w.astype(float)
    if not np.isfinite(w).all():
        raise ValueError(f"{name} holds values that are not finite.")
    length = np.sqrt((w * w).sum(axis=0))
    if np.abs(length - 1).max(initial=0) > UNIT:
        raise ValueError(
            f"{name} has the length {float(np.max(length)):g}: directions are unit vectors."
        )
    return w
