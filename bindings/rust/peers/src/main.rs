// SPDX-License-Identifier: MIT
//! Builds and closest hits of htree beside those of other crates: `make bench-rust`, or
//!
//! `cargo run --release -- [MESH.ply RAYS]... [MESH.ply]`: RAYS by `htree-bench --save-rays`, or else
//! made here, as hills are if there is no mesh.

mod peers;
mod scene;

use criterion::{Bencher, Criterion, SamplingMode};
use glam::Vec3;
use htree::{Hit, Ray};
use scene::{Rays, Result, Scene};
use std::fmt::Write;
use std::time::{Duration, Instant};
use std::{env, fs, hint::black_box};

const NOTES: &str = "\
# builds and rays on 1 thread, one contender after the other; medians of 10 samples, and the median deviation from them
# htree: Tree::build from positions and indices; intersect, the batch at once
# obvhs: build_cwbvh_from_tris by that preset, then its RtTriangle in the order of the leaves; ray_traverse, ray by ray
# bvh: Bvh::build; nearest_traverse_iterator, ray by ray, and RtTriangle, for its own test culls back faces";

/// A scene, and the table of those that had their turn at it.
pub struct Turns<'a> {
    scene: &'a Scene,
    rays: Rays,
    expected: [Option<Vec<Hit>>; 2],
    table: String,
}

impl Turns<'_> {
    fn take<S: ?Sized, T>(
        &mut self,
        name: &str,
        source: &mut S,
        build: impl Fn(&mut S) -> T,
        trace: impl Fn(&S, &T, &[Ray], &mut [Hit]),
    ) -> Result<()> {
        let mut time_build = |_| {
            let start = Instant::now();
            let built = black_box(build(source));
            let spent = start.elapsed();
            drop(built);
            spent
        };
        let (ns, spread) =
            time("build", name, |b| b.iter_custom(|n| (0..n).map(&mut time_build).sum()))?;
        write!(
            self.table,
            "\n{name:17}{:12.1} {spread:5.1}",
            ns / self.scene.indices.len() as f64
        )?;
        let built = build(source);
        let sets = [("primary", &self.rays.primary), ("diffuse", &self.rays.diffuse)];
        for (i, (set, rays)) in sets.into_iter().enumerate() {
            let mut hits = vec![Hit::default(); rays.len()];
            let (ns, spread) =
                time(set, name, |b| b.iter(|| trace(source, &built, rays, &mut hits)))?;
            let all = self.expected[i].get_or_insert_with(|| hits.clone()).iter().zip(&hits);
            let differ =
                rays.iter().zip(all).filter(|(ray, (it, hit))| !agrees(ray, hit, it)).count();
            write!(self.table, "{:17.2} {spread:5.1} {differ:7}", 1e3 * rays.len() as f64 / ns)?;
        }
        Ok(())
    }
}

/// Whether `hit` is at the same t, as far as another triangle test rounds.
fn agrees(ray: &Ray, hit: &Hit, expected: &Hit) -> bool {
    let (largest, length) = (Vec3::from(ray.org).abs().max_element(), Vec3::from(ray.dir).length());
    let apart = (hit.t - expected.t).abs() * length;
    let near = !hit.is_hit() || apart <= 1e-4 * expected.t * length + 1e-5 * largest;
    hit.is_hit() == expected.is_hit() && near
}

/// Nanoseconds, the median of ten samples, and the median deviation from it in percent.
fn time(what: &str, name: &str, run: impl FnMut(&mut Bencher)) -> Result<(f64, f64)> {
    let folder = env::temp_dir().join(format!("htree-peers-{}", std::process::id()));
    let criterion = Criterion::default().output_directory(&folder).without_plots();
    let mut criterion = criterion.sample_size(10).nresamples(2000);
    let mut group = criterion.benchmark_group(what);
    group.warm_up_time(Duration::from_millis(100)).measurement_time(Duration::from_millis(400));
    group.sampling_mode(SamplingMode::Flat).bench_function(name, run);
    group.finish();
    let text = fs::read(folder.join(what).join(name).join("new/estimates.json"))?;
    fs::remove_dir_all(folder)?;
    let estimates: serde_json::Value = serde_json::from_slice(&text)?;
    let [median, spread] = ["median", "median_abs_dev"]
        .map(|of| estimates[of]["point_estimate"].as_f64().unwrap_or(f64::NAN));
    Ok((median, 100.0 * spread / median))
}

fn measure(name: &str, scene: &Scene, rays: Rays) -> Result<String> {
    let [primary, diffuse] = [&rays.primary, &rays.diffuse].map(Vec::len);
    let count = scene.indices.len();
    let table = format!(
        "\nScene {name} - {count} triangles, {primary} primary and {diffuse} diffuse rays\n\
         Method           build ns/tri   +-%  primary Mrays/s   +-%  differ  diffuse Mrays/s   +-%  differ"
    );
    let mut turns = Turns { scene, rays, expected: [None, None], table };
    peers::take_turns(&mut turns, scene)?;
    Ok(turns.table + "\n")
}

fn main() -> Result<()> {
    let crates = ["htree", "obvhs", "bvh", "criterion"].map(|of| {
        let lock = include_str!("../Cargo.lock").rsplit_once(&format!("\"{of}\"\nversion = \""));
        format!("{of} {}", lock.and_then(|(_, rest)| rest.split('"').next()).unwrap_or("unknown"))
    });
    let mut text = format!("\n# crates: {}\n{NOTES}\n", crates.join(", "));
    let files: Vec<_> = env::args().skip(1).collect();
    for pair in files.chunks(2) {
        let scene = Scene::load(&pair[0])?;
        let rays = match pair.get(1) {
            Some(path) => Rays::load(path, &scene)?,
            None => Rays::make(&scene, 512)?,
        };
        text += &measure(pair[0].rsplit('/').next().unwrap_or_default(), &scene, rays)?;
    }
    if files.is_empty() {
        let hills = Scene::hills(256);
        text += &measure("hills", &hills, Rays::make(&hills, 512)?)?;
    }
    println!("{text}");
    Ok(())
}
