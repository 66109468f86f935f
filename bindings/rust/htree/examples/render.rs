// SPDX-License-Identifier: MIT
//! A torus on a floor, with shadows, as a PPM: `cargo run --release --example render torus.ppm`.

use htree::{Hit, Kind, Mesh, Options, Ray, Tree};
use std::error::Error;
use std::f32::consts::TAU;
use std::io::Write;

type Vec3 = [f32; 3];

const WIDTH: usize = 320;
const HEIGHT: usize = 200;
const LIGHT: Vec3 = [0.48, -0.36, 0.8];

fn add_scaled(a: Vec3, s: f32, b: Vec3) -> Vec3 {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

fn dot(a: Vec3, b: Vec3) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn normalise(a: Vec3) -> Vec3 {
    add_scaled([0.0; 3], 1.0 / dot(a, a).sqrt(), a)
}

/// A torus of `n` by `n` squares, and a floor of two triangles below it.
fn scene(n: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let angle = |i: u32| TAU * i as f32 / n as f32;
    let corner = |i: u32, j: u32| {
        let radius = 1.0 + 0.4 * angle(j).cos();
        [radius * angle(i).cos(), radius * angle(i).sin(), 0.4 * angle(j).sin()]
    };
    let mut positions: Vec<_> = (0..n * n).map(|k| corner(k / n, k % n)).collect();
    let index = |i: u32, j: u32| i % n * n + j % n;
    let mut triangles = Vec::new();
    for (i, j) in (0..n * n).map(|k| (k / n, k % n)) {
        triangles.push([index(i, j), index(i + 1, j), index(i + 1, j + 1)]);
        triangles.push([index(i, j), index(i + 1, j + 1), index(i, j + 1)]);
    }
    let floor = n * n;
    positions.extend([[-9.0, -9.0, -0.4], [9.0, -9.0, -0.4], [9.0, 9.0, -0.4], [-9.0, 9.0, -0.4]]);
    triangles.extend([[floor, floor + 1, floor + 2], [floor, floor + 2, floor + 3]]);
    (positions, triangles)
}

fn camera_rays() -> Vec<Ray> {
    let eye = [0.0, -3.2, 2.2];
    let forward = normalise(add_scaled([0.0; 3], -1.0, eye));
    let right = normalise(cross(forward, [0.0, 0.0, 1.0]));
    let up = cross(right, forward);
    let scale = 0.9 / HEIGHT as f32;
    let pixels = (0..WIDTH * HEIGHT).map(|i| (i % WIDTH, i / WIDTH));
    let rays = pixels.map(|(x, y)| {
        let x = scale * (x as f32 + 0.5 - 0.5 * WIDTH as f32);
        let y = scale * (0.5 * HEIGHT as f32 - y as f32 - 0.5);
        Ray::new(eye, add_scaled(add_scaled(forward, x, right), y, up))
    });
    rays.collect()
}

/// The triangle's normal, towards the eye.
fn normal_at(corners: &[Vec3; 3], ray: &Ray) -> Vec3 {
    let [a, b, c] = *corners;
    let normal = normalise(cross(add_scaled(b, -1.0, a), add_scaled(c, -1.0, a)));
    if dot(normal, ray.dir) > 0.0 {
        add_scaled([0.0; 3], -1.0, normal)
    } else {
        normal
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("usage: render OUT.ppm")?;
    let (positions, triangles) = scene(96);
    let mesh = Mesh::new(&positions).indices(&triangles);
    let tree = Tree::build(&mesh, &Options::new(Kind::FAST))?;

    let rays = camera_rays();
    let mut hits = vec![Hit::default(); rays.len()];
    tree.intersect(&rays, &mut hits)?;

    // One shadow ray a pixel, a little off the surface; those of the sky point nowhere and miss.
    let normals: Vec<_> = hits
        .iter()
        .zip(&rays)
        .map(|(hit, ray)| {
            let triangle = triangles.get(hit.prim as usize)?;
            Some(normal_at(&triangle.map(|vertex| positions[vertex as usize]), ray))
        })
        .collect();
    let to_light = |i: usize| match normals[i] {
        Some(normal) => Ray::new(add_scaled(rays[i].at(hits[i].t), 1e-3, normal), LIGHT),
        None => Ray::new([0.0; 3], [0.0; 3]),
    };
    let shadow_rays: Vec<_> = (0..rays.len()).map(to_light).collect();
    let mut shadow = vec![false; rays.len()];
    tree.occluded(&shadow_rays, &mut shadow)?;

    let mut picture = format!("P6\n{WIDTH} {HEIGHT}\n255\n").into_bytes();
    for (normal, shadow) in normals.iter().zip(shadow) {
        let colour = match normal {
            Some(normal) => {
                let light = if shadow { 0.0 } else { dot(*normal, LIGHT).max(0.0) };
                [1.0, 0.85, 0.6].map(|albedo| albedo * (0.15 + 0.85 * light))
            }
            None => [0.6, 0.75, 0.95],
        };
        picture.extend(colour.map(|value: f32| (255.0 * value.sqrt()).min(255.0) as u8));
    }
    std::fs::File::create(&path)?.write_all(&picture)?;
    println!("{path}: {WIDTH} x {HEIGHT}, {} triangles", triangles.len());
    Ok(())
}
