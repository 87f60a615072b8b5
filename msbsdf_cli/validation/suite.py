"""Every identity in every configuration: from the list to the verdicts."""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.run.executors import map_ordered
from msbsdf_cli.run.progress import Progress
from msbsdf_cli.statistics.multiple_testing import Finding
from msbsdf_cli.validation import (
    bsdf,
    explicit,
    free_paths,
    height_walk,
    histogram,
    intersection,
    one_way,
    phase,
    position_free,
    reciprocity,
    shading,
    solved,
    visible_normals,
)
from msbsdf_cli.validation.configurations import Configuration
from msbsdf_cli.validation.identity import Identity
from surfaces.streams import stream

SECTIONS = (
    intersection,
    free_paths,
    one_way,
    visible_normals,
    phase,
    bsdf,
    shading,
    reciprocity,
    solved,
    height_walk,
    position_free,
    histogram,
    explicit,
)
IDENTITIES: tuple[Identity, ...] = tuple(i for section in SECTIONS for i in section.IDENTITIES)

QUICK_DRAWS = 3
"""A quick run draws one random configuration where a full run draws so many."""


@dataclass(frozen=True)
class Job:
    """One identity in one configuration."""

    number: int
    """Of the identity in `IDENTITIES`."""
    configuration: Configuration
    place: int
    """Among the identity's configurations."""
    samples: int
    seed: int


@dataclass(frozen=True)
class Suite:
    """Everything that was measured, and how long it took."""

    findings: list[Finding]
    samples: int
    """Samples drawn, as asked for; an identity may draw several numbers for each."""
    wall_s: float


def measure(
    samples: int,
    seed: int,
    threads: int,
    quick: bool,
    quiet: bool,
    identities: Sequence[Identity] = IDENTITIES,
) -> Suite:
    """All findings; the numbers depend on `seed`, not on `threads`."""
    started = time.monotonic()
    jobs = list(plan(samples, seed, quick, identities))
    cost = [IDENTITIES[job.number].cost for job in jobs]
    findings: list[Finding] = []
    with Progress("validate", sum(cost), "configurations", quiet) as progress:
        for some, amount in zip(map_ordered(run, jobs, threads), cost, strict=True):
            findings += some
            progress.advance(amount)
    return Suite(findings, sum(job.samples for job in jobs), time.monotonic() - started)


def plan(
    samples: int, seed: int, quick: bool, identities: Sequence[Identity] = IDENTITIES
) -> Iterator[Job]:
    """The configurations of each identity, the fixed ones first."""
    for identity in identities:
        number = IDENTITIES.index(identity)
        rng = _generator(seed, identity, 0)
        configurations = identity.hard()[:: identity.thin if quick else 1]
        if identity.drawn is not None:
            draws = -(-identity.draws // QUICK_DRAWS) if quick else identity.draws
            configurations += [identity.drawn(rng) for _ in range(draws)]
        for place, configuration in enumerate(configurations, 1):
            size = max(int(samples * identity.share), identity.least)
            yield Job(number, configuration, place, size, seed)


def run(job: Job) -> list[Finding]:
    """The findings of one job."""
    identity = IDENTITIES[job.number]
    rng = _generator(job.seed, identity, job.place)
    return list(identity.measure(job.configuration, job.samples, rng))


def _generator(seed: int, identity: Identity, place: int) -> np.random.Generator:
    """Streams by the identity's name, so that a new identity leaves the others' numbers alone."""
    return stream(seed, "identity", name(identity), place)


def name(identity: Identity) -> str:
    """What tells an identity from all others."""
    return f"{identity.measure.__module__}.{identity.measure.__name__}"
