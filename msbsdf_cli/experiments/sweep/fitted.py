"""Walks of a sweep on slopes of facets, and on what is fitted to these."""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import ClassVar, Protocol

import numpy as np

from msbsdf_cli.experiments.fitted_walks import Models, Split, best_fit, kinds, models_of, walks_on
from msbsdf_cli.experiments.pilot import pilot
from msbsdf_cli.experiments.random_surfaces import Resolution, facet_slopes
from msbsdf_cli.experiments.sweep.states import State
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import OF_SURFACE
from surfaces.describe import Description
from surfaces.describe.fits import KINDS, fits
from surfaces.facet import Array

MODELS = OF_SURFACE, *(kind.name.replace("_", "-") for kind in KINDS)


class Facets(Protocol):
    """Where slopes of facets come from."""

    def slopes(self, scene: Scene) -> Array:
        """Slopes (2, nx, ny)."""
        ...

    def __hash__(self) -> int: ...


@dataclass(frozen=True)
class RandomFacets:
    """Those of random surfaces."""

    resolution: Resolution
    seed: int

    def slopes(self, scene: Scene) -> Array:
        """Slopes (2, n, n) of facets of the scene's roughness."""
        return facet_slopes(scene, self.resolution, self.seed)


FITS_S = 5.0
"""Seconds for fits, and for tables of what is counted and fitted, about."""


@lru_cache(maxsize=2)
def _models(facets: Facets, scene: Scene, gamma: float | None) -> tuple[Models, str]:
    """What is fitted, for all incident angles, and the name of the best."""
    slopes = facets.slopes(scene)
    return models_of(slopes, kinds(gamma)), best_fit(Description(fits(slopes), []))


@dataclass(frozen=True)
class FittedCase:
    """Walks of one incident angle on all of `MODELS`."""

    kind: ClassVar[str] = "fitted"
    shared: ClassVar[frozenset[str]] = frozenset(("slopes",))

    scene: Scene
    """Its slopes are not walked on."""
    facets: Facets
    slopes: str | None
    """Name of the distribution to be judged; None for the best."""
    gamma: float | None
    """Of Student's t; None where it is fitted."""
    samples: int
    seed: int
    precision: str
    max_order: int

    @property
    def parts(self) -> int:
        return 1

    @staticmethod
    def seconds(cases: list["FittedCase"]) -> float:
        # On the whole surface, and again on its pieces.
        walks = sum(2 * len(MODELS) * pilot(c.scene)[0] * c.samples for c in cases)
        return walks + FITS_S * len(cases)

    @staticmethod
    def measure(cases: list["FittedCase"], part: int) -> list[State]:
        # Cases whose walks are the same are one, whichever of the models is judged.
        found = {case.seed: case.walked() for case in {c.seed: c for c in cases}.values()}
        return [found[case.seed] | case.judged() for case in cases]

    def judged(self) -> State:
        """Which of the models is judged."""
        judged = self.slopes or self._models()[1]
        return {"judged": np.array([float(name == judged) for name in MODELS])}

    def _models(self) -> tuple[Models, str]:
        return _models(self.facets, replace(self.scene, theta=(0.0,)), self.gamma)

    def walked(self) -> State:
        """The light of all models."""
        models = self._models()[0]
        how = self.samples, self.seed, 1, self.precision, self.max_order, True
        walks = walks_on(self.scene, models, *how)
        of_models = [walks[name] for name in MODELS]
        return {
            "runs": np.array(1.0),
            "value": np.array([walk.value for walk in of_models]),
            "variance": np.array([walk.stderr**2 for walk in of_models]),
            "pieces": np.array([walk.pieces for walk in of_models]),
        }

    def walks(self, state: State) -> tuple[dict[str, Split], str]:
        """The light of each model, and the name of the one that is judged, in most of the runs."""
        runs = float(state["runs"])
        paths = round(runs * self.samples)
        light = zip(
            state["value"] / runs,
            np.sqrt(state["variance"]) / runs,
            state["pieces"] / runs,
            strict=True,
        )
        splits = (Split(*of_model, paths, walks=True) for of_model in light)
        return dict(zip(MODELS, splits, strict=True)), MODELS[int(np.argmax(state["judged"]))]
