# SPDX-License-Identifier: MIT
"""The intersector against trimesh's own two and against an oracle in double precision, method by
method, on every mesh below."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from htree.trimesh import RayMeshIntersector

trimesh: Any = import_module("trimesh")  # most of it has no types
Triangle = trimesh.ray.ray_triangle.RayMeshIntersector
# embreex has no wheels for some machines.
Embree = trimesh.ray.ray_pyembree.RayMeshIntersector if trimesh.ray.has_embree else None

COUNT = 800


def meshes() -> dict[str, Any]:
    make = trimesh.creation
    dice = np.random.default_rng(9)
    made = {
        "icosphere": make.icosphere(3),
        "uv sphere": make.uv_sphere(count=[20, 20]),
        "box": make.box(),
        "fine box": make.box().subdivide().subdivide(),
        "cylinder": make.cylinder(1, 2),
        "cone": make.cone(1, 2),
        "capsule": make.capsule(),
        "annulus": make.annulus(0.5, 1, 1),
        "torus": make.torus(1, 0.3),
        "axis": make.axis(),
    }
    for name, scale in (("thousandth", 1e-3), ("thousandfold", 1e3)):
        made[name] = made["torus"].copy()
        made[name].apply_scale(scale)
    turn = trimesh.transformations.rotation_matrix(1.1, [1, 2, 3])
    made["turned"] = made["annulus"].copy()
    made["turned"].apply_transform(turn)
    made["turned"].apply_translation([100, -50, 3])
    made["far"] = made["icosphere"].copy()
    made["far"].apply_translation([1e5, -50, 3])
    corners = dice.normal(size=(300, 1, 3)) + 0.2 * dice.normal(size=(300, 3, 3))
    made["soup"] = trimesh.Trimesh(**trimesh.triangles.to_kwargs(corners), process=False)
    x, y = np.meshgrid(np.linspace(-1, 1, 25), np.linspace(-1, 1, 25), indexing="ij")
    terrain = np.stack([x, y, 0.3 * np.sin(5 * x) * np.cos(4 * y)], -1)
    quads = np.arange(24)[:, None] * 25 + np.arange(24)
    faces = np.stack([quads, quads + 25, quads + 26, quads, quads + 26, quads + 1], -1)
    made["terrain"] = trimesh.Trimesh(terrain.reshape(-1, 3), faces.reshape(-1, 3))
    made["two"] = trimesh.util.concatenate([make.icosphere(2), make.box([1.2, 1.2, 1.2])])
    return made


MESHES = meshes()
# Where an engine of trimesh is known to be wrong: intersects_first hands embree float32, and the
# other engine has absolute tolerances.
EMBREE_IS_WRONG = {"far"}
TRIANGLE_IS_WRONG = {"thousandth"}


def rays_at(mesh: Any, seed: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Rays from inside and outside of the mesh's box, towards points in it."""
    dice = np.random.default_rng(seed)
    centre, size = mesh.bounds.mean(axis=0), mesh.extents.max()
    origins = centre + dice.normal(size=(COUNT, 3)) * size * dice.choice([0.2, 1, 5], (COUNT, 1))
    targets = centre + dice.uniform(-0.5, 0.5, (COUNT, 3)) * mesh.extents
    return origins, targets - origins


class Oracle:
    """Every triangle is asked in double precision. A ray that passes an edge, or starts at a
    triangle, within 1e-5 of the mesh's size is `unsure`, and no one's answer is judged."""

    def __init__(self, mesh: Any, origins: NDArray[Any], directions: NDArray[Any]) -> None:
        directions = trimesh.unitize(directions)
        a = mesh.triangles[:, 0]
        e, f = mesh.triangles[:, 1] - a, mesh.triangles[:, 2] - a
        shape = len(origins), len(a)
        self.t = np.full(shape, np.inf)
        self.unsure = np.zeros(len(origins), bool)
        near = 1e-5
        with np.errstate(divide="ignore", invalid="ignore"):
            for i, (o, d) in enumerate(zip(origins, directions, strict=True)):
                p = np.cross(d, f)
                det = np.einsum("ij,ij->i", e, p)
                s = o - a
                u = np.einsum("ij,ij->i", s, p) / det
                q = np.cross(s, e)
                v = q @ d / det
                t = np.einsum("ij,ij->i", f, q) / det
                least = np.minimum(np.minimum(u, v), 1 - u - v)
                self.t[i] = np.where((least >= 0) & (t >= 0), t, np.inf)
                slack = near * mesh.scale / np.sqrt(np.abs(det) + 1e-300)
                ahead = t > -near * mesh.scale
                self.unsure[i] = ((np.abs(least) < np.maximum(slack, near)) & ahead).any()
                self.unsure[i] |= ((np.abs(t) < near * mesh.scale) & (least > -near)).any()
            order = np.sort(self.t, axis=1)[:, :2]
            self.unsure |= order[:, 1] - order[:, 0] < near * mesh.scale
        self.first = np.where(np.isfinite(order[:, 0]), self.t.argmin(axis=1), -1)
        self.counts = np.isfinite(self.t).sum(axis=1)


def engines(name: str) -> list[Any]:
    """The engines of trimesh that can be believed for this mesh."""
    mesh = MESHES[name]
    found = [] if name in TRIANGLE_IS_WRONG else [Triangle(mesh)]
    if Embree is not None and name not in EMBREE_IS_WRONG:
        found.append(Embree(mesh))
    return found


def ordered(ray: NDArray[Any], place: NDArray[Any], origins: NDArray[Any], *more: Any) -> Any:
    """Hits by ray and along it."""
    order = np.lexsort((np.linalg.norm(place - origins[ray], axis=1), ray))
    return [array[order] for array in (ray, place, *more)]


def test_there_are_enough_meshes() -> None:
    assert len(MESHES) >= 10 and all(len(mesh.faces) for mesh in MESHES.values())


@pytest.mark.parametrize("name", MESHES)
def test_the_oracle_agrees(name: str) -> None:
    mesh = MESHES[name]
    origins, directions = rays_at(mesh, 1)
    oracle = Oracle(mesh, origins, directions)
    sure = ~oracle.unsure
    assert sure.mean() > 0.9 and (oracle.first[sure] >= 0).any()
    own = RayMeshIntersector(mesh)
    first = own.intersects_first(origins, directions)
    np.testing.assert_array_equal(first[sure], oracle.first[sure])
    np.testing.assert_array_equal(
        own.intersects_any(origins, directions)[sure], (oracle.first >= 0)[sure]
    )
    index_tri, index_ray = own.intersects_id(origins, directions)  # type: ignore[misc]
    expected_ray, expected_tri = np.nonzero(np.isfinite(oracle.t) & sure[:, None])
    found = {(ray, tri) for ray, tri in zip(index_ray, index_tri, strict=True) if sure[ray]}
    assert found == set(zip(expected_ray, expected_tri, strict=True))
    assert len(found) == sure[index_ray].sum()  # none of them twice


@pytest.mark.parametrize("name", MESHES)
def test_trimeshs_engines_agree(name: str) -> None:
    mesh = MESHES[name]
    origins, directions = rays_at(mesh, 2)
    sure = ~Oracle(mesh, origins, directions).unsure
    origins, directions = origins[sure], directions[sure]
    own = RayMeshIntersector(mesh)
    assert engines(name)
    for other in engines(name):
        embree = Embree is not None and isinstance(other, Embree)
        for method in ("intersects_first", "intersects_any"):
            answer = getattr(own, method)(origins, directions)
            expected = getattr(other, method)(origins, directions)
            np.testing.assert_array_equal(answer, expected, method)
            assert not embree or answer.dtype == expected.dtype

        for multiple in (True, False):
            place, ray, tri = own.intersects_location(origins, directions, multiple_hits=multiple)
            expected = other.intersects_location(origins, directions, multiple_hits=multiple)
            assert [a.dtype for a in (place, ray, tri)] == [a.dtype for a in expected]
            assert [a.shape for a in (place, ray, tri)] == [a.shape for a in expected]
            if embree and not multiple:  # the same order too
                np.testing.assert_array_equal(ray, expected[1])
                np.testing.assert_array_equal(tri, expected[2])
            ray, place, tri = ordered(ray, place, origins, tri)
            other_ray, other_place, other_tri = ordered(
                expected[1], expected[0], origins, expected[2]
            )
            np.testing.assert_array_equal(ray, other_ray)
            np.testing.assert_array_equal(tri, other_tri)
            np.testing.assert_allclose(place, other_place, atol=1e-9 * mesh.scale + 1e-12)

            ids = own.intersects_id(origins, directions, multiple_hits=multiple)
            assert len(ids) == 2
            expected = other.intersects_id(origins, directions, multiple_hits=multiple)
            assert set(zip(*ids, strict=True)) == set(zip(*expected, strict=True))
            assert [a.dtype for a in ids] == [a.dtype for a in expected]
            three = own.intersects_id(
                origins, directions, multiple_hits=multiple, return_locations=True
            )
            assert len(three) == 3 and three[2].shape == (len(three[0]), 3)


@pytest.mark.parametrize("name", MESHES)
def test_trimeshs_engines_agree_about_what_is_inside(name: str) -> None:
    mesh = MESHES[name]
    dice = np.random.default_rng(3)
    points = mesh.bounds.mean(axis=0) + dice.uniform(-0.55, 0.55, (400, 3)) * mesh.extents
    inside = RayMeshIntersector(mesh).contains_points(points)
    assert inside.dtype == bool and inside.shape == (400,)
    if mesh.is_watertight:
        assert inside.any() and not inside.all()
        for other in engines(name):
            np.testing.assert_array_equal(inside, other.contains_points(points))


@pytest.mark.parametrize("name", sorted(EMBREE_IS_WRONG | TRIANGLE_IS_WRONG))
def test_an_engine_is_left_out_only_where_it_is_wrong(name: str) -> None:
    mesh = MESHES[name]
    origins, directions = rays_at(mesh, 1)
    oracle = Oracle(mesh, origins, directions)
    wrong = Embree if name in EMBREE_IS_WRONG else Triangle
    if wrong is None:
        pytest.skip("no embreex here")
    first = wrong(mesh).intersects_first(origins, directions)
    assert (first != oracle.first)[~oracle.unsure].any()
