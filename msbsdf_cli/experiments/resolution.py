"""How finely and how often to make a surface: no more than the scene and the accuracy need.

The rules were measured with mirror facets, alpha 0.1 to 1, theta 0 to 1.5, by holding fields
against the same fields on finer meshes, and short periods against long ones; `reports/trust.md`
shows them. They are for the energies of single orders, and rest on the share of light that the
Smith model sends to a second facet: where that is nothing, a mesh of any fineness gives the same
answer.
"""

import math

from msbsdf_cli.experiments.random_surfaces import Resolution
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.walk import random_walk
from msbsdf_cli.statistics.discretisation import moved_by_period
from surfaces.marginal import GAUSSIAN_HEIGHTS, Marginal, marginal
from surfaces.materials import Conductor, Material
from surfaces.spectrum import GAUSSIAN, Spectrum, spectrum
from surfaces.streams import stream

PILOT_WALKS = 20_000
LEAST_CELLS, LEAST_EXTENT, LEAST_REALISATIONS = 16, 12, 16
"""The least mesh, period and sample of surfaces. Light of many bounces is carried along in smooth
valleys, which coarse facets break: its energy is right to 30 % on 8 cells, to 7 % on 16. With 16
realisations a standard error is known to within 18 %."""

LEAST_RAYS = 1_000_000
"""For each incident angle, since there is a lobe to fill as well."""


def rays(resolution: Resolution) -> int:
    """Rays for each incident angle that give about the least variance a second.

    A surface costs as much as it has cells, (cells extent)^2, and its variance is as 1 / extent^2,
    in correlation lengths; a ray costs and varies the same on all. So as many rays belong on a
    surface as sqrt(variance of a ray / variance of a surface x cost of a surface / cost of a ray),
    which goes as cells extent^2. Measured on 16 cells and 16 lengths, variance times seconds with
    2000, 8000, 31000 and 125000 rays: 201, 70, 55 and 80 for the second order of a mirror of alpha
    1 at theta 0; 50, 21, 5 and 6 for the first of alpha 0.5 at theta 1; 336, 336, 412 and 747 for
    glass of alpha 1 at theta 1.5, the worst of all.
    """
    each = 30_000 * (resolution.cells / 16) * resolution.extent * resolution.lengths / 16**2
    return max(LEAST_RAYS, round(each * resolution.realisations))


def plan(
    scene: Scene,
    accuracy: float,
    cells: int | None,
    extent: int | None,
    realisations: int | None,
    waves: int | None,
    autocorrelation: str = "gaussian",
    heights_of: str = "gaussian",
) -> Resolution:
    """The resolution that keeps each bias below half of `accuracy` and the standard error of the
    energy of an order near `accuracy`; what is given is taken as it is.

    Rules that were measured on Gaussian autocorrelations hold for others in what they come from:
    facets that lack as much of the slopes' variance, and as many correlation lengths. No order's
    energy is further than .001 from that on 60 cells on the 16 to 36 that come out for exponential,
    matern:1.5 and power-law:0.8 (mirror, alpha 0.5 and 1, theta 0, 1, 1.5, noise .0005).
    """
    kind, heights_are = spectrum(autocorrelation), marginal(heights_of)
    length = heights_are.correlation_length(kind)
    share = max(multiple_share(scene, m) for m in {Conductor(), scene.material})
    any_multiple = min(1.0, 40 * share)
    if cells is None:
        per_cell2 = 0.25 * share + 0.03 * any_multiple
        like = 2 * math.ceil(max(2, math.sqrt(2 * per_cell2 / accuracy) / 2))
        cells = max(LEAST_CELLS, as_fine(kind, like, heights_are))
    if extent is None:
        extent = 2 * math.ceil(LEAST_EXTENT * length / 2)
        while 2 * moved_by_period(extent / length) * any_multiple > accuracy:
            extent += 2
    if realisations is None:
        # Which facet lets light through is decided at grazing by few high places.
        spread = 0.3 if scene.material.transmits else 0.17
        deviation = spread * math.sqrt(share) * length / extent
        realisations = max(LEAST_REALISATIONS, math.ceil((deviation / accuracy) ** 2))
    return Resolution(cells, extent, realisations, waves, autocorrelation, heights_of)


def as_fine(kind: Spectrum, cells: int, heights_are: Marginal = GAUSSIAN_HEIGHTS) -> int:
    """Cells, an even number, whose facets lack no more of the slopes' variance than those of so
    many cells do with a Gaussian autocorrelation of Gaussian heights."""

    def has(number: int) -> float:
        apart = kind.chord_variance(number) / number**2
        variance = float(heights_are.half_structure(1.0, apart)) * number**2
        return variance / heights_are.slope_variance

    enough = cells
    while has(enough) < GAUSSIAN.chord_variance(cells) - ROUNDING:
        enough += 2
    return enough


ROUNDING = 1e-9
"""Of a variance over a cell, which is 1 less little."""


def multiple_share(scene: Scene, material: Material) -> float:
    """Largest share of light, over the incident angles, that facets of `material` send to a second
    facet, from a short random walk."""
    shares = []
    for i, theta in enumerate(scene.theta):
        # Of the seed 0 always: a seed does not change the resolution.
        rng = stream(0, "pilot walks", material.name, i)
        wi = scene.wi(theta)
        walks = random_walk(scene.slopes, material, wi, PILOT_WALKS, rng, 1)
        shares.append(sum(light.w.shape[1] for light in walks if not light.resolved) / PILOT_WALKS)
    return max(shares)
