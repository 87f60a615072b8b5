"""Mitsuba's plugin `measured` with the file that `msbsdf export` writes."""

import numpy as np
import pytest
from chi_square import chi_square_p

import msbsdf_cli as ms
from msbsdf_cli.renderers.measured import (
    evaluate_measurements,
    measured_error,
    measurements,
    write_tensors,
)
from msbsdf_cli.renderers.nodes import Nodes
from msbsdf_cli.renderers.tables import BsdfTable
from msbsdf_cli.renderers.tabulate import make_table
from surfaces.materials import Conductor, Diffuse

mi = pytest.importorskip("mitsuba")

CASES = {
    "mirror": (ms.Beckmann(0.5, 0.5), Conductor(), None),
    "gold": (ms.Ggx(0.2, 0.2), Conductor.named("gold", rgb=True), None),
    "diffuse": (ms.Ggx(1, 1), Diffuse((0.9, 0.5, 0.1)), Nodes(16, 16)),
}


@pytest.fixture(scope="module", params=CASES)
def both(request, tmp_path_factory):
    """A table, the fields made of it, and Mitsuba's plugin with the file."""
    mi.set_variant("scalar_rgb")
    slopes, material, nodes = CASES[request.param]
    table: BsdfTable = make_table(slopes, material, 2, True, nodes)
    path = tmp_path_factory.mktemp("measured") / "measured.bsdf"
    fields = measurements(table)
    write_tensors(path, fields)
    return table, fields, mi.load_dict({"type": "measured", "filename": str(path)})


def interaction(wi):
    si = mi.SurfaceInteraction3f()
    si.wi = mi.Vector3f(*map(float, wi))
    return si


def test_values_are_as_far_from_the_table_as_stated(both):
    """Mitsuba's are those that are computed here, in single precision, and within a percent for
    GGX slopes; Beckmann's distribution falls off too steeply for a grid of so few nodes."""
    table, fields, bsdf = both
    assert measured_error(table, fields).max() < (0.03 if table.slopes.name == "beckmann" else 0.01)
    rng, ctx = np.random.default_rng(0), mi.BSDFContext()
    for _ in range(20):
        cos, phi = rng.uniform(np.cos(1.4), 1, 9), rng.uniform(0, 2 * np.pi, 9)
        sin = np.sqrt(1 - cos**2)
        w = np.array([sin * np.cos(phi), sin * np.sin(phi), cos])
        mine = evaluate_measurements(fields, np.tile(w[:, :1], 8), w[:, 1:])
        si = interaction(w[:, 0])
        found = [np.ravel(bsdf.eval(ctx, si, mi.Vector3f(*map(float, o)))) for o in w[:, 1:].T]
        np.testing.assert_allclose(np.array(found).T, mine, rtol=1e-3, atol=1e-6)


@pytest.mark.parametrize("theta", [0.3, 1.2])
def test_samples_follow_the_density_and_carry_the_energy(both, theta):
    """In 8 x 12 bins of even solid angle; the density's integrals by 6 x 6 midpoints of each."""
    table, _, bsdf = both
    wi, ctx, n = ms.direction(theta, 0.7), mi.BSDFContext(), 10_000
    si, rng = interaction(wi), np.random.default_rng(1)
    found, weights = [], []
    for u in rng.random((n, 2)).tolist():
        bs, weight = bsdf.sample(ctx, si, 0.5, mi.Point2f(*u))
        found.append(list(bs.wo))
        weights.append(np.ravel(weight)[0])
    w = np.array(found).T
    above = w[2] > 0
    row = np.minimum((w[2, above] * 8).astype(int), 7)
    column = np.floor((np.arctan2(w[1], w[0])[above] / (2 * np.pi) + 0.5) * 12).astype(int) % 12
    counts = np.bincount(row * 12 + column, minlength=96)
    z, phi = (np.arange(48) + 0.5) / 48, 2 * np.pi * ((np.arange(72) + 0.5) / 72 - 0.5)
    sin = np.sqrt(1 - z * z)
    x, y = (np.outer(sin, f(phi)).ravel() for f in (np.cos, np.sin))
    grid = zip(x.tolist(), y.tolist(), np.repeat(z, 72).tolist(), strict=True)
    density = np.array([bsdf.pdf(ctx, si, mi.Vector3f(*w)) for w in grid])
    share = density.reshape(8, 6, 12, 6).mean(axis=(1, 3)).ravel() * 2 * np.pi / 96
    counts, expected = np.append(counts, n - counts.sum()), n * np.append(share, 1 - share.sum())
    assert chi_square_p(counts, np.maximum(expected, 0)) > 1e-4
    energy = ms.walk(ms.Smith(table.slopes, table.material), wi, 200_000).energy.sum()
    weights = np.where(above, weights, 0)
    assert abs(weights.mean() - energy) < 4 * weights.std() / np.sqrt(n) + 0.01
