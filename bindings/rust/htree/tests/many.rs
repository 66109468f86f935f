// SPDX-License-Identifier: MIT
//! A hundred thousand trees. Alone in its program, since memory is counted for a whole process.
#![cfg(target_os = "linux")]

mod common;

use common::{rays_down, terrain};
use htree::{Aabb, Mesh, ObjectHit, Objects, Ray, Tree};
use std::sync::Arc;

fn resident_bytes() -> usize {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap();
    pages.split(' ').nth(1).unwrap().parse::<usize>().unwrap() * 4096
}

#[test]
fn a_hundred_thousand_trees_leave_nothing_behind() {
    let (positions, triangles) = terrain(2);
    let ray = rays_down(2, 1)[0];
    let alive = Arc::new(());
    let boxes = [Aabb { lo: [0.0; 3], hi: [1.0; 3] }];
    let round = |count: usize| {
        for i in 0..count {
            let held = Arc::clone(&alive);
            let objects = Objects::new(&boxes, move |_object: u32, _ray: &Ray| {
                let _ = &held;
                None::<ObjectHit>
            });
            let mesh = Mesh::new(&positions).indices(&triangles).objects(objects);
            let tree = Tree::new(&mesh).unwrap();
            tree.intersect_one(&ray).unwrap();
            if i % 100 == 0 {
                let bad = Mesh::new(&positions).indices(&[[0, 1, 99]]);
                assert!(Tree::new(&bad).is_err());
            }
        }
    };
    round(10_000);
    let before = resident_bytes();
    round(100_000);
    let growth = resident_bytes().saturating_sub(before);
    println!("{growth} bytes more");
    // A leak of 16 bytes a tree would be 1.6 million.
    assert!(growth < 1 << 20, "{growth} bytes more after 10^5 trees");
    assert_eq!(Arc::strong_count(&alive), 1);
}
