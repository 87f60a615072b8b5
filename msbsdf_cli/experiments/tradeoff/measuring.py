"""Running every setting of every method over and over, in turns, and timing each run."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from msbsdf_cli.experiments.tradeoff.directions import Lobe
from msbsdf_cli.experiments.tradeoff.quasirandom import QuasiRandom, evaluate_quasirandom
from msbsdf_cli.methods.base import MethodBase
from msbsdf_cli.methods.protocol import Evaluation, Method
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import Beckmann
from surfaces.facet import Array
from surfaces.materials import Conductor
from surfaces.streams import generator, seed_sequence, stream

RESOLUTIONS = (0.1, 0.15, 0.2, 0.3)
"""Settings of `solve`, from errors that walks can reach to ones that they cannot."""

STEP = 4
"""Samples of a setting over those of the next cheaper one."""

FEWEST = 16

SETUPS = 3
"""Set-ups timed."""

DETERMINISTIC_RUNS = 5
"""Timed runs of a method without noise: more would tell no more about its error."""

SLOW_S = 0.3
"""After so many seconds two runs have to do for it."""

Quartiles = tuple[float, float, float]
"""Lower quartile, median, upper quartile of seconds."""


@dataclass(frozen=True)
class Setting:
    """A method and how much it is to do."""

    method: str
    samples: int = 0
    """Walks or paths; 0 for methods without noise."""
    resolution: float = float("nan")
    """Of `solve`."""
    one_by_one: bool = False
    """Whether to ask for one outgoing direction at a time, as a renderer does."""
    autocorrelation: str = "gaussian"
    """Of the surfaces that a method remembers."""

    @property
    def deterministic(self) -> bool:
        return METHODS[self.method].deterministic

    def make(self, scene: Scene) -> Method:
        """The method, set up but for what it puts off until its first evaluation."""
        arguments = scene.slopes, scene.material, scene.orders
        method: Method
        if self.method == "solve":
            method = Solve(*arguments, self.resolution)
        else:
            method = METHODS[self.method].on(*arguments, self.autocorrelation)
        return OneByOne(method) if self.one_by_one else method


class OneByOne(MethodBase):
    """A method that is asked for each outgoing direction anew, with samples of its own."""

    def __init__(self, method: Method) -> None:
        self.method, self.deterministic = method, method.deterministic

    def evaluate(self, wi: Array, wo: Array, samples: int, rng: np.random.Generator) -> Evaluation:
        found = [self.method.evaluate(wi, w[:, None], samples, rng) for w in wo.T]
        value, stderr = (
            np.concatenate([getattr(e, name) for e in found], axis=2)
            for name in ("value", "stderr")
        )
        return Evaluation(value, stderr, max(e.unresolved for e in found))

    def sample(self, wi: Array, n: int, rng: np.random.Generator) -> tuple[Array, Array]:
        return self.method.sample(wi, n, rng)

    def pdf(self, wi: Array, wo: Array) -> Array:
        return self.method.pdf(wi, wo)


def ladder(methods: tuple[str, ...], most: int, autocorrelation: str = "gaussian") -> list[Setting]:
    """The settings of all methods, each from its cheapest to its dearest of `most` samples."""
    samples = [most]
    while samples[0] // STEP >= FEWEST:
        samples.insert(0, samples[0] // STEP)
    settings = []
    for name in methods:
        if name == "solve":
            settings += [Setting(name, resolution=r) for r in RESOLUTIONS]
        elif METHODS[name].deterministic:
            settings.append(Setting(name))
        else:
            settings += [Setting(name, n, autocorrelation=autocorrelation) for n in samples]
    return settings


@dataclass
class Series:
    """What the repetitions of a setting for one lobe gave."""

    setting: Setting
    lobe: Lobe
    values: list[Array] = field(default_factory=list)
    """BSDF x cos(theta_o) of each repetition, (channels, orders + 1, n)."""
    seconds: list[float] = field(default_factory=list)
    """Of each repetition, without set-up."""
    setup_s: Quartiles = (0.0, 0.0, 0.0)

    @property
    def times(self) -> Quartiles:
        """Of the seconds."""
        return quartiles(self.seconds)


def quartiles(seconds: list[float]) -> Quartiles:
    """Quartiles of times."""
    low, middle, high = np.percentile(seconds, (25, 50, 75))
    return float(low), float(middle), float(high)


@dataclass(frozen=True)
class Protocol:
    """How often and with which numbers."""

    replicates: int
    seed: int
    qmc: bool = False
    purpose: str = "chart"
    """What is measured: each purpose has random streams of its own."""


def measure(
    scene: Scene,
    settings: list[Setting],
    lobes: list[Lobe],
    protocol: Protocol,
    advance: Callable[[float], None] = lambda amount: None,
) -> list[Series]:
    """A series for each lobe and setting. Rounds go through all of them in another order each, so
    that whatever slows the machine for a while slows all alike, and a run is never the first."""
    made = [set_up(setting, scene, lobes[0]) for setting in settings]
    series = [
        Series(setting, lobe, setup_s=setup)
        for lobe in lobes
        for setting, (_, setup) in zip(settings, made, strict=True)
    ]
    methods = [method for _ in lobes for method, _ in made]
    for r in range(-1, protocol.replicates):
        turn = protocol.purpose, r + 1
        order = stream(protocol.seed, "order of runs", *turn).permutation(len(series))
        for i in order:
            one = series[i]
            if one.setting.deterministic and (r < 0 or enough(one.seconds)):
                continue  # Its set-up was its first run.
            seed = seed_sequence(protocol.seed, "timed run", *turn, int(i))
            value, seconds = timed(methods[i], one.setting.samples, one.lobe, seed, protocol.qmc)
            if r >= 0:
                one.seconds.append(seconds)
                if not (one.setting.deterministic and one.values):
                    one.values.append(value)
        advance(1)
    return series


def enough(seconds: list[float]) -> bool:
    """Whether a method without noise was timed often enough."""
    slow = len(seconds) > 1 and sum(seconds) > SLOW_S
    return slow or len(seconds) >= DETERMINISTIC_RUNS


def timed(
    method: Method, samples: int, lobe: Lobe, seed: np.random.SeedSequence, qmc: bool = False
) -> tuple[Array, float]:
    """One evaluation of a lobe and the seconds it took, those of making random points included."""
    started = time.perf_counter()
    if qmc and not method.deterministic:
        value = evaluate_quasirandom(method, lobe.wi, lobe.wo, samples, QuasiRandom(seed))
    else:
        value = method.evaluate(lobe.wi, lobe.wo, samples, generator(seed)).value
    return value, time.perf_counter() - started


@cache
def _import(method: str) -> None:
    """Make a method once, in an easy scene: what it imports then is nobody's set-up."""
    METHODS[method](Beckmann(0.5, 0.5), Conductor(), 1)


def set_up(setting: Setting, scene: Scene, lobe: Lobe) -> tuple[Method, Quartiles]:
    """The method, ready, and quartiles of the seconds that took: what the first evaluation of one
    direction takes more than the second one, since some set-up waits for it."""
    seconds = []
    one = Lobe(lobe.theta, lobe.wi, lobe.wo[:, :1], lobe.solid_angle[:1])
    _import(setting.method)
    for _ in range(SETUPS):
        started = time.perf_counter()
        method = setting.make(scene)
        made = time.perf_counter() - started
        if setting.deterministic:
            unused = seed_sequence(0, "timed run", "set-up")
            first, second = (timed(method, 1, one, unused)[1] for _ in range(2))
            made += max(first - second, 0.0)
        seconds.append(made)
        if sum(seconds) > SLOW_S:
            break
    return method, quartiles(seconds)
