"""Which figure of which paper is made by what, and what the paper says of it.

Nothing heavy is imported before a figure is made.
"""

from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from msbsdf_cli.experiments.figures.settings import Settings, Tables


@dataclass(frozen=True)
class Figure:
    """A figure of a paper."""

    name: str
    """On the command line; files have underscores in it."""
    group: str
    """File in `experiments/figures` and `plots/figures`, in which functions have this name."""
    source: str
    shows: str
    says: str
    """What the paper says of it."""
    cheap: bool = False
    """Whether it takes a few seconds only."""

    def make(self, settings: "Settings") -> "Tables":
        """Its tables, by the names of their files."""
        return dict(self._function("experiments", "")(settings))

    def draw(self, tables: "Tables", directory: Path) -> None:
        """Its pictures, of its tables and nothing else."""
        self._function("plots", "draw_")(tables, directory)

    @property
    def drawn(self) -> bool:
        """Whether it has pictures."""
        return self.group != "claims"

    def _function(self, folder: str, prefix: str) -> Any:
        module = import_module(f"msbsdf_cli.{folder}.figures.{self.group}")
        return getattr(module, prefix + self.name.replace("-", "_"))


H, W = "[HHdD16]", "[WJFYHY22 supp.]"

FIGURES = {
    figure.name: figure
    for figure in (
        Figure(
            *("heitz-1", "pictures", f"{H} Figure 1", "a glass plate of textured roughness"),
            "single scattering loses significant energy where roughness is high; all orders "
            "conserve it, for 19 % more time",
        ),
        Figure(
            *("heitz-7", "areas", f"{H} Figure 7", "extinction over height and direction"),
            "the extinction coefficient of Eq. 24",
            cheap=True,
        ),
        Figure(
            *("heitz-8", "free_paths", f"{H} Figure 8", "the free-path density, and its escape"),
            "the density of Eq. 28, with a Dirac delta for light that leaves",
            cheap=True,
        ),
        Figure(
            *("heitz-10", "one_walk", f"{H} Figures 10, 12", "one random walk, facet by facet"),
            "each scattering event has a height, a direction and an energy",
            cheap=True,
        ),
        Figure(
            *("heitz-13", "free_paths", f"{H} Figure 13", "a surface on which light is traced"),
            "data are collected on instances of Beckmann surfaces",
            cheap=True,
        ),
        Figure(
            *("heitz-14", "free_paths", f"{H} Figure 14", "free paths on surfaces and modelled"),
            "alpha 1: the model is compared with simulated data, and shows good agreement",
            cheap=True,
        ),
        Figure(
            *("heitz-15", "lobes", f"{H} Figure 15", "lobes of alpha 0.1,1 at theta 1.5"),
            "the model accurately predicts both the albedo and the angular distribution",
        ),
        Figure(
            *("heitz-16", "pictures", f"{H} Figure 16", "white furnace tests"),
            "what absorbs nothing disappears",
        ),
        Figure(
            *("heitz-17", "pictures", f"{H} Figure 17", "bottles of several materials"),
            "multiple scattering is clearly visible, in 87 % more time",
        ),
        Figure(
            *("heitz-18", "pictures", f"{H} Figure 18", "gold of roughness 0.3"),
            "saturation increases notably, in 24 % more time",
        ),
        Figure(
            *("heitz-19", "pictures", f"{H} Figure 19", "rough diffuse facets and glass"),
            "colours saturate instead of darkening; 6, 50 and 62 % more time",
        ),
        Figure(
            *("heitz-20", "pictures", f"{H} Figure 20", "gold of textured roughness"),
            "with single scattering the albedo seems textured too; 27 % more time",
        ),
        Figure(
            *("heitz-sequences", "sequences", f"{H} Section 10", "lobes of R, T, TR, RT, TRT, ..."),
            "groups by sequence are simple each, and sum to the complex lobes of rough glass",
        ),
        Figure(
            *("wang-2", "areas", f"{W} Figure 2", "distant masking over the whole sphere"),
            "closed form and quadrature match very well; from below it exceeds 1",
            cheap=True,
        ),
        Figure(
            *("wang-4-15", "lobes", f"{W} Figures 4 to 15", "lobes: 12 surfaces, 4 angles"),
            "the height-correlated model is very similar to the walk, the uncorrelated one further "
            "off, mostly at grazing angles",
        ),
        Figure(
            *("wang-16", "reciprocity", f"{W} Figure 16", "a picture less that of swapped ends"),
            "the difference has expectation zero",
        ),
        Figure(
            *("wang-17", "slab", f"{W} Figure 17", "error over time on a slab"),
            "the position-free model is consistently better; two samples come very close to the "
            "truth",
        ),
        Figure(
            *("claims", "claims", "both papers", "every number and claim, published and measured"),
            "claims.csv: ours beside theirs, and whether it holds",
        ),
    )
}
