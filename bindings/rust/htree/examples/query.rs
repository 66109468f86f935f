// SPDX-License-Identifier: MIT
//! Picks points of a mesh, and of spheres beside it: `cargo run --example query`.

use htree::{Aabb, Counters, Hit, Mesh, ObjectHit, Objects, Options, Query, Ray, Tree};

/// The nearer point of the sphere on the ray that counts.
fn intersect_sphere(centre: [f32; 3], radius: f32, ray: &Ray) -> Option<ObjectHit> {
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let off = [ray.org[0] - centre[0], ray.org[1] - centre[1], ray.org[2] - centre[2]];
    let (a, b) = (dot(ray.dir, ray.dir), dot(ray.dir, off));
    let root = (b * b - a * (dot(off, off) - radius * radius)).sqrt();
    let counts = |t: &f32| ray.tmin <= *t && *t <= ray.tmax;
    let t = [(-b - root) / a, (-b + root) / a].into_iter().find(counts)?;
    Some(ObjectHit { t, u: 0.0, v: 0.0 })
}

fn main() -> htree::Result<()> {
    let (major, minor, patch) = htree::library_version();
    println!("htree {} over libhtree {major}.{minor}.{patch}", htree::VERSION);

    let square = [[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [2.0, 2.0, 0.0], [-2.0, 2.0, 0.0]];
    let spheres = [([0.0, 0.0, 1.0], 0.5), ([1.0, 1.0, 0.5], 0.25_f32)];
    let boxes = spheres.map(|(centre, radius)| Aabb {
        lo: centre.map(|x: f32| x - radius),
        hi: centre.map(|x: f32| x + radius),
    });
    let objects = Objects::new(&boxes, move |object: u32, ray: &Ray| {
        let (centre, radius) = spheres[object as usize];
        intersect_sphere(centre, radius, ray)
    });
    let mesh = Mesh::new(&square).indices(&[[0, 1, 2], [0, 2, 3]]).objects(objects);
    let tree = Tree::build(&mesh, &Options::default())?;

    let down = |x: f32, y: f32| Ray::new([x, y, 5.0], [0.0, 0.0, -1.0]);
    let rays = [down(0.0, 0.0), down(1.0, 1.0), down(-1.0, 1.0), down(3.0, 0.0)];
    let mut hits = [Hit::default(); 4];
    let mut costs = [Counters::default(); 4];
    tree.intersect_with(&rays, &mut hits, Query::new().counters(&mut costs))?;
    for ((ray, hit), cost) in rays.iter().zip(&hits).zip(&costs) {
        let what = match hit.prim {
            htree::NONE => "nothing".to_string(),
            prim @ 0..=1 => format!("triangle {prim} at {:?}", ray.at(hit.t)),
            prim => format!("sphere {} at {:?}", prim - 2, ray.at(hit.t)),
        };
        println!("from {:?}: {what}, {} steps", ray.org, cost.traversal_steps);
    }
    Ok(())
}
