// SPDX-License-Identifier: MIT
//! What each library builds from a scene, and how it finds closest hits.

use crate::scene::{Result, Scene};
use crate::Turns;
use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::BHShape;
use bvh::bvh::Bvh;
use htree::{Hit, Kind, Options, Query, Ray, Tree};
use nalgebra::{Point3, Vector3};
use obvhs::cwbvh::{builder::build_cwbvh_from_tris, CwBvh};
use obvhs::{ray::RayHit, rt_triangle::RtTriangle, triangle::Triangle, BvhBuildParams};
use std::time::Duration;

/// htree begins: its answers are those that others are compared with.
pub fn take_turns(turns: &mut Turns, scene: &Scene) -> Result<()> {
    for (name, kind) in [("fast", Kind::FAST), ("balanced", Kind::BALANCED), ("best", Kind::BEST)] {
        let options = Options::new(kind).threads(1);
        let build = |mesh: &mut _| Tree::build(mesh, &options).expect("indices of vertices");
        turns.take(&format!("htree {name}"), &mut scene.mesh(), build, |_, tree, rays, hits| {
            tree.intersect_with(rays, hits, Query::new().threads(1)).expect("as many hits as rays");
        })?;
    }
    let corners = (0..scene.indices.len()).map(|i| scene.corners(i).map(Into::into));
    let mut triangles: Vec<_> = corners.map(|[v0, v1, v2]| Triangle { v0, v1, v2 }).collect();
    let mut shapes: Vec<_> = triangles.iter().enumerate().map(Shape::new).collect();
    for (name, preset) in [
        ("fastest", BvhBuildParams::fastest_build()),
        ("medium", BvhBuildParams::medium_build()),
        ("slow", BvhBuildParams::slow_build()),
    ] {
        let build = |triangles: &mut Vec<Triangle>| {
            let bvh = build_cwbvh_from_tris(triangles, preset, &mut Duration::default());
            let ordered = bvh.primitive_indices.iter().map(|i| (&triangles[*i as usize]).into());
            (ordered.collect::<Vec<RtTriangle>>(), bvh)
        };
        let trace = |_: &_,
                     (ordered, bvh): &(Vec<RtTriangle>, CwBvh),
                     rays: &[Ray],
                     hits: &mut [Hit]| {
            rays.iter().zip(hits).for_each(|(ray, hit)| *hit = closest_of_obvhs(bvh, ordered, ray));
        };
        turns.take(&format!("obvhs {name}"), &mut triangles, build, trace)?;
    }
    let build = |shapes: &mut [Shape]| Bvh::build(shapes);
    turns.take("bvh", &mut shapes[..], build, |shapes, bvh, rays, hits| {
        rays.iter().zip(hits).for_each(|(ray, hit)| *hit = closest_of_bvh(bvh, shapes, ray));
    })
}

fn to_obvhs(ray: &Ray) -> obvhs::ray::Ray {
    obvhs::ray::Ray::new(ray.org.into(), ray.dir.into(), ray.tmin, ray.tmax)
}

fn closest_of_obvhs(bvh: &CwBvh, ordered: &[RtTriangle], ray: &Ray) -> Hit {
    let mut found = RayHit::none();
    if !bvh.ray_traverse(to_obvhs(ray), &mut found, |ray, i| ordered[i].intersect(ray)) {
        return Hit::default();
    }
    let prim = bvh.primitive_indices[found.primitive_id as usize];
    Hit { t: found.t, prim, ..Hit::default() }
}

struct Shape {
    triangle: RtTriangle,
    bounds: Aabb<f32, 3>,
    prim: u32,
}

impl Shape {
    fn new((prim, of): (usize, &Triangle)) -> Self {
        let [lo, hi] = [of.v0.min(of.v1).min(of.v2), of.v0.max(of.v1).max(of.v2)]
            .map(|corner| Point3::from(corner.to_array()));
        Self { triangle: of.into(), bounds: Aabb::with_bounds(lo, hi), prim: prim as u32 }
    }
}

impl Bounded<f32, 3> for Shape {
    fn aabb(&self) -> Aabb<f32, 3> {
        self.bounds
    }
}

impl BHShape<f32, 3> for Shape {
    fn set_bh_node_index(&mut self, _: usize) {}

    fn bh_node_index(&self) -> usize {
        unreachable!("nothing is changed after a build")
    }
}

/// Shapes come in the order in which the ray enters their boxes.
fn closest_of_bvh(bvh: &Bvh<f32, 3>, shapes: &[Shape], ray: &Ray) -> Hit {
    // Not by its `new`, which makes the direction's length 1, and t another one.
    let (origin, direction) = (Point3::from(ray.org), Vector3::from(ray.dir));
    let boxes = bvh::ray::Ray { origin, direction, inv_direction: direction.map(|x| 1.0 / x) };
    let mut left = to_obvhs(ray);
    let mut closest = Hit::default();
    for shape in bvh.nearest_traverse_iterator(&boxes, shapes) {
        let overlap = boxes.intersection_slice_for_aabb(&shape.bounds);
        if overlap.is_some_and(|(entry, _)| entry > left.tmax) {
            break;
        }
        let t = shape.triangle.intersect(&left);
        if t < left.tmax {
            left.tmax = t;
            closest = Hit { t, prim: shape.prim, ..Hit::default() };
        }
    }
    closest
}
