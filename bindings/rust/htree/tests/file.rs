// SPDX-License-Identifier: MIT
//! A tree that is saved and loaded is the same tree, and what is no tree is not loaded.

mod common;

use common::{rays_down, terrain};
use htree::{
    Aabb, ErrorKind, Hit, Kind, LoadOptions, Mesh, ObjectHit, Objects, Options, Ray, Tree,
};

#[test]
fn a_saved_tree_comes_back() {
    let (positions, triangles) = terrain(20);
    let rays = rays_down(20, 2_000);
    for kind in [
        Kind::UG,
        Kind::KD,
        Kind::BVH_MEDIAN,
        Kind::BVH_SAH,
        Kind::SKD,
        Kind::H,
        Kind::AH,
        Kind::WIDE,
    ] {
        let mesh = Mesh::new(&positions).indices(&triangles);
        let tree = Tree::build(&mesh, &Options::new(kind)).unwrap();
        let file = tree.save().unwrap();
        let back = LoadOptions::new().threads(1).load(&file).unwrap();
        let mut hits = [vec![Hit::default(); rays.len()], vec![Hit::default(); rays.len()]];
        tree.intersect(&rays, &mut hits[0]).unwrap();
        back.intersect(&rays, &mut hits[1]).unwrap();
        assert_eq!(hits[0], hits[1]);
        assert_eq!(back.save().unwrap(), file);
        assert_eq!(back.view().unwrap().kind, kind);
        back.check().unwrap();
    }
}

#[test]
fn objects_need_their_function_again() {
    let boxes = [Aabb { lo: [0.0; 3], hi: [1.0; 3] }, Aabb { lo: [2.0, 0.0, 0.0], hi: [3.0; 3] }];
    let top = |object: u32, ray: &Ray| {
        let t = (1.0 - ray.org[2]) / ray.dir[2];
        Some(ObjectHit { t, u: 0.0, v: object as f32 })
    };
    let tree = Tree::new(&Mesh::new(&[]).objects(Objects::new(&boxes, top))).unwrap();
    let file = tree.save().unwrap();
    assert_eq!(Tree::load(&file).unwrap_err().kind(), ErrorKind::Argument);
    let back = LoadOptions::new().objects(top).load(&file).unwrap();
    drop(tree);
    let hit = back.intersect_one(&Ray::new([2.5, 0.5, 5.0], [0.0, 0.0, -1.0])).unwrap().unwrap();
    assert_eq!((hit.t, hit.v, hit.prim), (4.0, 1.0, 1));
}

#[test]
fn what_is_no_tree_is_not_loaded() {
    let (positions, triangles) = terrain(5);
    let file = Tree::new(&Mesh::new(&positions).indices(&triangles)).unwrap().save().unwrap();
    let mut changed = file.clone();
    changed[file.len() / 2] ^= 1;
    let longer = [&file[..], &[0]].concat();
    for bad in [&[][..], &file[..100], &file[..file.len() - 1], &longer, &changed] {
        let error = Tree::load(bad).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Corrupt);
        assert!(!error.to_string().is_empty());
    }
}
