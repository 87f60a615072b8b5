import numpy as np
import pytest

from msbsdf_cli.smith.slopes import Beckmann, Lambda
from msbsdf_cli.statistics.tally import Tally
from surfaces.field import HeightField
from surfaces.free_path import FreePathTracer, Level
from surfaces.heightfield import all_waves, synthesise
from surfaces.materials import Conductor, Dielectric, Diffuse
from surfaces.materials._metals import METALS
from surfaces.periodic import ESCAPED, meet, next_triangle
from surfaces.surface import Surface
from surfaces.tracing import Tracer, morton
from surfaces.views import Views


def make(seed=0, extent=8, cells=8):
    return Surface(synthesise(all_waves(extent, np.random.default_rng(seed)), extent, cells), cells)


def incident(theta, phi=0.0):
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


def trace(surface, alpha, material, wi, n, seed=1):
    tally = Tally(4, independent=False)
    tracer = Tracer(surface, surface.stretch(*alpha, np.arctan2(wi[1], wi[0])), material)
    for light in tracer.trace(wi, n, np.random.default_rng(seed), 1000):
        tally.add(light)
    return tally.as_unit()


@pytest.mark.parametrize("material", [Conductor(), Dielectric(1.5)])
def test_no_ray_is_lost_in_a_million(material):
    surface = make(extent=16)
    lost, left = 0.0, 0
    for theta in (0.0, 1.0, 1.5):
        tally = trace(surface, (1.0, 1.0), material, incident(theta, 0.3), 350_000)
        lost += tally.estimate("unresolved").value
        left += tally.rays
        total = tally.estimate("energy").value.sum()
        assert total == pytest.approx(1, abs=1e-12)  # none counted twice
    assert lost == 0
    assert left == 3 * 350_000


@pytest.mark.parametrize("material", [Conductor(METALS["gold"][:1]), Diffuse((0.4,))])
def test_energy_with_absorption(material):
    tally = trace(make(), (0.7, 0.2), material, incident(1.2), 20_000)
    energy, absorbed = tally.estimate("energy").value.sum(), tally.estimate("absorbed").value
    assert energy + absorbed == pytest.approx(1, abs=1e-12)
    assert absorbed > 0.01


@pytest.mark.parametrize("views", [1, 8])
def test_light_from_the_horizon_comes_down_to_the_surface(views):
    """With each period it falls by less than single precision can tell of a height."""
    surface = make(extent=8)
    tracer = Tracer(surface, surface.stretch(100.0, 100.0, 0.0), Conductor(), views)
    fall = 8 * 2 / 100 / np.tan(1.570796)
    assert fall < np.spacing(np.float32(surface.top)) / 2
    lights = list(tracer.trace(incident(1.570796), 200, np.random.default_rng(0), 1000))
    assert sum(light.w.shape[1] for light in lights) == 200
    met = [light for light in lights if light.resolved]
    assert all(light.order >= 1 and (light.w[2] > 0).all() for light in met)
    # Some are still above the highest facets after as many periods as are crossed.
    assert sum(light.w.shape[1] for light in met) > 0.8 * 200


def test_a_ray_that_comes_down_from_above_the_highest_point_goes_on():
    surface = make(extent=8)
    o, d = np.array([[1.0], [2.0], [surface.top + 1e-5]]), np.array([[0.85], [0.53], [-1e-7]])
    assert next_triangle(surface, o.copy(), d, None) >= 0
    d[2] = 0.0
    assert next_triangle(surface, o.copy(), d, None) == ESCAPED


def test_a_flat_surface_is_a_mirror():
    surface = Surface(np.zeros((16, 16)), 4)
    wi = incident(0.9, 1.1)
    tracer = Tracer(surface, surface.stretch(1.0, 1.0), Conductor())
    for light in tracer.trace(wi, 1000, np.random.default_rng(0), 5):
        assert light.order == 1
        np.testing.assert_allclose(light.w, np.array([[-wi[0]], [-wi[1]], [wi[2]]]) * np.ones(1000))


def test_a_flat_diffuse_surface_is_lambertian():
    surface = Surface(np.zeros((16, 16)), 4)
    n = 100_000
    tally = trace(surface, (1.0, 1.0), Diffuse(), incident(0.9), n)
    # Mean z of a cosine lobe is 2/3, with variance 1/2 - 4/9.
    mean_z = tally.estimate("moments").value[0, 0, 2]
    assert abs(mean_z - 2 / 3) < 4 * np.sqrt((1 / 2 - 4 / 9) / n)


def test_a_plane_that_embree_and_the_double_precision_hit_share():
    surface = make()
    rng = np.random.default_rng(5)
    o = np.stack([*(rng.random((2, 5000)) * surface.period), np.full(5000, surface.top)])
    d = np.tile([[0.3], [-0.8], [-0.4]], 5000)
    start = o.copy()
    triangle = next_triangle(surface, o, d, None)
    assert np.all(triangle >= 0)
    point, upper, _ = meet(surface, o, d, triangle)
    assert upper.all()
    # On the ray (mod the period), and on the mesh: heights interpolated on the facet's corners.
    along = (point[2] - start[2]) / d[2]
    apart = (start + along * d - point)[:2] / surface.period
    np.testing.assert_allclose(apart, np.rint(apart), atol=1e-9)
    corners, planes = surface.period_triangles
    heights = planes[0] + planes[1] * corners[:, 0] + planes[2] * corners[:, 1]
    np.testing.assert_allclose(heights, corners[:, 2], atol=1e-9)


def test_a_period_shifted_gives_the_same_light():
    """Edges do not matter: the surface rolled by half a period reflects the same energies."""
    heights = make(extent=8).heights
    n = 200_000
    results = []
    for field in (heights, np.roll(heights, (20, 31), (0, 1))):
        tally = trace(Surface(field, 8), (1.0, 1.0), Conductor(), incident(1.5), n)
        results.append(tally.estimate("energy").value[:, 0])
    noise = np.sqrt(2 * results[0] * (1 - results[0]) / n + 1 / n**2)
    assert np.all(np.abs(results[0] - results[1]) < 4 * noise)


@pytest.mark.parametrize("theta", [1.0, 1.4])
def test_masking_on_surfaces(theta):
    """The share of the mean plane's facets that a direction sees: the projected areas balance,
    cos(theta) = share seen x sigma, on any surface; 1 / (1 + Lambda) where sigma is the model's."""
    slopes = Beckmann(1.0, 1.0)
    w = incident(theta)
    seen = []
    for seed in range(24):
        surface = make(seed, extent=8)
        stretch = surface.stretch(1.0, 1.0, 0.0)
        rng = np.random.default_rng(seed)
        n = 40_000
        corners, planes = surface.period_triangles
        share = rng.random((2, n))
        chosen = rng.integers(0, corners.shape[2], n)
        # Uniform in the triangle, hence over the mean plane.
        fold = share.sum(axis=0) > 1
        share[:, fold] = 1 - share[:, fold]
        a, b, c = corners[..., chosen]
        point = a + share[0] * (b - a) + share[1] * (c - a)
        point[2] += surface.lift
        m = stretch.normals(planes[1:, chosen])
        cos = w @ m
        facing = cos > 0
        d = np.broadcast_to(stretch.to_grid(w[:, None]), point.shape)[:, facing]
        visible = next_triangle(surface, point[:, facing].copy(), d, None) == ESCAPED
        seen.append((cos[facing] * visible).sum() / cos[facing].sum())
    expected = 1 / (1 + Lambda(slopes, w[:, None])[0])
    stderr = np.std(seen, ddof=1) / np.sqrt(len(seen))
    assert abs(np.mean(seen) - expected) < 4 * stderr


def test_level_points_lie_on_the_surface_and_face_the_direction():
    surface = make(extent=8)
    stretch = surface.stretch(1.0, 1.0, 0.0)
    d = stretch.to_grid(incident(1.0)[:, None])[:, 0]
    points, weight = Level(surface, -0.5).points(d, 2000, np.random.default_rng(0))
    np.testing.assert_allclose(points[2], -0.5 + surface.lift, atol=1e-12)
    down = np.tile([[0.0], [0.0], [-1.0]], 2000)
    above = points + np.array([[0], [0], [1.0]])
    point, _, slopes = meet(surface, above, down, next_triangle(surface, above, down, None))
    np.testing.assert_allclose(point[2], -0.5, atol=1e-4)
    assert np.all(slopes[0] * d[0] + slopes[1] * d[1] < d[2] + 1e-3)
    assert weight > 0


def test_level_points_are_uniform_over_the_mean_plane():
    """Against points of a narrow band of heights, chosen uniformly: mean slope and its square."""
    surface = make(extent=8, cells=16)
    rng = np.random.default_rng(0)
    points, _ = Level(surface, 0.5).points(np.array([0.0, 0.0, 1.0]), 20_000, rng)
    corners, planes = surface.period_triangles
    middle = corners[:, 2].mean(axis=0)
    band = np.abs(middle - 0.5) < 0.05
    steep = np.hypot(*planes[1:])
    down = np.tile([[0.0], [0.0], [-1.0]], 20_000)
    above = points + np.array([[0], [0], [1.0]])
    _, _, slopes = meet(surface, above, down, next_triangle(surface, above, down, None))
    # A band 0.1 high holds some hundred facets of this field: their scatter bounds the match.
    stderr = steep[band].std() / np.sqrt(band.sum() / 16)
    assert abs(np.hypot(*slopes).mean() - steep[band].mean()) < 4 * stderr


def test_free_paths_from_outside_match_first_hits():
    surface = make(extent=8)
    stretch = surface.stretch(1.0, 1.0, 0.0)
    rng = np.random.default_rng(2)
    tracer = FreePathTracer(surface, Views(stretch, 1))
    paths = tracer.next_heights(-incident(0.0), np.inf, 20_000, rng)
    # Straight down, the next facet's height is the height itself.
    mean, stderr = surface.heights.mean(), surface.heights.std() / np.sqrt(20_000)
    assert paths.escaped == paths.lost == 0
    assert abs(paths.heights.mean() - mean) < 4 * stderr
    assert paths.shares.sum() == pytest.approx(1)
    up = tracer.next_heights(incident(0.3), np.inf, 1000, rng)
    assert up.escaped == pytest.approx(1)


def turned(surface, view):
    """The surface that the mesh is in one of its views, made of its own heights."""
    n = len(surface.heights)
    i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    for _ in range(view % 4):
        i, j = -j, i
    side = 1 if view < 4 else -1
    return Surface(side * surface.heights[i % n, j % n], surface.cells)


def test_a_field_of_an_odd_number_of_points_has_no_seam():
    """Triangles of an odd mesh would not fit where one period ends and the next begins, and light
    would be lost there."""
    heights = synthesise(all_waves(5, np.random.default_rng(1)), 5, 5)
    assert len(heights) == 25
    with pytest.raises(ValueError, match="odd"):
        Surface(heights, 5)
    field = HeightField(heights, (0.4, 0.4))
    assert len(HeightField.random(0.5, extent=5, cells=5).heights) == 25
    tally = Tally(4)
    tracer = Tracer(field.surface, field.stretch(0.3), Conductor())
    for light in tracer.trace(incident(1.0, 0.3), 20_000, np.random.default_rng(2), 1000):
        tally.add(light)
    assert tally.estimate("unresolved").value == 0


@pytest.mark.parametrize("material", [Conductor(), Dielectric(1.5)])
def test_views_are_the_surfaces_that_their_heights_make(material):
    """One mesh seen in eight ways against eight meshes, with as many rays on each."""
    surface, wi, rays = make(extent=4), incident(1.0, 0.4), 20_000
    stretch = surface.stretch(1.0, 0.5, 0.4)
    found = []
    for views, surfaces in ((8, [surface]), (1, [turned(surface, v) for v in range(8)])):
        tally = Tally(4)
        for view, mesh in enumerate(surfaces):
            tracer = Tracer(mesh, stretch, material, views)
            rng = np.random.default_rng(view)
            for light in tracer.trace(wi, 8 * rays // len(surfaces), rng, 10_000):
                tally.add(light)
        found.append([tally.estimate(name) for name in ("energy", "moments")])
    for one, other in zip(*found, strict=True):
        z = (one.value - other.value) / np.hypot(one.stderr, other.stderr)
        # Some 60 figures; rays that are spread evenly scatter less than their stated errors say.
        assert np.abs(z).max() < 4
    assert found[0][0].stderr[0, 0] < 0.002


def test_free_paths_of_views_are_those_of_the_surfaces():
    surface = make(extent=4)
    stretch, rng = surface.stretch(1.0, 0.5, 0.4), np.random.default_rng(3)
    d, edges = incident(1.2, 0.4), np.linspace(-3, 3, 7)
    for start in (-0.5, np.inf):
        way = d if np.isfinite(start) else -d
        mine = FreePathTracer(surface, Views(stretch)).next_heights(way, start, 80_000, rng)
        each = [
            FreePathTracer(turned(surface, v), Views(stretch, 1)).next_heights(
                way, start, 10_000, rng
            )
            for v in range(8)
        ]
        weight = np.array([e.weight for e in each])
        wanted = np.array([np.histogram(e.heights, edges, weights=e.shares)[0] for e in each])
        shares = np.histogram(mine.heights, edges, weights=mine.shares)[0]
        assert mine.weight == pytest.approx(weight.mean(), rel=0.02)
        # A share of 80000 rays, twice, is off by .0025 at most once in 15000.
        np.testing.assert_allclose(shares, weight @ wanted / weight.sum(), atol=0.01)
        assert mine.shares.sum() + mine.escaped == pytest.approx(1, abs=1e-4)


def first_order(extent, count, seed, alpha=0.5):
    """Energy of order 1 at grazing incidence, over independent fields, and its standard error."""
    surfaces = (make(seed + number, extent, cells=4) for number in range(count))
    energies = [
        trace(s, (alpha, alpha), Conductor(), incident(1.5, 0.4), 8000, seed + i)
        .estimate("energy")
        .value[0, 0]
        for i, s in enumerate(surfaces)
    ]
    return np.mean(energies), np.std(energies, ddof=1) / np.sqrt(count)


def test_light_crosses_a_short_period_without_meeting_the_same_line_again():
    """Grazing light crosses a period of 6 correlation lengths several times. Along an axis of the
    grid it would meet the same heights again, and lose a third of its second bounces."""
    (short, short_stderr), (long, long_stderr) = first_order(6, 120, 0), first_order(24, 15, 1000)
    noise = np.hypot(short_stderr, long_stderr)
    assert 4 * noise < 0.0075, "the axis would be .009 off"
    assert abs(short - long) < 4 * noise


def test_morton_curve_covers_the_square_evenly():
    points = morton((np.arange(4096) + 0.5) / 4096)
    counts = np.histogram2d(*points, bins=64, range=[(0, 1), (0, 1)])[0]
    assert np.all(counts == 1)
    assert np.hypot(*np.diff(points, axis=1)).mean() < 2 / 64


def test_rays_that_are_not_finite_are_refused():
    surface = make(extent=4, cells=4)
    with pytest.raises(FloatingPointError, match="not finite"):
        surface.query(np.full((3, 1), np.nan), np.ones((3, 1)))


def test_surfaces_never_import_the_models():
    import subprocess
    import sys

    code = (
        "import sys, surfaces.tracing, surfaces.free_path, surfaces.heightfield;"
        "sys.exit(any(m.startswith('msbsdf_cli') for m in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_ray_starts_again_so_near_its_facet_that_it_makes_no_difference():
    """Ten times the lift changes nothing that can be seen; were it a thousand times what single
    precision asks for, light of many bounces would leave its valleys early."""
    energies = []
    for share in (1.0, 10.0):
        surface = make(extent=16)
        surface.lift *= share
        tally = trace(surface, (1.0, 1.0), Conductor(), incident(1.0, 0.3), 400_000)
        energies.append(tally.estimate("energy").value[:, 0])
    # Fewer than 1 ray in 100 goes elsewhere, as often from one order to the next as back.
    assert np.abs(energies[0] - energies[1]).max() < 4 * np.sqrt(0.01 / 400_000)
