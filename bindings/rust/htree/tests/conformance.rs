// SPDX-License-Identifier: MIT
//! Every scene of the conformance file, with every kind: the hits that C found, bit for bit.

mod common;

use common::{conformance, words};
use htree::{Aabb, ErrorKind, Hit, How, Kind, LazyTree, Mesh, Options, Query, Ray, Tree};
use serde_json::Value;

/// A scene: its floats by their bits.
struct Scene {
    name: String,
    positions: Vec<f32>,
    indices: Option<Vec<u32>>,
    rays: Vec<Ray>,
    hits: Vec<u32>,
    occluded: Vec<bool>,
    bounds: Vec<u32>,
    stats: Value,
}

impl Scene {
    fn read(scene: &Value) -> Self {
        let floats = |name: &str| -> Vec<f32> {
            words(&scene[name]).into_iter().map(f32::from_bits).collect()
        };
        Self {
            name: scene["name"].as_str().unwrap().to_string(),
            positions: floats("positions"),
            indices: (!scene["indices"].is_null()).then(|| words(&scene["indices"])),
            rays: bytemuck::cast_slice(&floats("rays")).to_vec(),
            hits: words(&scene["hits"]),
            occluded: words(&scene["occluded"]).into_iter().map(|it| it != 0).collect(),
            bounds: words(&scene["bounds"]),
            stats: scene["stats"].clone(),
        }
    }

    fn mesh(&self) -> Mesh<'_> {
        let mesh = Mesh::from_floats(&self.positions);
        match &self.indices {
            Some(indices) => mesh.flat_indices(indices),
            None => mesh,
        }
    }
}

fn scenes_and_kinds() -> (Vec<Scene>, Vec<Kind>) {
    let file = conformance();
    let scenes: Vec<_> = file["scenes"].as_array().unwrap().iter().map(Scene::read).collect();
    let kinds: Vec<Kind> = file["kinds"]
        .as_array()
        .unwrap()
        .iter()
        .map(|name| name.as_str().unwrap().parse().unwrap())
        .collect();
    assert!(scenes.len() >= 2 && kinds.len() >= 7);
    (scenes, kinds)
}

#[test]
fn hits_are_those_of_c_to_the_bit() {
    let (scenes, kinds) = scenes_and_kinds();
    let mut compared = 0;
    for scene in &scenes {
        assert_eq!(scene.hits.len(), 4 * scene.rays.len());
        for (&kind, threads) in kinds.iter().flat_map(|kind| [(kind, 1), (kind, 0)]) {
            let name = format!("{}, {kind}, {threads} threads", scene.name);
            let tree = Tree::build(&scene.mesh(), &Options::new(kind).threads(threads)).unwrap();
            let mut hits = vec![Hit::default(); scene.rays.len()];
            tree.intersect(&scene.rays, &mut hits).unwrap();
            assert_eq!(bytemuck::cast_slice::<_, u32>(&hits), scene.hits, "hits of {name}");
            let mut occluded = vec![false; scene.rays.len()];
            tree.occluded_with(&scene.rays, &mut occluded, Query::new().threads(threads)).unwrap();
            assert_eq!(occluded, scene.occluded, "occluded of {name}");
            tree.check().unwrap();
            compared += hits.len();
        }
    }
    println!("{compared} hits compared over {} scenes", scenes.len());
}

fn assert_answers(scene: &Scene, tree: &Tree) {
    let mut hits = vec![Hit::default(); scene.rays.len()];
    tree.intersect(&scene.rays, &mut hits).unwrap();
    assert_eq!(bytemuck::cast_slice::<_, u32>(&hits), scene.hits, "hits of {}", scene.name);
    let mut occluded = vec![false; scene.rays.len()];
    tree.occluded(&scene.rays, &mut occluded).unwrap();
    assert_eq!(occluded, scene.occluded, "occluded of {}", scene.name);
    tree.check().unwrap();
}

#[test]
fn lazy_trees_and_complete_ones_give_the_hits_of_c() {
    for scene in &scenes_and_kinds().0 {
        let tree = LazyTree::build(&scene.mesh(), &Options::new(Kind::WIDE)).unwrap();
        assert_answers(scene, &tree);
        assert_answers(scene, &tree.complete().unwrap());
    }
}

#[test]
fn a_tree_that_goes_from_scene_to_scene_gives_the_hits_of_c() {
    let (scenes, kinds) = scenes_and_kinds();
    for kind in kinds {
        let mut tree = Tree::build(&Mesh::new(&[]), &Options::new(kind)).unwrap();
        for (scene, how) in scenes.iter().flat_map(|it| [(it, How::Rebuild), (it, How::Refit)]) {
            tree.update(&scene.mesh(), how).unwrap();
            assert_answers(scene, &tree);
        }
    }
}

#[test]
fn a_ray_alone_gets_the_hit_that_it_gets_in_a_batch() {
    let (scenes, kinds) = scenes_and_kinds();
    for (scene, &kind) in
        scenes.iter().flat_map(|scene| kinds.iter().map(move |kind| (scene, kind)))
    {
        let tree = Tree::build(&scene.mesh(), &Options::new(kind)).unwrap();
        for (ray, wanted) in scene.rays.iter().zip(scene.hits.chunks(4)) {
            let hit = tree.intersect_one(ray).unwrap();
            let hit = hit.map(bytemuck::cast::<_, [u32; 4]>);
            assert_eq!(
                hit.as_ref().map(|it| &it[..]),
                Some(wanted).filter(|it| it[3] != htree::NONE)
            );
            assert_eq!(tree.occluded_one(ray).unwrap(), hit.is_some());
        }
    }
}

#[test]
fn bounds_and_counts_are_those_of_c() {
    let (scenes, kinds) = scenes_and_kinds();
    for (scene, &kind) in
        scenes.iter().flat_map(|scene| kinds.iter().map(move |kind| (scene, kind)))
    {
        let tree = Tree::build(&scene.mesh(), &Options::new(kind)).unwrap();
        assert_eq!(bytemuck::cast::<Aabb, [u32; 6]>(tree.bounds()), scene.bounds[..]);
        let stats = tree.stats().unwrap();
        assert_eq!(stats.kind, kind);
        let counted = [
            ("triangles", stats.triangles),
            ("objects", stats.objects),
            ("invalid", stats.invalid),
            ("degenerate", stats.degenerate),
        ];
        for (field, value) in counted {
            assert_eq!(scene.stats[field], value, "{field} of {}, {kind}", scene.name);
        }
        let view = tree.view().unwrap();
        assert_eq!((view.kind, view.bounds), (kind, tree.bounds()));
        let triangles = if kind == Kind::WIDE { 0 } else { stats.triangles };
        assert_eq!(view.triangles.len() as u64, triangles);
        assert_eq!(u64::from(view.prims), stats.triangles - stats.invalid - stats.degenerate);
        assert_eq!(view.nodes.is_empty(), view.prims == 0);
    }
}

#[test]
fn versions_and_statuses_are_those_of_c() {
    let file = conformance();
    let (major, minor, patch) = htree::library_version();
    assert_eq!(file["library"], format!("{major}.{minor}.{patch}"));
    let mut known = 0;
    for (name, code) in file["statuses"].as_object().unwrap() {
        if name != "OK" {
            let kind = ErrorKind::from_code(code.as_i64().unwrap() as i32);
            let ours = format!("{kind:?}").to_uppercase();
            assert_eq!(ours, name.replace('_', ""));
            assert_eq!(file["status_names"][code.to_string()], kind.name());
            known += 1;
        }
    }
    assert_eq!(ErrorKind::from_code(known + 1), ErrorKind::Unknown, "a status that C lacks");
}
