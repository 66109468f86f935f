// SPDX-License-Identifier: MIT
//! Triangles and rays, the same for all: from files, or made here.

use glam::Vec3;
use htree::{Hit, Mesh, Options, Ray, Tree};
use obvhs::test_util::geometry::demoscene;
use obvhs::test_util::sampling::{uhash2, uniform_sample_sphere, unormf};
use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{DefaultElement, Property};

pub type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

pub struct Scene {
    pub positions: Vec<[f32; 3]>,
    pub indices: Vec<[u32; 3]>,
}

impl Scene {
    /// The vertices and faces of a PLY file; polygons become fans.
    pub fn load(path: &str) -> Result<Self> {
        let bytes = std::fs::read(path)?;
        let ply = Parser::<DefaultElement>::new().read_ply(&mut &bytes[..])?;
        let position = |vertex: &DefaultElement| {
            ["x", "y", "z"].map(|axis| match vertex[axis] {
                Property::Float(x) => x,
                Property::Double(x) => x as f32,
                _ => f32::NAN,
            })
        };
        let fan = |face: &DefaultElement| {
            let polygon: Vec<_> = match face.values().next() {
                Some(Property::ListInt(list)) => list.iter().map(|i| *i as u32).collect(),
                _ => panic!("a face is no list of int"),
            };
            (2..polygon.len()).map(move |i| [polygon[0], polygon[i - 1], polygon[i]])
        };
        let positions = ply.payload["vertex"].iter().map(position).collect();
        Ok(Self { positions, indices: ply.payload["face"].iter().flat_map(fan).collect() })
    }

    /// Hills, by obvhs, of 2 n^2 triangles.
    pub fn hills(n: usize) -> Self {
        let triangles = demoscene(n, 1).into_iter();
        let positions: Vec<_> =
            triangles.flat_map(|it| [it.v0, it.v1, it.v2].map(Into::into)).collect();
        let indices = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
        Self { indices: indices.collect(), positions }
    }

    pub fn mesh(&self) -> Mesh<'_> {
        Mesh::new(&self.positions).indices(&self.indices)
    }

    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.indices[triangle].map(|vertex| Vec3::from(self.positions[vertex as usize]))
    }
}

/// Rays for the closest hit: of a picture, and onward from all that is seen.
pub struct Rays {
    pub primary: Vec<Ray>,
    pub diffuse: Vec<Ray>,
}

impl Rays {
    /// What `htree-bench --save-rays` wrote for that scene: lines up to `end`, then 32 bytes a ray.
    pub fn load(path: &str, scene: &Scene) -> Result<Self> {
        let bytes = std::fs::read(path)?;
        let end = bytes.windows(5).position(|part| part == b"\nend\n").unwrap_or(0);
        let (head, mut body) = (std::str::from_utf8(&bytes[..end])?, &bytes[end + 5..]);
        let count = scene.indices.len();
        let expected = format!("htree-rays 1 little-endian\ntriangles {count}\n");
        let strange = || format!("{path}: not rays of {count} triangles");
        let mut rays = Self { primary: Vec::new(), diffuse: Vec::new() };
        for line in head.strip_prefix(&expected).ok_or_else(strange)?.lines() {
            let words: Vec<_> = line.split(' ').collect();
            let size = words[1].parse::<usize>()? * size_of::<Ray>();
            let (set, rest) = body.split_at_checked(size).ok_or_else(strange)?;
            match words[0] {
                "primary" => rays.primary = bytemuck::pod_collect_to_vec(set),
                "diffuse" => rays.diffuse = bytemuck::pod_collect_to_vec(set),
                _ => {}
            }
            body = rest;
        }
        Ok(rays)
    }

    /// A square picture from outside; onward in directions that are cosine-distributed.
    pub fn make(scene: &Scene, side: u32) -> Result<Self> {
        let tree = Tree::build(&scene.mesh(), &Options::default())?;
        let (lo, hi) = (Vec3::from(tree.bounds().lo), Vec3::from(tree.bounds().hi));
        let forward = Vec3::new(-0.5, -0.6, -0.8).normalize();
        let right = forward.cross(Vec3::Y).normalize();
        let eye = 0.5 * (lo + hi) - 1.2 * (hi - lo).length() * forward;
        let pixel = |i: u32| {
            let [x, y] = [i % side, i / side].map(|i| (i as f32 + 0.5) / side as f32 - 0.5);
            Ray::new(eye.into(), (forward + x * right - y * right.cross(forward)).into())
        };
        let primary: Vec<_> = (0..side * side).map(pixel).collect();
        let mut hits = vec![Hit::default(); primary.len()];
        tree.intersect(&primary, &mut hits)?;
        let onward = |(ray, hit): (&Ray, &Hit)| {
            let [a, b, c] = scene.corners(hit.prim as usize);
            let normal = (b - a).cross(c - a).normalize();
            let normal = -normal * normal.dot(ray.dir.into()).signum();
            let random = [1, 2].map(|seed| unormf(uhash2(hit.u.to_bits() ^ hit.prim, seed)));
            let direction = normal + 0.999 * Vec3::from(uniform_sample_sphere(random.into()));
            Ray::new((Vec3::from(ray.at(hit.t)) + 1e-4 * hit.t * normal).into(), direction.into())
        };
        let seen = primary.iter().zip(&hits).filter(|(_, hit)| hit.is_hit());
        Ok(Self { diffuse: seen.map(onward).collect(), primary })
    }
}
