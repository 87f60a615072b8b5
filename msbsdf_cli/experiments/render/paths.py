"""Light along paths from the camera: what is met is shaded, and lights are sampled there.

At every surface a light is sampled and the BSDF is, each weighed by the balance heuristic of
multiple importance sampling (E. Veach, L. Guibas, 1995). Paths end by roulette, not at a length.
Along a path goes radiance over the squared index of where it is, so that nothing is scaled where
light enters glass or leaves it.
"""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from msbsdf_cli.experiments.render.body import local, world
from msbsdf_cli.experiments.render.stage import Stage
from msbsdf_cli.methods.forced_collisions import roulette
from msbsdf_cli.smith.slopes import Slopes
from surfaces.batch import Batch, concatenate
from surfaces.facet import Array, dot
from surfaces.materials import Material


class Shades(Protocol):
    """What pixels ask of a method, as `methods.protocol.Method` has it, or of a table."""

    @property
    def material(self) -> Material:
        """Of the facets."""

    def of_lanes(self, slopes: Slopes, material: Material) -> "Shades":
        """The same for lanes of light with slopes and a material of their own."""

    def evaluate_each(self, wi: Array, wo: Array, rng: np.random.Generator) -> Array:
        """BSDF x cos(theta_o) of pairs of directions, (channels, n)."""

    def sample_each(self, wi: Array, rng: np.random.Generator) -> tuple[Array, Array]:
        """A direction for each of `wi` (3, n), and its weight (channels, n)."""

    def pdf_each(self, wi: Array, wo: Array) -> Array:
        """A density of samples, (n,)."""


@dataclass(frozen=True)
class Shader:
    """A method on either side of a surface of these slopes, which a texture may change."""

    slopes: Slopes
    outside: Shades
    inside: Shades | None = None
    """For light that arrives from within; None where nothing lets light through."""

    @property
    def error(self) -> float:
        """What a table is off by, relative to the mean of its values; 0 without one."""
        tables = (getattr(side, "table", None) for side in (self.outside, self.inside))
        return max((table.error for table in tables if table is not None), default=0.0)


@dataclass
class Counts:
    """What happened to paths."""

    surfaces: int = 0
    """Surfaces met."""
    lost: int = 0
    """Paths that rounding let through where there is no way: out of a closed body, or into an
    opaque one."""
    nonfinite: int = 0
    """Values that were not finite, which a method replaced or left out."""
    cut: int = 0
    """Walks that a method cut off at its largest number of facets."""


@dataclass
class CameraPaths(Batch):
    """Paths under way, (..., n)."""

    o: Array
    d: Array
    slot: Array
    throughput: Array
    """(channels, n)"""
    density: Array
    """Of the BSDF sample that led here, per steradian; infinite from the camera."""
    inside: Array


@dataclass
class Integrator:
    """Radiance along paths, with counts of what happened."""

    stage: Stage
    shader: Shader
    strategy: str = "mis"
    """How light is found: by samples of the BSDF ("bsdf"), of the lights ("light"), or by both."""
    counts: Counts = field(default_factory=Counts)

    def radiance(self, o: Array, d: Array, rng: np.random.Generator) -> Array:
        """One estimate for each ray from `o` along unit vectors `d` (3, n): red, green and blue,
        (3, n)."""
        n = d.shape[1]
        found, channels = np.zeros((3, n)), self.shader.outside.material.channels
        far, one = np.full(n, np.inf), np.ones((channels, n))
        paths = CameraPaths(o, d, np.arange(n), one, far, np.zeros(n, bool))
        while paths.slot.size:
            hits = self.stage.body.meet(paths.o, paths.d)
            gone = hits.triangle < 0
            self._reach_lights(paths.compress(gone), found)
            paths = self._scatter(
                paths.compress(~gone), hits.triangle[~gone], hits.point[:, ~gone], found, rng
            )
        return found

    def _reach_lights(self, paths: CameraPaths, found: Array) -> None:
        """Add what paths see that leave the scene; none leaves from within a closed body."""
        self.counts.lost += int(np.count_nonzero(paths.inside))
        paths = paths.compress(~paths.inside)
        straight = np.isinf(paths.density)
        if self.strategy == "light":
            share = straight.astype(float)
        elif self.strategy == "bsdf":
            share = np.ones(straight.size)
        else:
            light = self.stage.lights.pdf(paths.d)
            # From the camera nothing else finds the light; what neither would draw counts nothing.
            both = np.where(straight, 1, paths.density + light)
            mine = np.where(straight, 1, paths.density)
            share = np.divide(mine, both, out=np.zeros_like(both), where=both > 0)
        found[:, paths.slot] += share * paths.throughput * self.stage.lights.radiance(paths.d)

    def _scatter(
        self,
        paths: CameraPaths,
        triangle: Array,
        point: Array,
        found: Array,
        rng: np.random.Generator,
    ) -> CameraPaths:
        """Add the light that comes from sampled lights, and turn the paths that go on."""
        body = self.stage.body
        self.counts.surfaces += triangle.size
        within = dot(body.normal[:, triangle], paths.d) > 0
        if self.shader.inside is None and within.any():
            self.counts.lost += int(np.count_nonzero(within))
            paths, triangle, point = paths.compress(~within), triangle[~within], point[:, ~within]
            within = within[~within]
        frames = body.frames(triangle)
        # From within the surface is seen upside down: turned about its tangent.
        frames[1:] *= np.where(within, -1.0, 1.0)
        after = []
        for side in (False, True):
            lanes = np.flatnonzero(within == side)
            if lanes.size:
                some = paths.take(lanes)
                at = frames[:, :, lanes], point[:, lanes]
                method = self._method(side, at[1])
                before = _troubles(method)
                after.append(self._shade(method, some, *at, side, found, rng))
                nonfinite, cut = _troubles(method) - before
                self.counts.nonfinite += int(nonfinite)
                self.counts.cut += int(cut)
        return _joined(after, paths)

    def _method(self, within: bool, point: Array) -> Shades:
        """That of a side, for the texture at some points."""
        method = self.shader.inside if within else self.shader.outside
        assert method is not None
        if self.stage.texture is not None:
            method = method.of_lanes(*self.stage.lanes(self.shader.slopes, method.material, point))
        return method

    def _shade(
        self,
        method: Shades,
        paths: CameraPaths,
        frames: Array,
        point: Array,
        within: bool,
        found: Array,
        rng: np.random.Generator,
    ) -> CameraPaths:
        """Surfaces that are all met from one side."""
        wi = local(frames, -paths.d)
        # A triangle met edge on is met at the last float above its horizon.
        wi[2] = np.maximum(wi[2], np.finfo(float).eps)
        if self.strategy != "bsdf":
            self._sample_lights(method, paths, frames, point, wi, within, found, rng)
        w, weight = method.sample_each(wi, rng)
        density = method.pdf_each(wi, w) if self.strategy == "mis" else np.zeros(w.shape[1])
        throughput = paths.throughput * weight
        stays, boost = roulette(np.ones(w.shape[1]), throughput, rng)
        after = CameraPaths(
            self._start(frames, point, w),
            world(frames, w),
            paths.slot,
            throughput * boost,
            density,
            (w[2] < 0) ^ within,
        )
        return after.compress(stays)

    def _sample_lights(
        self,
        method: Shades,
        paths: CameraPaths,
        frames: Array,
        point: Array,
        wi: Array,
        within: bool,
        found: Array,
        rng: np.random.Generator,
    ) -> None:
        """Add what comes from one sampled direction to each point, where nothing is in its way."""
        lights = self.stage.lights
        d = lights.sample(paths.slot.size, rng)
        w, pdf = local(frames, d), lights.pdf(d)
        value = method.evaluate_each(wi, w, rng)
        # Light comes from outside, whichever side the path is on.
        comes = np.flatnonzero((value.max(axis=0) > 0) & ((w[2] < 0) == within))
        start = self._start(frames[:, :, comes], point[:, comes], w[:, comes])
        comes = comes[~self.stage.body.hides(start, d[:, comes])]
        other: Array | float = 0.0
        if self.strategy == "mis":
            # Only where something comes: the other strategy counts nothing elsewhere.
            other = method.pdf_each(wi, w)[comes]
        light = lights.radiance(d[:, comes]) / (pdf[comes] + other)
        found[:, paths.slot[comes]] += paths.throughput[:, comes] * value[:, comes] * light

    def _start(self, frames: Array, point: Array, w: Array) -> Array:
        """Where rays along `w`, in the frames, start again: lifted off their triangles."""
        return point + frames[2] * np.where(w[2] < 0, -1, 1) * self.stage.body.lift


def _troubles(method: Shades) -> Array:
    """What a method counts so far of what its algorithm cannot do: values that were not finite, and
    walks that were cut off."""
    return np.array([getattr(method, name, 0) for name in ("hidden", "cut")])


def _joined(parts: list[CameraPaths], none: CameraPaths) -> CameraPaths:
    return concatenate(parts) if parts else none.compress(np.zeros(none.slot.size, bool))
