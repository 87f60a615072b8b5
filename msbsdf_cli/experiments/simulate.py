"""Light traced on one heightfield for one incident direction."""

import numpy as np

from msbsdf_cli.checks import count, direction_in, kind_of
from msbsdf_cli.experiments.own_surface import light_on, number_of_pieces, parts
from msbsdf_cli.model import described
from msbsdf_cli.results.result import Result
from msbsdf_cli.statistics.tally import MOST_ORDERS
from surfaces.facet import Array
from surfaces.field import HeightField
from surfaces.materials import Material
from surfaces.streams import stream


def simulate(
    field: HeightField,
    material: Material,
    wi: Array,
    rays: float = 1_000_000,
    seed: int = 0,
    orders: int = 4,
    max_order: int = 10_000,
) -> Result:
    """Trace `rays` rays from the unit vector `wi` (3,), z > 0, on a field that goes on and on.

    Rays start on the field's own heights; those that cross the sides of a patch meet its mirror
    images.

    Standard errors are over 16 or more pieces of the surface, so that they say how far another
    piece of the same kind of surface may be off, and not the noise of the rays alone. What is still
    under way after `max_order` facets, and rays that are lost, count as unresolved. Raises
    ValueError for what is out of range.
    """
    kind_of(field, HeightField, "a HeightField")
    kind_of(material, Material, "a material, such as Conductor(),")
    wi = direction_in(wi).astype(float)
    rays, orders = count(rays, "rays"), count(orders, "orders", most=MOST_ORDERS)
    seed, max_order = count(seed, "seed", 0), count(max_order, "max_order")
    number, windows = number_of_pieces(field)
    each, tallies = -(-rays // number), []
    for i, part in enumerate(parts(field, number, windows)):
        rng = stream(seed, "rays", i, 0)
        tallies.append(light_on(part, material, wi, each, rng, orders, max_order))
    settings = {
        "surface": field.fingerprint(),
        "material": described(material),
        "wi": wi.tolist(),
        "orders": orders,
        "max_order": max_order,
    }
    return Result(
        "simulate",
        settings,
        (seed,),
        np.array([t.sums[0] for t in tallies]),
        np.array([t.rays for t in tallies]),
        sum(t.facets for t in tallies),
    )
