// SPDX-License-Identifier: MIT
//! Trees that rays build, compact and collapsed ones, and trees that are brought to another mesh.

mod common;

use common::{rays_down, terrain};
use htree::{
    Aabb, ErrorKind, Hit, How, Kind, LazyTree, Mesh, ObjectHit, Objects, Options, Ray, Tree,
};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::Arc;
use std::thread;

const SIDE: u32 = 60;

fn hits(tree: &Tree) -> Vec<Hit> {
    let rays = rays_down(SIDE, 3_000);
    let mut hits = vec![Hit::default(); rays.len()];
    tree.intersect(&rays, &mut hits).unwrap();
    assert!(hits.iter().any(Hit::is_hit));
    hits
}

fn assert_answers_as(tree: &Tree, mesh: &Mesh<'_>) {
    tree.check().unwrap();
    let other = Tree::build(mesh, &Options::new(Kind::BVH_SAH)).unwrap();
    assert_eq!(hits(tree), hits(&other));
    assert_eq!(tree.bounds(), other.bounds());
}

/// Every vertex a little higher, those of one side most.
fn lift(positions: &mut [[f32; 3]]) {
    positions.iter_mut().for_each(|it| it[2] += 0.02 * it[0]);
}

#[test]
fn rays_build_a_lazy_tree_and_complete_builds_the_rest() {
    let (positions, triangles) = terrain(SIDE);
    let mesh = Mesh::new(&positions).indices(&triangles);
    let options = Options::new(Kind::WIDE);
    let eager = Tree::build(&mesh, &options.clone().morton(true)).unwrap();
    let lazy = LazyTree::build(&mesh, &options).unwrap();
    let before = lazy.stats().unwrap();
    assert!(before.subtrees > 10 && before.subtrees_built == 0);
    assert_eq!(eager.stats().unwrap().subtrees, 0);
    lazy.intersect_one(&Ray::new([1.3, 1.4, 5.0], [0.0, 0.0, -1.0])).unwrap().expect("a hit");
    let built = lazy.stats().unwrap().subtrees_built;
    assert!(0 < built && built < before.subtrees);
    assert_eq!(lazy.view().unwrap_err().kind(), ErrorKind::Unsupported);
    assert!(format!("{lazy:?}").contains("bounds"));
    assert_answers_as(&lazy, &mesh);
    let tree = lazy.complete().unwrap();
    assert_eq!(tree.stats().unwrap().subtrees, 0);
    assert_eq!(tree.view().unwrap(), eager.view().unwrap());
    assert_answers_as(&tree, &mesh);
}

#[test]
fn compact_trees_answer_alike_in_less_than_half_of_the_memory() {
    let (mut positions, triangles) = terrain(SIDE);
    let options = Options::new(Kind::WIDE);
    let mesh = Mesh::new(&positions).indices(&triangles);
    let whole = Tree::build(&mesh, &options).unwrap();
    let options = options.compact(true);
    let mut tree = Tree::build(&mesh, &options).unwrap();
    assert!(2 * tree.stats().unwrap().bytes < whole.stats().unwrap().bytes);
    assert_eq!(tree.view().unwrap_err().kind(), ErrorKind::Unsupported);
    assert_answers_as(&tree, &mesh);
    assert_answers_as(&Tree::load(&tree.save().unwrap()).unwrap(), &mesh);
    assert_eq!(LazyTree::build(&mesh, &options).unwrap_err().kind(), ErrorKind::Argument);
    lift(&mut positions);
    let mesh = Mesh::new(&positions).indices(&triangles);
    assert_eq!(tree.update(&mesh, How::Refit).unwrap(), 1.0);
    assert_answers_as(&tree, &mesh);
}

#[test]
fn collapsed_trees_are_wide() {
    let (positions, triangles) = terrain(SIDE);
    let mesh = Mesh::new(&positions).indices(&triangles);
    for kind in [Kind::BVH_MEDIAN, Kind::AH, Kind::BEST] {
        let options = Options::new(kind);
        let tree = Tree::build(&mesh, &options.clone().collapse(true)).unwrap();
        assert_eq!(tree.stats().unwrap().kind, Kind::WIDE);
        assert_answers_as(&tree, &mesh);
        let plain = Tree::build(&mesh, &options.clone().collapse(false)).unwrap();
        assert_eq!(plain.stats().unwrap().kind, options.kind());
    }
    let best = Tree::build(&mesh, &Options::new(Kind::BEST)).unwrap();
    assert_eq!(best.stats().unwrap().kind, Kind::WIDE);
}

#[test]
fn threads_meet_in_a_lazy_tree() {
    let (positions, triangles) = terrain(SIDE);
    let mesh = Mesh::new(&positions).indices(&triangles);
    let wanted = hits(&Tree::new(&mesh).unwrap());
    for _ in 0..10 {
        let lazy = LazyTree::build(&mesh, &Options::default()).unwrap();
        thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| assert_eq!(hits(&lazy), wanted));
            }
        });
    }
}

#[test]
fn a_tree_that_was_lazy_keeps_no_slice_of_an_update() {
    let (mut positions, triangles) = terrain(SIDE);
    let mesh = Mesh::new(&positions).indices(&triangles);
    let mut tree = LazyTree::build(&mesh, &Options::default()).unwrap().complete().unwrap();
    for how in [How::Refit, How::Rebuild] {
        lift(&mut positions);
        let gone = positions.clone();
        tree.update(&Mesh::new(&gone).indices(&triangles), how).unwrap();
        drop(gone);
        assert_eq!(tree.stats().unwrap().subtrees, 0, "{how:?}");
        assert_answers_as(&tree, &Mesh::new(&positions).indices(&triangles));
    }
}

#[test]
fn a_lazy_tree_stays_lazy_over_updates() {
    let (first, triangles) = terrain(SIDE);
    let mut second = first.clone();
    lift(&mut second);
    let meshes = [&first, &second].map(|it| Mesh::new(it).indices(&triangles));
    let mut lazy = LazyTree::build(&meshes[0], &Options::default()).unwrap();
    for (i, how) in [How::Rebuild, How::Refit, How::Refit].into_iter().enumerate() {
        assert_eq!(lazy.update(&meshes[(i + 1) % 2], how).unwrap(), 1.0);
        assert!(lazy.stats().unwrap().subtrees > 10);
        assert_answers_as(&lazy, &meshes[(i + 1) % 2]);
    }
}

#[test]
fn every_kind_answers_as_a_new_tree_after_updates() {
    for code in 1..=8 {
        let (mut positions, triangles) = terrain(SIDE);
        let options = Options::new(Kind::from_code(code));
        let mut tree = Tree::build(&Mesh::new(&[]), &options).unwrap();
        for how in [How::Rebuild, How::Refit, How::Refit, How::Rebuild] {
            lift(&mut positions);
            let mesh = Mesh::new(&positions).indices(&triangles);
            let quality = tree.update(&mesh, how).unwrap();
            assert!((0.2..20.0).contains(&quality));
            assert!(how == How::Refit || quality == 1.0);
            assert_eq!(tree.stats().unwrap().triangles, triangles.len() as u64);
            assert_answers_as(&tree, &mesh);
        }
    }
}

#[test]
fn refitting_keeps_the_nodes() {
    let (mut positions, triangles) = terrain(SIDE);
    let mut tree = Tree::new(&Mesh::new(&positions).indices(&triangles)).unwrap();
    let before = tree.view().unwrap().nodes.as_ptr();
    lift(&mut positions);
    let quality = tree.update(&Mesh::new(&positions).indices(&triangles), How::Refit).unwrap();
    assert!(quality != 1.0);
    assert_eq!(tree.view().unwrap().nodes.as_ptr(), before);
}

#[test]
fn a_mesh_that_is_refused_leaves_the_tree_as_it_was() {
    let (positions, triangles) = terrain(SIDE);
    let mesh = Mesh::new(&positions).indices(&triangles);
    let mut tree = Tree::new(&mesh).unwrap();
    let bad = [
        (Mesh::new(&positions[..9]).indices(&triangles), ErrorKind::Geometry),
        (mesh.clone().position_stride(8), ErrorKind::Argument),
        (Mesh::from_floats(&[0.0; 10]), ErrorKind::Argument),
    ];
    for (mesh, kind) in &bad {
        for how in [How::Refit, How::Rebuild] {
            assert_eq!(tree.update(mesh, how).unwrap_err().kind(), *kind);
        }
    }
    assert_answers_as(&tree, &mesh);
}

/// Objects that are hit at this t, and count themselves while they live.
fn objects(boxes: &[Aabb], t: f32, alive: Arc<()>) -> Objects<'_> {
    Objects::new(boxes, move |_object: u32, _ray: &Ray| {
        let _ = &alive;
        Some(ObjectHit { t, u: 0.0, v: 0.0 })
    })
}

#[test]
fn objects_are_those_of_the_last_update() {
    let boxes = [Aabb { lo: [-1.0; 3], hi: [1.0; 3] }];
    let ray = Ray::new([0.0, 0.0, 3.0], [0.0, 0.0, -1.0]);
    let old = Arc::new(());
    let first = objects(&boxes, 2.0, Arc::clone(&old));
    let mut tree = Tree::new(&Mesh::new(&[]).objects(first)).unwrap();
    assert_eq!(Arc::strong_count(&old), 2);
    for (t, how) in [(2.25, How::Refit), (2.5, How::Rebuild)] {
        let mesh = Mesh::new(&[]).objects(objects(&boxes, t, Arc::new(())));
        tree.update(&mesh, how).unwrap();
        assert_eq!(Arc::strong_count(&old), 1);
        assert_eq!(tree.intersect_one(&ray).unwrap().map(|hit| hit.t), Some(t));
    }
    let panics = |_object: u32, _ray: &Ray| -> Option<ObjectHit> { panic!("of an object") };
    tree.update(&Mesh::new(&[]).objects(Objects::new(&boxes, panics)), How::Refit).unwrap();
    let call = std::panic::AssertUnwindSafe(|| tree.intersect_one(&ray));
    let caught = std::panic::catch_unwind(call);
    assert_eq!(caught.unwrap_err().downcast_ref(), Some(&"of an object"));
}

/// Panics when it is told to.
struct Moody(Arc<AtomicBool>, Arc<AtomicUsize>);

impl htree::Tasks for Moody {
    fn run(&self, count: u32, task: &(dyn Fn(u32) + Sync)) {
        self.1.fetch_add(1, Ordering::Relaxed);
        assert!(!self.0.load(Ordering::Relaxed), "of a hook");
        (0..count).for_each(task);
    }
}

#[test]
fn panics_of_hooks_come_out_of_updates() {
    let (mut positions, triangles) = terrain(SIDE);
    let (mood, runs) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicUsize::new(0)));
    let options = Options::default().tasks(Moody(Arc::clone(&mood), Arc::clone(&runs)));
    let mut tree = Tree::build(&Mesh::new(&positions).indices(&triangles), &options).unwrap();
    lift(&mut positions);
    let mesh = Mesh::new(&positions).indices(&triangles);
    for how in [How::Refit, How::Rebuild] {
        let before = runs.load(Ordering::Relaxed);
        mood.store(true, Ordering::Relaxed);
        let call = std::panic::AssertUnwindSafe(|| tree.update(&mesh, how));
        assert!(std::panic::catch_unwind(call).is_err(), "{how:?}");
        mood.store(false, Ordering::Relaxed);
        assert!(runs.load(Ordering::Relaxed) > before);
        assert_answers_as(&tree, &mesh);
    }
}
