"""Triangles in Embree, each with a frame of its own.

Light meets flat triangles, and each is shaded by its own plane's normal and not by one that is
interpolated: no light gets lost between what is seen and what is shaded, and a body that conserves
energy disappears in constant light exactly. Triangles are made small enough to look round.
"""

from dataclasses import dataclass
from zlib import crc32

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from surfaces.facet import Array, dot

_SCENES: dict[int, EmbreeScene] = {}
"""The scene of the body that this process meets light on, by its digest."""


@dataclass(frozen=True)
class Hits:
    """Where rays meet a body, (n,): the triangle, or -1, and the point, (3, n)."""

    triangle: Array
    point: Array


class Body:
    """Closed meshes of `vertices` (v, 3) and `faces` (f, 3), whose normals point out.

    `tangents` (f, 3) are the directions of alpha_x, by their part within each triangle.
    """

    def __init__(self, vertices: Array, faces: Array, tangents: Array) -> None:
        # Embree's precision, so that its triangles and the planes below are the same.
        self.vertices = vertices.astype(np.float32)
        self.faces = faces.astype(np.int32)
        a, b, c = np.moveaxis(self.vertices.astype(float)[self.faces], 1, 0)
        normal = np.cross(b - a, c - a).T
        self.normal = normal / np.sqrt(dot(normal, normal))
        along = tangents.T - self.normal * dot(tangents.T, self.normal)
        self.tangent = along / np.sqrt(dot(along, along))
        self.height = dot(self.normal, a.T)
        # Single precision moves an origin by half a spacing along each axis, and Embree rounds
        # once more.
        self.lift = 4 * float(np.spacing(np.abs(self.vertices).max()))
        self.digest = crc32(self.faces.tobytes(), crc32(self.vertices.tobytes()))

    @property
    def scene(self) -> EmbreeScene:
        """The Embree scene, made once in each process, whatever copies of the body reach it."""
        if self.digest not in _SCENES:
            _SCENES.clear()
            # `robust`: rays along edges slip through otherwise.
            scene = EmbreeScene(robust=True)
            TriangleMesh(scene, self.vertices, self.faces)
            _SCENES[self.digest] = scene
        return _SCENES[self.digest]

    def meet(self, o: Array, d: Array) -> Hits:
        """The triangles that rays from `o` along `d` (3, n) meet first, and where."""
        triangle = self._query(o, d, "INTERSECT")
        normal = self.normal[:, triangle]
        along = dot(normal, d)
        # A plane that is met edge on has no other point to give than where the ray starts.
        far = np.divide(
            self.height[triangle] - dot(normal, o),
            along,
            out=np.zeros_like(along),
            where=along != 0,
        )
        return Hits(triangle, o + np.maximum(far, 0) * d)

    def hides(self, o: Array, d: Array) -> Array:
        """Whether anything is in the way of rays, (n,)."""
        return np.asarray(self._query(o, d, "OCCLUDED") >= 0)

    def frames(self, triangle: Array) -> Array:
        """Tangent, bitangent and normal (3, 3, n) of triangles (n,)."""
        t, n = self.tangent[:, triangle], self.normal[:, triangle]
        return np.stack([t, np.cross(n, t, axis=0), n])

    def _query(self, o: Array, d: Array, query: str) -> Array:
        if not (np.isfinite(o).all() and np.isfinite(d).all()):
            raise FloatingPointError("a ray with a value that is not finite was about to be traced")
        rays = np.empty((2, o.shape[1], 3), np.float32)
        rays[0], rays[1] = o.T, d.T
        found: Array = self.scene.run(rays[0], rays[1], query=query)
        return found


def local(frames: Array, w: Array) -> Array:
    """Directions (3, n) in the frames (3, 3, n) of their triangles."""
    return np.stack([dot(axis, w) for axis in frames])


def world(frames: Array, w: Array) -> Array:
    """The way back."""
    found: Array = frames[0] * w[0] + frames[1] * w[1] + frames[2] * w[2]
    return found


def turned(profile: Array, sections: int, centre: tuple[float, float] = (0.0, 0.0)) -> Body:
    """A body turned about the vertical axis through `centre`: `profile` (p, 2) of radius and
    height, from the axis at the bottom to the axis at the top."""
    import trimesh

    mesh = trimesh.creation.revolve(profile, sections=sections)
    vertices = mesh.vertices + np.array([*centre, 0.0])
    middle = mesh.triangles_center
    return Body(vertices, mesh.faces, np.cross([0.0, 0.0, 1.0], middle))


def together(*bodies: Body) -> Body:
    """Several bodies as one."""
    first, faces = 0, []
    for body in bodies:
        faces.append(body.faces + first)
        first += len(body.vertices)
    return Body(
        np.concatenate([body.vertices for body in bodies]),
        np.concatenate(faces),
        np.concatenate([body.tangent.T for body in bodies]),
    )
