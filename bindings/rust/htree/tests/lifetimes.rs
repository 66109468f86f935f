// SPDX-License-Identifier: MIT
//! Trees on many threads, and dropped in every order.

mod common;

use common::{rays_down, terrain};
use htree::{Hit, Kind, Mesh, Options, Query, Tree};
use std::sync::Arc;
use std::thread;

fn assert_send_sync<T: Send + Sync>() {}

#[test]
fn trees_and_options_go_to_any_thread() {
    assert_send_sync::<Tree>();
    assert_send_sync::<Options>();
    assert_send_sync::<Mesh<'_>>();
    assert_send_sync::<htree::Error>();
    assert_send_sync::<htree::View<'_>>();
}

#[test]
fn many_threads_query_one_tree_and_the_last_one_drops_it() {
    let (positions, triangles) = terrain(40);
    let tree = Arc::new(Tree::new(&Mesh::new(&positions).indices(&triangles)).unwrap());
    let rays = Arc::new(rays_down(40, 5_000));
    let mut wanted = vec![Hit::default(); rays.len()];
    tree.intersect(&rays, &mut wanted).unwrap();
    let threads: Vec<_> = (0..8)
        .map(|i| {
            let (tree, rays, wanted) = (Arc::clone(&tree), Arc::clone(&rays), wanted.clone());
            thread::spawn(move || {
                for round in 0..20 {
                    let mut hits = vec![Hit::default(); rays.len()];
                    let query = Query::new().threads((i + round) % 3);
                    tree.intersect_with(&rays, &mut hits, query).unwrap();
                    assert_eq!(hits, wanted);
                }
            })
        })
        .collect();
    drop(tree);
    for thread in threads {
        thread.join().unwrap();
    }
}

#[test]
fn builds_run_at_once() {
    let (positions, triangles) = terrain(30);
    let mesh = Mesh::new(&positions).indices(&triangles);
    thread::scope(|scope| {
        for kind in [Kind::UG, Kind::KD, Kind::BVH_SAH, Kind::H, Kind::AH] {
            let mesh = &mesh;
            scope.spawn(move || {
                for _ in 0..5 {
                    Tree::build(mesh, &Options::new(kind)).unwrap().check().unwrap();
                }
            });
        }
    });
}

#[test]
fn errors_keep_their_text_on_their_thread() {
    let threads: Vec<_> = (10..20u32)
        .map(|vertex| {
            thread::spawn(move || {
                for _ in 0..500 {
                    let error = Tree::new(&Mesh::new(&[[0.0; 3]; 3]).indices(&[[0, 1, vertex]]));
                    let wanted = format!("triangle 0 refers to vertex {vertex} of 3");
                    assert_eq!(error.unwrap_err().text(), wanted);
                }
            })
        })
        .collect();
    for thread in threads {
        thread.join().unwrap();
    }
}

#[test]
fn trees_drop_in_any_order() {
    let (positions, triangles) = terrain(8);
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    for order in orders {
        let mesh = Mesh::new(&positions).indices(&triangles);
        let mut trees: Vec<_> = (0..3).map(|_| Some(Tree::new(&mesh).unwrap())).collect();
        for i in order {
            trees[i] = None;
            trees.iter().flatten().for_each(|tree| tree.check().unwrap());
        }
    }
    // In place, out of place, by a panic.
    let mesh = Mesh::new(&positions).indices(&triangles);
    let mut tree = Tree::new(&mesh).unwrap();
    tree.check().unwrap();
    tree = Tree::build(&mesh, &Options::new(Kind::KD)).unwrap();
    let held = std::mem::take(&mut Some(tree));
    let unwound = std::panic::catch_unwind(std::panic::AssertUnwindSafe(move || {
        let _tree = held;
        panic!("with a tree in hand");
    }));
    assert!(unwound.is_err());
}
