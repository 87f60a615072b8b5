"""Pictures against closed forms, against each other, and in light that they cannot lose."""

from dataclasses import replace
from functools import cache
from importlib import import_module

import numpy as np
import pytest
import trimesh

from msbsdf_cli.experiments.render.body import Body, local, world
from msbsdf_cli.experiments.render.camera import Camera
from msbsdf_cli.experiments.render.claims import _verdict
from msbsdf_cli.experiments.render.lights import Lamp, Lights
from msbsdf_cli.experiments.render.paths import Integrator, Shader
from msbsdf_cli.experiments.render.picture import Settings, luminance, render, table_of
from msbsdf_cli.experiments.render.scenes import NAMES, defaults, stage
from msbsdf_cli.methods.published import method as published
from msbsdf_cli.methods.registry import METHODS, holds
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.plots.render import displayed
from msbsdf_cli.scene import direction
from msbsdf_cli.smith.albedo import first_order_albedo
from msbsdf_cli.smith.slopes import Beckmann, Ggx
from surfaces.facet import dot
from surfaces.materials import Conductor, Dielectric, Diffuse

GOLD = Conductor.named("gold", rgb=True)
SMALL = Settings(24, 16, 64)
LIMIT = 4.5
"""Standard errors: of the 1500 blocks of this file's pictures one would be further off in 100 runs,
were they Gaussian; blocks are means of hundreds of paths."""


staged = cache(stage)


def picture(scene, material, method, settings=SMALL, slopes=None, texture="none", lights=None):
    of = staged(scene, texture)
    if lights is not None:
        of = replace(of, lights=lights)
    return render(of, slopes or Ggx(0.6, 0.6), material, (method,), settings, 1, True)[0]


def blocks(p):
    """Means of blocks of 4 by 4 pixels and their standard errors."""
    c, h, w = p.mean.shape
    parts = [a.reshape(c, h // 4, 4, w // 4, 4) for a in (p.mean, p.stderr**2)]
    return parts[0].mean(axis=(2, 4)), np.sqrt(parts[1].sum(axis=(2, 4))) / 16


def assert_same(one, other, slack=0.0):
    (a, sa), (b, sb) = blocks(one), blocks(other)
    assert (np.abs(a - b) <= LIMIT * np.hypot(sa, sb) + slack + 1e-12).all()


WHITE = {
    "mirror": (Conductor(), ("walk", "exact", "energy-compensated", "turquin")),
    "glass": (Dielectric(1.5), ("walk", "walk-low-variance", "position-free-uncorrelated")),
    "diffuse": (Diffuse(), ("walk", "position-free-correlated")),
}


@pytest.mark.parametrize(
    ("kind", "method"), [(kind, name) for kind, of in WHITE.items() for name in of[1]]
)
def test_a_textured_plate_stays_white_in_white_light(kind, method):
    material = WHITE[kind][0]
    assert METHODS[method].traits.conserves_energy
    # Samples of the lights hardly ever find what all but smooth glass sends where.
    settings = replace(SMALL, strategy="bsdf" if material.transmits else "mis")
    slopes, white = Ggx(1.0, 1.0), {"texture": "roughness", "lights": Lights()}
    p = picture("plate", material, method, settings, slopes, **white)
    mean, stderr = blocks(p)
    # What compensation leaves undone is what its tables are off by.
    slack = METHODS[method].traits.slack(material.name)
    assert (np.abs(mean - 1) <= LIMIT * stderr + slack + 1e-12).all()


def test_single_scattering_makes_the_texture_visible():
    p = picture("plate", Dielectric(1.5), "single", texture="roughness", lights=Lights())
    mean, stderr = blocks(p)
    assert (1 - mean).max() > 20 * stderr.max()


@pytest.mark.parametrize(
    ("scene", "material", "texture"),
    [
        ("plate", Dielectric(1.5), "none"),
        ("plate", GOLD, "roughness"),
        ("plate", Conductor(), "anisotropy"),
        ("bottle", Diffuse((0.9, 0.5, 0.2)), "none"),
        ("plate", Diffuse((0.5, 0.5, 0.5)), "albedo"),
    ],
)
def test_methods_of_one_model_and_all_strategies_give_one_picture(scene, material, texture):
    first = picture(scene, material, "walk", texture=texture)
    others = [("walk", "bsdf"), ("walk-low-variance", "mis")]
    if texture in ("none", "albedo"):
        # Lights alone hardly find the lobe of what is all but smooth.
        others.append(("walk", "light"))
    if holds("exact", Ggx(0.6, 0.6), material):
        others.append(("exact", "mis"))
    for name, strategy in others:
        settings = replace(SMALL, strategy=strategy, seed=1)
        assert_same(first, picture(scene, material, name, settings, texture=texture))


def facing(theta):
    """A plate under a camera at such a distance that all rays come from polar angle `theta`."""
    eye = tuple(200 * direction(theta, -np.pi / 2))
    return replace(stage("plate"), lights=Lights(), camera=Camera(eye, (0, 0, 0.04), 0.002))


def test_a_mirror_in_white_light_is_as_bright_as_its_albedo():
    theta, slopes = 1.1, Beckmann(0.7, 0.7)
    p = render(facing(theta), slopes, Conductor(), ("single",), Settings(8, 8, 400), 1, True)[0]
    truth = first_order_albedo(slopes, Conductor(), direction(theta)[:, None])[0]
    stderr = np.sqrt((p.stderr[0] ** 2).mean() / 64)
    assert stderr < 0.003
    # The view is .002 wide, over which the albedo changes by less than .001.
    assert p.mean[0].mean() == pytest.approx(truth, abs=LIMIT * stderr + 1e-3)


def test_an_albedo_texture_has_a_power_for_each_bounce():
    theta, slopes = 0.9, Beckmann(0.8, 0.8)
    of = facing(theta)
    textured = replace(of, texture=replace(stage("plate", "albedo"), lights=Lights()).texture)
    p = render(textured, slopes, Diffuse(), ("walk",), Settings(8, 8, 400), 1, True)[0]
    energy = Solve(slopes, Diffuse(), 10).energy(direction(theta)).reflected[0]
    x = textured.texture(np.zeros((3, 1)), slopes).albedos[:, 0]
    truth = [(energy * a ** np.arange(1, 12)).sum() for a in x]
    stderr = np.sqrt((p.stderr**2).mean(axis=(1, 2)) / 64)
    # In the middle of the plate, where the view looks, the ramp changes the albedo by .002 at most.
    assert np.abs(p.mean.mean(axis=(1, 2)) - truth) == pytest.approx(
        0, abs=LIMIT * stderr.max() + 2e-3
    )


def test_glass_disappears_as_a_closed_body():
    p = picture("furnace", Dielectric(1.5), "walk", replace(SMALL, strategy="bsdf"))
    assert p.mean == pytest.approx(1, abs=1e-12)
    assert p.lost == 0
    # More surfaces than paths: light is thrown to and fro inside.
    assert p.surfaces > p.samples * p.mean[0].size


def test_what_a_method_cannot_do_is_counted(monkeypatch):
    """Walks cut off at their second facet leave the sphere as dark as single scattering does, and
    are as many as the light that is missing."""
    slopes, of = Beckmann(1.0, 1.0), stage("furnace")
    method = published.Published(slopes, Conductor(), 1, most_facets=1)
    integrator = Integrator(of, Shader(slopes, method), "bsdf")
    x, y = np.random.default_rng(0).random((2, 4000))
    o = np.tile(np.array(of.camera.eye)[:, None], x.size)
    found = integrator.radiance(o, of.camera.rays(x, y), np.random.default_rng(1))
    assert integrator.counts.cut > 100
    # Paths that go on carry all of their light or none, on a body whose surfaces see no other.
    assert integrator.counts.cut == np.count_nonzero(found[0] == 0)
    assert integrator.counts.nonfinite == 0
    search = published.visible_normals
    monkeypatch.setattr(published, "visible_normals", lambda *a: (search(*a)[0], 3))
    integrator.radiance(o, of.camera.rays(x, y), np.random.default_rng(1))
    assert integrator.counts.nonfinite == method.hidden > 0


def test_a_sphere_of_two_roughnesses_is_lit_from_all_azimuths():
    """By symmetry left and right are the same, and a quarter turn is not."""
    slopes = Ggx(1.0, 0.1)
    p = picture("sphere", Conductor(), "single", Settings(48, 40, 64), slopes, lights=Lights())
    assert_same(p, replace(p, mean=p.mean[:, :, ::-1], stderr=p.stderr[:, :, ::-1]))
    turned = picture(
        "sphere", Conductor(), "single", Settings(48, 40, 64), Ggx(0.1, 1.0), lights=Lights()
    )
    assert np.abs(p.mean - turned.mean).max() > 0.1


def test_lights_are_sampled_by_their_density(rng):
    lamps = (
        Lamp((0.0, 0.6, 0.8), 9.0, (3.0, 2.0, 1.0)),
        Lamp((1.0, 0.0, 0.0), 300.0, (40.0, 40.0, 50.0)),
    )
    lights = Lights((1.0, 1.0, 1.0), (0.1, 0.2, 0.3), lamps)
    n = 200_000
    z = 1 - 2 * rng.random(n)
    phi = 2 * np.pi * rng.random(n)
    even = np.stack([np.sqrt(1 - z * z) * np.cos(phi), np.sqrt(1 - z * z) * np.sin(phi), z])
    density = lights.pdf(even) * 4 * np.pi
    assert density.mean() == pytest.approx(1, abs=5 * density.std() / np.sqrt(n))
    w = lights.sample(n, rng)
    assert dot(w, w) == pytest.approx(1, abs=1e-12)
    for power in (1, 2):
        mine, known = w**power, even**power * density
        error = np.hypot(mine.std(axis=1), known.std(axis=1)) / np.sqrt(n)
        assert (np.abs(mine.mean(axis=1) - known.mean(axis=1)) < 5 * error).all()
    # A lobe's integral, and the whole light by importance sampling, in closed form.
    total = (lights.radiance(w) / lights.pdf(w)).mean(axis=1)
    sky = 2 * np.pi * (np.array(lights.zenith) + lights.nadir)
    known = sky + sum(np.array(lamp.colour) * lamp.solid_angle for lamp in lamps)
    assert total == pytest.approx(known, rel=0.01)


@pytest.mark.parametrize("name", NAMES)
def test_bodies_are_closed_and_face_out(name, monkeypatch):
    scene = import_module(f"msbsdf_cli.experiments.render.scenes.{name}")
    for size in {"SECTIONS", "PARALLELS", "RINGS"} & set(vars(scene)):
        monkeypatch.setattr(scene, size, 24)
    body = scene.stage("none").body
    mesh = trimesh.Trimesh(body.vertices, body.faces)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0
    frames = body.frames(np.arange(len(body.faces)))
    product = np.einsum("iaf,jaf->ijf", frames, frames)
    assert product == pytest.approx(np.broadcast_to(np.eye(3)[:, :, None], product.shape), abs=1e-9)
    assert np.linalg.det(np.moveaxis(frames, -1, 0)) == pytest.approx(1, abs=1e-9)


def test_frames_there_and_back(rng):
    body = stage("sphere").body
    triangle = rng.integers(0, len(body.faces), 100)
    w = rng.normal(size=(3, 100))
    assert world(body.frames(triangle), local(body.frames(triangle), w)) == pytest.approx(w)


def test_rays_meet_the_sphere_where_it_is():
    body: Body = stage("sphere").body
    o = np.tile(np.array([[0.0], [-5.0], [0.3]]), 1)
    hits = body.meet(o, np.array([[0.0], [1.0], [0.0]]))
    # A chord of one degree lies .00015 under the sphere in its middle, along both angles.
    assert hits.point[:, 0] == pytest.approx([0, -np.sqrt(1 - 0.09), 0.3], abs=4e-4)
    assert body.hides(o, np.array([[0.0], [1.0], [0.0]])).all()
    assert not body.hides(o, np.array([[0.0], [-1.0], [0.0]])).any()
    with pytest.raises(FloatingPointError, match="not finite"):
        body.meet(o * np.nan, o)


def test_the_camera_looks_where_it_is_told():
    camera = Camera((1.0, -4.0, 2.0), (0.0, 0.5, 0.0), 0.6, 1.5)
    d = camera.rays(np.array([0.5, 1.0, 0.5]), np.array([0.5, 0.5, 0.0]))
    ahead = np.subtract(camera.at, camera.eye)
    assert d[:, 0] == pytest.approx(ahead / np.linalg.norm(ahead))
    assert np.arccos(dot(d[:, [0]], d[:, [1]])) == pytest.approx(0.3)
    assert d[2, 2] > d[2, 0]


def test_pictures_do_not_depend_on_processes_and_differ_by_seed():
    of = stage("slab"), Ggx(0.5, 0.5), Conductor(), ("single", "walk")
    one, two = (render(*of, Settings(48, 32, 4), workers, True) for workers in (1, 2))
    for a, b in zip(one, two, strict=True):
        assert np.array_equal(a.mean, b.mean)
    assert not np.array_equal(one[0].mean, one[1].mean)
    again = render(*of, Settings(48, 32, 4, seed=1), 1, True)
    assert not np.array_equal(one[0].mean, again[0].mean)


def test_the_table_says_what_the_pictures_say():
    pictures = render(stage("slab"), Ggx(0.5, 0.5), Conductor(), ("single", "walk"), SMALL, 1, True)
    table = table_of(pictures)
    first, second = pictures
    assert table["luminance"][1] == pytest.approx(luminance(second.mean).mean())
    apart = luminance(second.mean).mean() - luminance(first.mean).mean()
    assert table["difference"] == [0, pytest.approx(apart)]
    stderr = np.sqrt((luminance(first.stderr) ** 2).sum()) / first.mean[0].size
    assert table["luminance_stderr"][0] == pytest.approx(stderr)


def test_standard_errors_are_the_spread_of_seeds():
    seeds = [picture("bottle", GOLD, "walk", Settings(24, 16, 16, seed=seed)) for seed in range(24)]
    values = np.array([blocks(p)[0] for p in seeds])
    stated = np.sqrt(np.mean([blocks(p)[1] ** 2 for p in seeds], axis=0))
    lit = stated > 1e-6
    ratio = values.var(axis=0, ddof=1)[lit].sum() / (stated[lit] ** 2).sum()
    # Of some 60 independent blocks and 23 degrees of freedom each: known to 4 %, and to twice that
    # where a few bright blocks count most.
    assert ratio == pytest.approx(1, abs=0.2)


def test_the_display_is_srgb():
    grey = np.full((3, 1, 1), 0.214041)
    assert displayed(grey) == pytest.approx(0.5, abs=1e-4)
    assert displayed(np.full((3, 1, 1), 0.002)) == pytest.approx(0.02584, abs=1e-5)
    assert displayed(np.full((3, 1, 1), 7.0)) == pytest.approx(1)


def test_scenes_name_their_surfaces():
    for name in NAMES:
        assert {"material", "slopes", "alpha"} <= set(defaults(name))
    with pytest.raises(ValueError, match="has no texture"):
        stage("sphere", "roughness")


def test_a_texture_keeps_the_ratio_of_two_roughnesses():
    texture = stage("plate", "roughness").texture
    look = texture(np.array([[-1.0, 0.2, 1.3], [0.1, 0.5, -0.7], [0, 0, 0]]), Ggx(1.0, 0.1))
    assert look.alpha_y == pytest.approx(look.alpha_x / 10)


def test_a_verdict_needs_an_error_small_enough():
    assert _verdict(0.18, 0.27, 0.06, 0.0) == "undecided"
    assert _verdict(0.5, 0.1, 0.5, 0.0) == "holds"
    assert _verdict(0.02, 0.001, 0.2, 0.1) == "less here"
    assert _verdict(4.0, 0.1, 0.19, 0.0) == "more here"
