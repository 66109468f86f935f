# SPDX-License-Identifier: MIT
"""The intersector where trimesh's users are hard on one: edges, scales, copies, changes. Several
are known troubles of trimesh, named by the number of its issue."""

from __future__ import annotations

import copy
import inspect
import pickle
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import htree
from htree.trimesh import RayMeshIntersector

trimesh: Any = import_module("trimesh")  # most of it has no types
ray_triangle = trimesh.ray.ray_triangle
make = trimesh.creation


def counts(mesh: Any, origins: Any, directions: Any, **more: Any) -> NDArray[Any]:
    """Hits of each ray."""
    found = RayMeshIntersector(mesh, **more).intersects_id(origins, directions)
    return np.bincount(found[1], minlength=len(origins))


def edges_and_vertices(mesh: Any) -> NDArray[Any]:
    ends = mesh.vertices[mesh.edges_unique]
    return np.concatenate([mesh.vertices, ends.mean(axis=1), 0.3 * ends[:, 0] + 0.7 * ends[:, 1]])


# ---- Edges, vertices, layers --------------------------------------------------------------------

CONVEX = [
    make.box(),
    make.icosphere(2),
    make.cylinder(1, 2),
    make.box().subdivide(),
    make.capsule(),
]


@pytest.mark.parametrize("mesh", CONVEX)
@pytest.mark.parametrize("scale", [1e-3, 1, 1e3])
def test_a_ray_from_inside_through_an_edge_has_one_hit(mesh: Any, scale: float) -> None:
    mesh = mesh.copy()
    mesh.apply_scale(scale)
    targets = edges_and_vertices(mesh)
    origins = np.zeros_like(targets)
    assert (counts(mesh, origins, targets) == 1).all()
    own = RayMeshIntersector(mesh)
    assert own.intersects_any(origins, targets).all()
    assert (own.intersects_first(origins, targets) >= 0).all()
    place, ray, _tri = own.intersects_location(origins, targets)
    np.testing.assert_allclose(place, targets[ray], atol=1e-6 * mesh.scale)


def test_engines_of_trimesh_count_one_hit_at_an_edge_too() -> None:
    """Embree's does at any, the other one in intersects_location."""
    mesh = make.box()
    targets = edges_and_vertices(mesh)
    origins = np.zeros_like(targets)
    others: list[Any] = [ray_triangle.RayMeshIntersector(mesh)]
    if trimesh.ray.has_embree:
        others.append(trimesh.ray.ray_pyembree.RayMeshIntersector(mesh))
    for other in others:
        _place, ray, _tri = other.intersects_location(origins, targets)
        assert (np.bincount(ray, minlength=len(targets)) == 1).all()
    ids = others[0].intersects_id(origins, targets)
    assert (np.bincount(ids[1]) > 1).any()


def test_a_ray_through_two_opposite_vertices_has_two_hits() -> None:
    mesh = make.box()
    origins = 3 * mesh.vertices
    assert (counts(mesh, origins, -origins) == 2).all()


def test_equal_triangles_are_one_wall_and_the_first_of_them() -> None:
    box = make.box()
    mesh = trimesh.Trimesh(box.vertices, np.concatenate([box.faces, box.faces]), process=False)
    dice = np.random.default_rng(1)
    origins = dice.uniform(-0.4, 0.4, (200, 3))
    origins[:, 2] = -3
    directions = np.tile([[0.0, 0.0, 1.0]], (200, 1))
    own = RayMeshIntersector(mesh)
    tri, ray = own.intersects_id(origins, directions)  # type: ignore[misc]
    assert (np.bincount(ray) == 2).all() and (tri < len(box.faces)).all()
    assert (own.intersects_first(origins, directions) < len(box.faces)).all()


def plates(heights: NDArray[Any]) -> Any:
    corners = np.array([[-1, -1, 0], [1, -1, 0], [0, 2, 0]], float)
    vertices = np.concatenate([corners + [0, 0, z] for z in heights])
    return trimesh.Trimesh(vertices, np.arange(len(vertices)).reshape(-1, 3), process=False)


def test_every_layer_is_hit_up_to_max_hits() -> None:
    mesh = plates(np.linspace(0, 1, 30))
    own = RayMeshIntersector(mesh)
    down = ([[0, 0, 2]], [[0, 0, -1]])
    assert own.intersects_id(*down)[0].tolist() == list(range(29, -1, -1))
    assert own.intersects_id(*down, max_hits=7)[0].tolist() == list(range(29, 22, -1))
    assert own.intersects_id(*down, max_hits=0)[0].tolist() == []
    assert own.intersects_id(*down, multiple_hits=False)[0].tolist() == [29]
    tall = plates(np.linspace(0, 1, 150))
    assert len(RayMeshIntersector(tall).intersects_id(*down)[0]) == 100


@pytest.mark.parametrize("gap", [1e-3, 1e-4, 1e-5])
def test_close_layers_are_two(gap: float) -> None:
    mesh = plates(np.array([0, gap, 1, 1 + gap]))
    assert counts(mesh, [[0, 0.1, 3]], [[0.1, 0.1, -1]]).tolist() == [4]


def test_layers_closer_than_a_millionth_are_one() -> None:
    mesh = plates(np.array([0, 3e-7, 1, 1 + 3e-7]))
    ray = ([[0, 0.1, 3]], [[0.1, 0.1, -1]])
    assert counts(mesh, *ray).tolist() == [2]
    if trimesh.ray.has_embree:
        tri, _ = trimesh.ray.ray_pyembree.RayMeshIntersector(mesh).intersects_id(*ray)
        assert len(tri) == 2


def test_a_ray_in_the_plane_of_a_mesh_has_no_hits() -> None:  # 2462
    flat = trimesh.Trimesh(
        [[0, 0, 0], [0.1, 0, 0], [0.1, 0.3, 0], [0, 0.3, 0]], [[0, 1, 2], [0, 2, 3]]
    )
    place, ray, tri = RayMeshIntersector(flat).intersects_location(
        [[-0.5, 0.1, 0.0]], [[1.0, 0.0, 0.0]], multiple_hits=False
    )
    assert place.shape == (0, 3) and len(ray) == len(tri) == 0


def test_locations_of_grazing_rays_are_on_their_ray_or_triangle() -> None:
    flat = plates(np.array([0.0]))
    places, ray, _tri = RayMeshIntersector(flat).intersects_location(
        [[-5, 0, 1e-6], [-5, 0, 1e-3]], [[1, 0, -2e-7], [1, 0, -2e-4]]
    )
    assert ray.tolist() == [0, 1]
    np.testing.assert_allclose(places[:, 2], 0, atol=1e-6)
    np.testing.assert_allclose(places[:, 0], 0, atol=2)


# ---- Scales and places --------------------------------------------------------------------------


@pytest.mark.parametrize("scale", [1e-30, 1e-4, 0.1, 1.0, 10.0, 1e4, 1e8, 1e15])
@pytest.mark.parametrize("to_box", [True, False])
def test_a_ray_from_the_surface_through_a_box_has_two_hits(scale: float, to_box: bool) -> None:
    if scale == 1e-30:
        mesh = trimesh.Trimesh(make.box().vertices * scale, make.box().faces, process=False)
    else:
        mesh = make.box().subdivide().subdivide()
        mesh.apply_scale(scale)
    found = counts(mesh, [[0.0, 0.0, scale / 2]], [[0.0, 0.0, -1.0]], scale_to_box=to_box)
    assert found.tolist() == [2]


def test_a_ray_from_far_away_tells_front_from_back() -> None:  # 2504
    mesh = make.box(extents=[1e-3, 1e-3, 1e-3])
    for distance in (1, 1e4, 1e9):
        place, _ray, _tri = RayMeshIntersector(mesh).intersects_location(
            [[0, 0, distance]], [[0, 0, -1]]
        )
        np.testing.assert_allclose(
            np.sort(place[:, 2]), [-5e-4, 5e-4], atol=max(1e-9, 1e-15 * distance)
        )


def test_a_mesh_far_away_is_as_sharp_as_at_home() -> None:  # 48
    vertices = [
        [528980.85, 183526.1, 0],
        [528980.85, 183526.1, 3],
        [528982.3, 183523.55, 0],
        [528982.3, 183523.55, 3],
    ]
    mesh = trimesh.Trimesh(vertices, [[1, 0, 2], [1, 2, 3]], process=False)
    normal = mesh.face_normals[0]
    point = mesh.vertices[[0, 2]].mean(axis=0) + [0, 0, 1]
    for to_box in (True, False):
        own = RayMeshIntersector(mesh, scale_to_box=to_box)
        assert own.intersects_any([point - 0.01 * normal], [normal]).all()
        assert not own.intersects_any([point + 0.01 * normal], [normal]).any()


def test_a_box_that_shrank_is_hit() -> None:  # 2324
    mesh = make.box(extents=[64, 64, 64])
    mesh.apply_scale(1 / 64)
    place, ray, _tri = RayMeshIntersector(mesh).intersects_location(
        [[0.5, 0.5, -2.0]], [[0, 0, 1]], multiple_hits=False
    )
    assert ray.tolist() == [0] and place[0, 2] == pytest.approx(-0.5, abs=1e-6)


def test_rays_along_edges_of_a_box_hit() -> None:  # 2317, 1496
    box = make.box(extents=[2, 2, 2])
    xy = [[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, -1], [1, -1], [-1, 1]]
    origins = np.array([[x, y, 5] for x, y in xy], float)
    directions = np.tile([[0.0, 0.0, -1.0]], (len(origins), 1))
    own = RayMeshIntersector(box)
    hit = own.intersects_any(origins, directions)
    _tri, ray = own.intersects_id(origins, directions, multiple_hits=False)  # type: ignore[misc]
    assert hit.all() and ray.tolist() == list(range(len(origins)))


def test_one_ray_is_as_good_as_a_batch() -> None:  # 306, 1362
    mesh = make.icosphere(2)
    own = RayMeshIntersector(mesh)
    origins, directions = mesh.vertices + mesh.vertex_normals * 0.01, -mesh.vertex_normals
    batch = own.intersects_first(origins, directions)
    ones = [own.intersects_first([o], [d])[0] for o, d in zip(origins, directions, strict=True)]
    assert batch.tolist() == ones and (batch >= 0).all()


# ---- Inside -------------------------------------------------------------------------------------


def test_a_cavity_is_outside() -> None:  # 2534
    outer, inner = make.box([1, 1, 1]), make.box([0.1, 0.1, 0.1])
    inner.invert()
    mesh = trimesh.util.concatenate([outer, inner])
    mesh.ray = RayMeshIntersector(mesh)
    assert mesh.contains([[0, 0, 0], [0.2, 0.1, 0], [2, 0, 0]]).tolist() == [False, True, False]


def test_scaled_vertices_are_inside_or_outside() -> None:
    for mesh in CONVEX:
        own = RayMeshIntersector(mesh)
        centred = mesh.vertices - mesh.center_mass
        assert own.contains_points(mesh.center_mass + centred / 1.5).all()
        assert not own.contains_points(mesh.center_mass + centred * 1.5).any()
        assert own.contains_points([mesh.center_mass]).all()
    with pytest.raises(ValueError):
        own.contains_points([[1, 2]])


def test_trimesh_itself_works_with_it() -> None:
    own, other = make.torus(1, 0.3), make.torus(1, 0.3)
    own.ray = RayMeshIntersector(own)
    other.ray = ray_triangle.RayMeshIntersector(other)
    points = np.random.default_rng(4).uniform(-1.3, 1.3, (300, 3))
    np.testing.assert_array_equal(own.contains(points), other.contains(points))
    samples = trimesh.triangles.barycentric_to_points(
        own.triangles[::7], np.full((len(own.triangles[::7]), 3), 1 / 3)
    )
    normals = own.face_normals[::7]
    for method in ("ray", "max_sphere"):
        thick = [
            trimesh.proximity.thickness(m, samples, normals=normals, method=method)
            for m in (own, other)
        ]
        np.testing.assert_allclose(thick[0], thick[1], rtol=1e-6)
    assert trimesh.sample.volume_mesh(own, 50).shape[1] == 3


# ---- Shapes, copies, changes --------------------------------------------------------------------


def parameters_of(function: Any) -> list[inspect.Parameter]:
    """Parameters of a function, also of one in a decorator that hides them."""
    inner = [cell.cell_contents for cell in function.__closure__ or ()]
    bare = next((each for each in inner if inspect.isfunction(each)), function)
    return list(inspect.signature(bare).parameters.values())


def test_signatures_are_trimeshs() -> None:
    if not trimesh.ray.has_embree:
        pytest.skip("no embreex here")
    theirs = trimesh.ray.ray_pyembree.RayMeshIntersector
    methods = [name for name in vars(theirs) if name.startswith(("intersects", "contains"))]
    assert len(methods) == 5
    for name in ["__init__", *methods]:
        ours = parameters_of(getattr(RayMeshIntersector, name))
        expected = [(p.name, p.default) for p in parameters_of(getattr(theirs, name))]
        assert [(p.name, p.default) for p in ours[: len(expected)]] == expected, name
        assert all(p.kind is p.KEYWORD_ONLY for p in ours[len(expected) :]), name


@pytest.mark.parametrize("rays", [np.zeros((0, 3)), np.full((4, 3), 9.0), np.full((4, 3), np.nan)])
def test_no_hits_have_shapes_too(rays: NDArray[Any]) -> None:
    own = RayMeshIntersector(make.box())
    up = np.tile([[0.0, 0.0, 1.0]], (len(rays), 1))
    place, ray, tri = own.intersects_location(rays, up)
    assert place.shape == (0, 3) and ray.shape == tri.shape == (0,)
    assert [str(a.dtype) for a in (place, ray, tri)] == ["float64", "int64", "int64"]
    assert own.intersects_first(rays, up).tolist() == [-1] * len(rays)
    assert own.intersects_any(rays, up).tolist() == [False] * len(rays)
    assert not own.intersects_any(rays, 0 * up).any()


def test_rays_of_another_shape_are_refused() -> None:
    own = RayMeshIntersector(make.box())
    for origins, directions in (
        (np.zeros((4, 3)), np.zeros((3, 3))),
        (np.zeros((4, 3)), np.zeros(3)),
        (np.zeros(3), np.zeros(3)),
        (np.zeros((4, 2)), np.zeros((4, 2))),
    ):
        for method in (
            own.intersects_id,
            own.intersects_location,
            own.intersects_first,
            own.intersects_any,
        ):
            with pytest.raises(ValueError):
                method(origins, directions)


def test_arguments_are_left_as_they_are() -> None:
    origins, directions = np.full((3, 3), 5.0), np.full((3, 3), -2.0)
    RayMeshIntersector(make.box()).intersects_location(origins, directions)
    assert (origins == 5).all() and (directions == -2).all()


def test_a_mesh_without_triangles_is_missed() -> None:
    own = RayMeshIntersector(trimesh.Trimesh())
    assert own.intersects_first([[0, 0, 0]], [[0, 0, 1]]).tolist() == [-1]
    assert own.intersects_location([[0, 0, 0]], [[0, 0, 1]])[0].shape == (0, 3)


def test_a_changed_mesh_is_seen_and_an_unchanged_one_not_built_again() -> None:
    mesh = make.box()
    mesh.ray = RayMeshIntersector(mesh)
    ray = ([[0, 0, 5]], [[0, 0, -1]])
    assert mesh.ray.intersects_location(*ray)[0].max() == pytest.approx(0.5)
    scene = mesh.ray._scene
    mesh.ray.intersects_any(*ray)
    assert mesh.ray._scene is scene
    mesh.vertices[:, 2] += 1
    assert mesh.ray.intersects_location(*ray)[0].max() == pytest.approx(1.5)
    assert mesh.ray._scene is not scene
    mesh.apply_scale(2)
    assert mesh.ray.intersects_location(*ray)[0].max() == pytest.approx(3)
    mesh.update_faces(mesh.face_normals[:, 2] < 0.5)
    assert mesh.ray.intersects_location(*ray)[0].max() == pytest.approx(1)
    mesh.apply_translation([9, 9, 9])
    assert not mesh.ray.intersects_any(*ray).any()


@pytest.mark.parametrize(
    "way", [copy.copy, copy.deepcopy, lambda own: pickle.loads(pickle.dumps(own))]
)
def test_copies_answer_alike(way: Any) -> None:
    mesh = make.icosphere(2)
    own = RayMeshIntersector(mesh, scale_to_box=False, options=htree.Options("ah", threads=1))
    origins, directions = np.zeros((42, 3)), make.icosphere(1).vertices
    expected = own.intersects_first(origins, directions)
    other = way(own)
    assert type(other) is RayMeshIntersector and other is not own
    assert other._options == own._options and other._scale_to_box is False
    np.testing.assert_array_equal(other.intersects_first(origins, directions), expected)
    assert other._scene.tree is not own._scene.tree and other._scene.tree.kind == "ah"


def test_a_mesh_that_holds_one_can_be_copied() -> None:
    mesh = make.icosphere(1)
    mesh.ray = RayMeshIntersector(mesh)
    assert mesh.ray.intersects_any([[0, 0, 0]], [[0, 0, 1]]).all()
    for other in (mesh.copy(), copy.deepcopy(mesh), pickle.loads(pickle.dumps(mesh))):
        assert other.ray.intersects_any([[0, 0, 0]], [[0, 0, 1]]).all()
