"""Random surfaces, one after the other: how finely they are made, and how their facets slope."""

from dataclasses import dataclass, replace

import numpy as np

from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes.surface import Surface as OwnSlopes
from surfaces.facet import Array
from surfaces.heightfield import all_waves, some_waves, synthesise
from surfaces.marginal import marginal
from surfaces.spectrum import spectrum
from surfaces.streams import stream
from surfaces.surface import Surface


@dataclass(frozen=True)
class Resolution:
    """How finely and how often the surface is made."""

    cells: int
    """Mesh cells a unit of length, in which slopes have variance 2: for the Gaussian spectrum the
    correlation length."""
    extent: int
    """Period, in that unit."""
    realisations: int
    waves: int | None = None
    """Cosines summed; None: every wave of the period's lattice."""
    autocorrelation: str = "gaussian"
    """Of the heights, as `surfaces.spectrum.spectrum` has it."""
    heights_of: str = "gaussian"
    """How heights are distributed, as `surfaces.marginal.marginal` has it."""

    @property
    def lengths(self) -> float:
        """The period in correlation lengths."""
        return self.extent / marginal(self.heights_of).correlation_length(
            spectrum(self.autocorrelation)
        )

    @property
    def skewed(self) -> bool:
        """Whether heights are not Gaussian, and slopes not Beckmann's."""
        return marginal(self.heights_of).skewness != 0


def realisation(resolution: Resolution, number: int, seed: int) -> Surface:
    """Realisation `number` of the surface; the same field for any number of cells."""
    field = number, resolution.extent, resolution.waves or 0
    return make_surface(resolution, stream(seed, "heightfield", *field))


def make_surface(resolution: Resolution, rng: np.random.Generator) -> Surface:
    """A random surface; from generators in the same state the same field for any cells."""
    kind, heights_are = spectrum(resolution.autocorrelation), marginal(resolution.heights_of)
    if resolution.waves is None:
        amplitudes = all_waves(resolution.extent, rng, kind)
    else:
        amplitudes = some_waves(resolution.extent, resolution.waves, rng, kind)
    heights = heights_are.heights(synthesise(amplitudes, resolution.extent, resolution.cells))
    return Surface(heights, resolution.cells, spectrum=kind, marginal=heights_are)


SIDE_BY_SIDE = 4
"""Realisations along either side of an array of slopes."""

CELLS_OF_SLOPES = 8
"""Facets in 2 / alpha whose slopes are counted: what lies between is like them."""


def facet_slopes(scene: Scene, resolution: Resolution, seed: int) -> Array:
    """Slopes (2, n, n) of facets, `SIDE_BY_SIDE` realisations each way, over again where there are
    fewer; scaled to the roughness of the scene, which realisations have in the mean."""
    number, meshes = min(SIDE_BY_SIDE**2, resolution.realisations), []
    every = max(resolution.cells // CELLS_OF_SLOPES, 1)
    for i in range(number):
        surface = realisation(resolution, i, seed)
        side = len(range(0, len(surface.heights), every))
        # Isotropic on the grid, they need no turning there.
        slopes = surface.stretch(*scene.alpha).normals(surface.slopes(every))[:2]
        meshes.append(-slopes.reshape(2, side, side))
    rows = [
        np.concatenate([meshes[(SIDE_BY_SIDE * i + j) % number] for j in range(SIDE_BY_SIDE)], 2)
        for i in range(SIDE_BY_SIDE)
    ]
    slopes = np.concatenate(rows, axis=1)
    slopes -= slopes.mean(axis=(1, 2), keepdims=True)
    alpha = np.sqrt(2 * (slopes**2).mean(axis=(1, 2)))
    return np.asarray(slopes * (np.array(scene.alpha) / alpha)[:, None, None])


def counted(slopes: Array, alpha: tuple[float, float]) -> OwnSlopes:
    """Slopes (2, ...) of facets of random surfaces of the roughness `alpha`, counted; over that
    they are the same in every direction, so that they count turned by quarters of a circle too."""
    x, y = slopes.reshape(2, -1) / np.array(alpha)[:, None]
    turned = np.stack([np.concatenate([x, -y, -x, y]), np.concatenate([y, x, -y, -x])])
    return replace(OwnSlopes.of(turned), alpha_x=alpha[0], alpha_y=alpha[1])
