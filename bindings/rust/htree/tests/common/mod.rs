// SPDX-License-Identifier: MIT
//! What the tests share: a wavy terrain, rays over it, and the conformance file.
#![allow(dead_code)]

use htree::Ray;
use serde_json::Value;

/// Positions and triangles of `side` x `side` squares.
pub fn terrain(side: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let row = side + 1;
    let height = |x: u32, y: u32| (x as f32 * 0.7).sin() + (y as f32 * 0.3).cos();
    let points = (0..row * row).map(|i| (i % row, i / row));
    let positions = points.map(|(x, y)| [x as f32, y as f32, height(x, y)]).collect();
    let squares = (0..side * side).map(|i| i % side + i / side * row);
    let triangles = squares.flat_map(|a| [[a, a + 1, a + row], [a + 1, a + row + 1, a + row]]);
    (positions, triangles.collect())
}

/// Slanted rays from above a terrain of that side; some pass it by.
pub fn rays_down(side: u32, count: usize) -> Vec<Ray> {
    let spread = |i: usize, step: f32| (i as f32 * step).fract() * 1.2 * side as f32;
    (0..count)
        .map(|i| Ray::new([spread(i, 0.618_034), spread(i, 0.414_214), 5.0], [0.1, 0.2, -1.0]))
        .collect()
}

/// The conformance file that every binding reads.
pub fn conformance() -> Value {
    let path = std::env::var("HTREE_CONFORMANCE").unwrap_or_else(|_| {
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../../build/release/conformance.json").to_string()
    });
    let text = std::fs::read_to_string(&path)
        .unwrap_or_else(|why| panic!("{path}: {why}; HTREE_CONFORMANCE names the file"));
    let file: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(file["format"], 1);
    file
}

/// The numbers of a list of the conformance file.
pub fn words(list: &Value) -> Vec<u32> {
    let list = list.as_array().expect("a list");
    list.iter().map(|word| word.as_u64().unwrap().try_into().unwrap()).collect()
}
