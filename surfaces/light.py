"""Batches of light that leaves: what both producers, tracing and random walk, hand to a tally."""

from dataclasses import dataclass

from surfaces.facet import Array


@dataclass(frozen=True)
class Light:
    """Light after its last facet, all of the same order.

    `absorbed` energy is 1 - weight: every ray or walk starts with energy 1 and leaves once.
    """

    order: int
    """Number of facets hit."""
    w: Array
    """Directions of leaving, (3, n)."""
    weight: Array | None = None
    """Energy left in each channel, (channels, n); None: all of it."""
    transmitted: Array | None = None
    """Who leaves on the far side, (n,) of bool; None: nobody."""
    sequence: Array | None = None
    """History of reflections and transmissions, (n,), see `surfaces.light.append_event`."""
    resolved: bool = True
    """False: not followed to the end; `w` is then only where the light was going."""


def append_event(sequence: Array, transmitted: Array) -> Array:
    """History with one more facet: a binary number, 1 in front, then 0 for R and 1 for T."""
    return 2 * sequence + transmitted


def sequence_name(code: int) -> str:
    """`R`, `T`, `RT`, ... for a history."""
    return bin(code)[3:].replace("0", "R").replace("1", "T")
