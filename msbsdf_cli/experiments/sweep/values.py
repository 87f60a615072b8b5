"""Values of the BSDF of a sweep, by any method."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from msbsdf_cli.experiments.evaluate import EvaluationJob, Part, Values, part_sizes, run_job
from msbsdf_cli.experiments.pilot import pilot
from msbsdf_cli.experiments.slices import Slice, slice_table
from msbsdf_cli.experiments.sweep.states import LARGEST, State, total
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.results.files import Table
from msbsdf_cli.scene import Scene

EVALUATIONS_PER_S = 2e7
"""Rough rate of one core: walks times directions."""

UNRESOLVED, UNDERSAMPLED = f"{LARGEST}unresolved", f"{LARGEST}undersampled"


@dataclass(frozen=True)
class ValueCase:
    """Values of methods for one incident angle along a slice of outgoing directions."""

    kind: ClassVar[str] = "evaluate"
    shared: ClassVar[frozenset[str]] = frozenset(("theta",))
    """What `solve` sets up serves every angle."""

    scene: Scene
    methods: tuple[str, ...]
    directions: Slice
    samples: int
    seed: int
    precision: str
    bidirectional: bool
    autocorrelation: str = "gaussian"
    """Of the surfaces that a method remembers."""

    @property
    def parts(self) -> int:
        """A part for each method."""
        return len(self.methods)

    @staticmethod
    def seconds(cases: list["ValueCase"]) -> float:
        walks = sum(case.samples for case in cases) * max(pilot(cases[0].scene)[1], 1)
        return walks * cases[0].directions.wo.shape[1] / EVALUATIONS_PER_S

    @staticmethod
    def measure(cases: list["ValueCase"], part: int) -> list[State]:
        return [case.sums(part) for case in cases]

    def sums(self, part: int) -> State:
        """Sums over the parts of the samples of one method, in its place among those of all."""
        method, scene = self.methods[part], self.scene
        sizes = [1] if METHODS[method].deterministic else part_sizes(self.samples, 1)
        arithmetic = self.seed, self.precision, self.directions.wo
        how = *arithmetic, self.bidirectional, self.autocorrelation
        jobs = (EvaluationJob(scene, method, (0,), i, n, *how) for i, n in enumerate(sizes))
        sums = total(_sums(found) for job in jobs for found in run_job(job))
        return {name: in_place(array, part, self.parts) for name, array in sums.items()}

    def table(self, state: State) -> Table:
        """slice.csv of the case."""
        values = [
            _values(name, self.scene.theta[0], {key: a[i] for key, a in state.items()})
            for i, name in enumerate(self.methods)
        ]
        return slice_table(self.scene, self.directions, values)


def in_place(array: np.ndarray, place: int, of: int) -> np.ndarray:
    """An array in its place among `of` of them, whose others are 0."""
    found = np.zeros((of, *np.shape(array)))
    found[place] = array
    return found


def _sums(part: Part) -> State:
    """What adds up over parts, each of which counts as often as it has samples."""
    n, found = part.samples, part.evaluation
    value, stderr = found.value.astype(float), found.stderr.astype(float)
    all_orders = value.sum(axis=1)
    return {
        "parts": np.array(1.0),
        "samples": np.array(float(n)),
        "squares": np.array(float(n) ** 2),
        "values": n * value,
        "variances": (n * stderr) ** 2,
        "errors": n * stderr,
        "products": n * n * all_orders,
        "scatter": (n * all_orders) ** 2,
        UNRESOLVED: np.array(found.unresolved),
        UNDERSAMPLED: n * part.undersampled,
    }


def _values(method: str, theta: float, sums: State) -> Values:
    """Values and standard errors as `evaluate` has them: of the sum over orders, whose terms come
    from the same walks, from the scatter of the parts."""
    parts, n = float(sums["parts"]), float(sums["samples"])
    value = sums["values"] / n
    summed = value.sum(axis=1)
    if METHODS[method].deterministic:
        stderr = sums["errors"] / n
        of_total = stderr.sum(axis=1)
    else:
        undersampled = sums[UNDERSAMPLED] / n
        stderr = np.sqrt(sums["variances"]) / n
        stderr[:, 1:] = np.hypot(stderr[:, 1:], undersampled[:, None])
        of_total = stderr.sum(axis=1)
        if parts > 1:
            square = sums["scatter"] - 2 * summed * sums["products"] + summed**2 * sums["squares"]
            scatter = np.sqrt(np.maximum(square, 0) * parts / (parts - 1)) / n
            of_total = np.hypot(scatter, undersampled)
    value, stderr = (
        np.concatenate([a, t[:, None]], axis=1) for a, t in ((value, summed), (stderr, of_total))
    )
    return Values(method, theta, value, stderr, float(sums[UNRESOLVED]), 0.0)
