# SPDX-License-Identifier: MIT
"""Ray queries for trimesh, in the place of its own:

    mesh.ray = htree.trimesh.RayMeshIntersector(mesh)

Methods, arguments, shapes and dtypes are those of `trimesh.ray.ray_pyembree.RayMeshIntersector`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from trimesh import Trimesh
from trimesh.ray.ray_util import contains_points
from trimesh.util import unitize

from ._options import Kind, Options
from ._tree import Tree, build

__all__ = ["RayMeshIntersector"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

# Hits of a ray closer together than this part of the mesh's diagonal are one, as in trimesh: two
# triangles met at their shared edge are one wall. Some 5 units in the last place of float32.
_ONE_HIT = 1e-6
# A plane that a ray meets at a smaller cosine says nothing of where: trimesh's own threshold.
_PARALLEL = 1e-5


class _Scene(NamedTuple):
    """A mesh around the origin and about one unit large, so that float32 loses nothing to its place
    or size; the scale is a power of two and exact."""

    tree: Tree
    centre: Floats
    scale: float
    radius: float  # of the mesh in the tree

    @classmethod
    def of(cls, mesh: Trimesh, scale_to_box: bool, options: Options | str) -> _Scene:
        vertices = np.asarray(mesh.vertices, np.float64)
        centre, radius = np.zeros(3), 0.0
        if len(mesh.faces) and np.isfinite(mesh.bounds).all():
            centre = np.asarray(mesh.bounds, np.float64).mean(axis=0)
            radius = float(np.linalg.norm(mesh.bounds[1] - centre))
        scale = 2.0 ** min(-int(np.frexp(radius)[1]), 1000) if scale_to_box else 1.0
        tree = build((vertices - centre) * scale, np.asarray(mesh.faces), options)
        return cls(tree, centre, scale, radius * scale)

    def origins(self, origins: Floats, directions: Floats) -> Floats:
        """Origins as the tree has them. One that is far off comes along its ray to three radii
        before the mesh, because float32 has no digits for both."""
        local: Floats = (origins - self.centre) * self.scale
        ahead = -np.einsum("ij,ij->i", local, directions) - 3 * self.radius
        local += np.where(ahead > 0, ahead, 0.0)[:, None] * directions
        return local


class RayMeshIntersector:
    """Queries of rays and a mesh. The tree is built at the first query, and again when the mesh has
    changed since."""

    def __init__(
        self,
        geometry: Trimesh,
        scale_to_box: bool = True,
        *,
        options: Options | str = Kind.BALANCED,
    ) -> None:
        """
        geometry      a trimesh.Trimesh
        scale_to_box  bring the mesh to about unit size; False matters for meshes beyond 2^60 only
        options       htree.Options or the name of a kind
        """
        self.mesh = geometry
        self._scale_to_box = scale_to_box
        self._options = options
        self._built: tuple[int, _Scene] | None = None

    @property
    def _scene(self) -> _Scene:
        now = hash(self.mesh)
        built = self._built
        if built is None or built[0] != now:
            built = now, _Scene.of(self.mesh, self._scale_to_box, self._options)
            self._built = built
        return built[1]

    # ---- Queries --------------------------------------------------------------------------------

    def intersects_location(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike, multiple_hits: bool = True
    ) -> tuple[Floats, Indices, Indices]:
        """Where rays hit the mesh: locations (m, 3), index_ray (m,), index_tri (m,)."""
        index_tri, index_ray, locations = self._intersects(
            ray_origins, ray_directions, 100 if multiple_hits else 1
        )
        return locations, index_ray, index_tri

    def intersects_id(
        self,
        ray_origins: ArrayLike,
        ray_directions: ArrayLike,
        multiple_hits: bool = True,
        max_hits: int = 100,
        return_locations: bool = False,
    ) -> tuple[Indices, Indices] | tuple[Indices, Indices, Floats]:
        """Which triangles rays hit: index_tri (m,), index_ray (m,) and, with return_locations,
        locations (m, 3). First hits come first, then second ones, ..., each in order of rays."""
        most = max_hits if multiple_hits else min(max_hits, 1)
        found = self._intersects(ray_origins, ray_directions, most, return_locations)
        return found if return_locations else found[:2]

    def intersects_first(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike
    ) -> NDArray[np.int32]:
        """The first triangle that each ray hits, or -1."""
        origins, directions = _checked(ray_origins, ray_directions)
        scene = self._scene
        local = scene.origins(origins, directions)
        return scene.tree.intersect(local, directions).prim.astype(np.int32)

    def intersects_any(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike
    ) -> NDArray[np.bool_]:
        """Whether each ray hits the mesh."""
        origins, directions = _checked(ray_origins, ray_directions)
        scene = self._scene
        local = scene.origins(origins, directions)
        return scene.tree.occluded(local, directions)

    def contains_points(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether points lie inside of the mesh, by parity of hits; undefined on its surface."""
        inside: NDArray[np.bool_] = contains_points(self, points)
        return inside

    def _intersects(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike, most: int, locations: bool = True
    ) -> tuple[Indices, Indices, Floats]:
        origins, directions = _checked(ray_origins, ray_directions)
        scene = self._scene
        local = scene.origins(origins, directions)
        live: Indices = np.arange(len(origins))
        after = np.zeros(len(origins))
        step = 2 * scene.radius * _ONE_HIT
        triangles, rays, places = [], [], []

        for _ in range(most):
            hits = scene.tree.intersect(local[live], directions[live], tmin=after[live])
            hit = hits.hit
            live = live[hit]
            if not len(live):
                break
            triangle = hits.prim[hit].astype(np.int64)
            triangles.append(triangle)
            rays.append(live)
            if locations:
                places.append(self._places(origins[live], directions[live], triangle, hits, hit))
            t = hits.t[hit]
            after[live] = np.maximum(t + step, np.nextafter(t, np.float32(np.inf)))
        return (
            np.concatenate([np.zeros(0, np.int64), *triangles]),
            np.concatenate([np.zeros(0, np.int64), *rays]),
            np.concatenate([np.zeros((0, 3)), *places]),
        )

    def _places(
        self, origins: Floats, directions: Floats, triangle: Indices, hits: Any, hit: Any
    ) -> Floats:
        """Where rays meet the planes of their triangles, in double precision as trimesh has it; by
        u and v where a ray nearly lies in the plane."""
        corners = np.asarray(self.mesh.triangles, np.float64)[triangle]
        normals = np.asarray(self.mesh.face_normals, np.float64)[triangle]
        cosine = np.einsum("ij,ij->i", directions, normals)
        height = np.einsum("ij,ij->i", corners[:, 0] - origins, normals)
        meets = np.abs(cosine) > _PARALLEL
        distance = np.divide(height, cosine, out=np.zeros_like(height), where=meets)
        on_plane = origins + distance[:, None] * directions
        u, v = (field[hit][:, None].astype(np.float64) for field in (hits.u, hits.v))
        inside = (1 - u - v) * corners[:, 0] + u * corners[:, 1] + v * corners[:, 2]
        places: Floats = np.where(meets[:, None], on_plane, inside)
        return places

    # ---- Copies: of the query object, not of the mesh, as in trimesh ----------------------------

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_built": None}

    def __copy__(self) -> RayMeshIntersector:
        return RayMeshIntersector(self.mesh, self._scale_to_box, options=self._options)

    def __deepcopy__(self, memo: dict[int, Any]) -> RayMeshIntersector:
        return self.__copy__()


def _checked(origins: ArrayLike, directions: ArrayLike) -> tuple[Floats, Floats]:
    """Both as (n, 3) doubles, directions of unit length."""
    origins = np.asarray(origins, np.float64)
    directions = np.asarray(directions, np.float64)
    if origins.shape != directions.shape:
        raise ValueError("Ray origin and direction don't match!")
    if origins.ndim != 2 or origins.shape[1] != 3:
        raise ValueError(f"rays must be (n, 3), not {origins.shape}")
    return origins, unitize(directions)
