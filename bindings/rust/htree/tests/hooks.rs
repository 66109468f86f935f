// SPDX-License-Identifier: MIT
//! Objects, progress, tasks and memory of the caller's, and their panics.
#![deny(unsafe_op_in_unsafe_fn)]

mod common;

use common::{rays_down, terrain};
use htree::{Aabb, Allocator, ErrorKind, Hit, Kind, Mesh, ObjectHit, Objects, Options};
use htree::{Counters, Query, Ray, Tasks, Tree};
use std::ops::ControlFlow;
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::Arc;
use std::thread;

fn text_of_panic<R>(call: impl FnOnce() -> R) -> String {
    let panic = catch_unwind(AssertUnwindSafe(call)).err().expect("a panic");
    let text = panic.downcast_ref::<&str>().map(|text| text.to_string());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).expect("a text")
}

/// Horizontal unit squares, one above the other.
fn shelves(count: u32) -> Vec<Aabb> {
    (0..count).map(|z| Aabb { lo: [0.0, 0.0, z as f32], hi: [1.0, 1.0, z as f32] }).collect()
}

fn hit_shelf(object: u32, ray: &Ray) -> Option<ObjectHit> {
    let t = (object as f32 - ray.org[2]) / ray.dir[2];
    let [x, y, _] = ray.at(t);
    let inside = (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y);
    (inside && ray.tmin <= t && t <= ray.tmax).then_some(ObjectHit { t, u: x, v: y })
}

const DOWN: Ray = Ray::new([0.5, 0.25, 99.0], [0.0, 0.0, -1.0]);

#[test]
fn objects_are_hit_beside_triangles() {
    let floor = [[-9.0, -9.0, -1.0], [9.0, -9.0, -1.0], [0.0, 9.0, -1.0]];
    let boxes = shelves(30);
    let mesh = Mesh::new(&floor).objects(Objects::new(&boxes, hit_shelf));
    let tree = Tree::new(&mesh).unwrap();
    let hit = tree.intersect_one(&DOWN).unwrap().unwrap();
    assert_eq!(hit, Hit { t: 70.0, u: 0.5, v: 0.25, prim: 1 + 29 });
    let beside = Ray::new([2.0, 0.0, 99.0], [0.0, 0.0, -1.0]);
    assert_eq!(tree.intersect_one(&beside).unwrap().unwrap().prim, 0);
    assert_eq!(tree.stats().unwrap().objects, 30);
    let view = tree.view().unwrap();
    assert_eq!((view.object_count, view.prims), (30, 31));
}

#[test]
fn what_objects_own_lives_as_long_as_the_tree() {
    let alive = Arc::new(());
    let held = Arc::clone(&alive);
    let intersect = move |object: u32, ray: &Ray| {
        let _ = &held;
        hit_shelf(object, ray)
    };
    let boxes = shelves(3);
    let mesh = Mesh::new(&[]).objects(Objects::new(&boxes, intersect));
    let (first, second) = (Tree::new(&mesh).unwrap(), Tree::new(&mesh).unwrap());
    drop(mesh);
    drop(boxes);
    drop(first);
    assert_eq!(Arc::strong_count(&alive), 2);
    assert!(second.occluded_one(&DOWN).unwrap());
    drop(second);
    assert_eq!(Arc::strong_count(&alive), 1);
}

#[test]
fn a_panic_in_an_object_goes_on_in_the_query_on_any_thread() {
    let boxes = shelves(1);
    let armed = Arc::new(AtomicBool::new(true));
    let called = Arc::new(AtomicUsize::new(0));
    let (trigger, calls) = (Arc::clone(&armed), Arc::clone(&called));
    let objects = Objects::new(&boxes, move |object: u32, ray: &Ray| {
        calls.fetch_add(1, Ordering::Relaxed);
        assert!(!trigger.load(Ordering::Relaxed), "object {object} gives up");
        hit_shelf(object, ray)
    });
    let tree = Tree::new(&Mesh::new(&[]).objects(objects)).unwrap();
    let rays = vec![DOWN; 20_000];
    let mut hits = vec![Hit::default(); rays.len()];
    for threads in [1, 4] {
        let query = Query::new().threads(threads);
        called.store(0, Ordering::Relaxed);
        let text = text_of_panic(|| tree.intersect_with(&rays, &mut hits, query));
        assert_eq!(text, "object 0 gives up");
        assert!(called.load(Ordering::Relaxed) <= threads as usize, "silent after the first");
    }
    assert_eq!(text_of_panic(|| tree.intersect_one(&DOWN)), "object 0 gives up");
    armed.store(false, Ordering::Relaxed);
    tree.intersect(&rays, &mut hits).unwrap();
    assert!(hits.iter().all(|hit| hit.t == 99.0));
}

#[test]
fn no_query_beside_a_panic_returns_wrong_hits() {
    let boxes = shelves(1);
    let objects = Objects::new(&boxes, |object: u32, ray: &Ray| {
        assert!(ray.tmax > 0.0, "a ray that ends at once");
        hit_shelf(object, ray)
    });
    let tree = Tree::new(&Mesh::new(&[]).objects(objects)).unwrap();
    let panics = AtomicUsize::new(0);
    thread::scope(|scope| {
        for i in 0..4 {
            let (tree, panics) = (&tree, &panics);
            scope.spawn(move || {
                for round in 0..200 {
                    let bad = DOWN.between(-100.0, -50.0);
                    let mut rays = vec![DOWN; 100];
                    if i == 0 && round % 10 == 0 {
                        rays[50] = Ray { org: [0.5, 0.25, -99.0], ..bad };
                    }
                    let mut hits = vec![Hit::default(); 100];
                    let query = catch_unwind(AssertUnwindSafe(|| tree.intersect(&rays, &mut hits)));
                    match query {
                        Ok(result) => {
                            result.unwrap();
                            assert!(hits.iter().all(|hit| hit.t == 99.0), "misses that are none");
                        }
                        Err(_) => {
                            panics.fetch_add(1, Ordering::Relaxed);
                        }
                    }
                }
            });
        }
    });
    assert!(panics.load(Ordering::Relaxed) >= 20);
    assert_eq!(tree.intersect_one(&DOWN).unwrap().unwrap().t, 99.0);
}

#[test]
fn progress_grows_and_cancels() {
    let (positions, triangles) = terrain(60);
    let mesh = Mesh::new(&positions).indices(&triangles);
    let mut seen = Vec::new();
    let tree = Tree::build_with_progress(&mesh, &Options::default(), |done| {
        seen.push(done);
        ControlFlow::Continue(())
    })
    .unwrap();
    assert!(seen.len() > 3 && seen.windows(2).all(|pair| pair[0] <= pair[1]));
    assert!(seen.iter().all(|done| (0.0..=1.0).contains(done)));

    let rays = rays_down(60, 50_000);
    let (mut hits, mut calls) = (vec![Hit::default(); rays.len()], 0);
    let query = Query::new().threads(1).progress(|_| {
        calls += 1;
        if calls == 2 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    let error = tree.intersect_with(&rays, &mut hits, query).unwrap_err();
    assert_eq!((error.kind(), calls), (ErrorKind::Cancelled, 2));
}

#[test]
fn a_panic_in_progress_cancels_and_goes_on() {
    let (positions, triangles) = terrain(60);
    let mesh = Mesh::new(&positions).indices(&triangles);
    let build = || Tree::build_with_progress(&mesh, &Options::default(), |_| panic!("no patience"));
    assert_eq!(text_of_panic(build), "no patience");
    let tree = Tree::new(&mesh).unwrap();
    let rays = rays_down(60, 50_000);
    let mut hits = vec![Hit::default(); rays.len()];
    let query = Query::new().progress(|_| panic!("no time"));
    assert_eq!(text_of_panic(|| tree.intersect_with(&rays, &mut hits, query)), "no time");
    tree.intersect(&rays, &mut hits).unwrap();
}

/// How a loop of the caller's can go wrong.
enum Loop {
    Threads,
    Nothing,
    TwiceAndBeyond,
    Panic,
}

impl Tasks for Loop {
    fn run(&self, count: u32, task: &(dyn Fn(u32) + Sync)) {
        match self {
            Loop::Threads => thread::scope(|scope| {
                for first in 0..3 {
                    scope.spawn(move || (first..count).step_by(3).for_each(task));
                }
            }),
            Loop::Nothing => {}
            Loop::TwiceAndBeyond => (0..count + 9).chain(0..count).for_each(task),
            Loop::Panic => {
                task(0);
                panic!("the pool is closed");
            }
        }
    }
}

#[test]
fn tasks_run_once_each_whatever_the_loop_does() {
    let (positions, triangles) = terrain(30);
    let mesh = Mesh::new(&positions).indices(&triangles);
    let rays = rays_down(30, 10_000);
    let mut wanted = vec![Hit::default(); rays.len()];
    Tree::new(&mesh).unwrap().intersect(&rays, &mut wanted).unwrap();
    for tasks in [Loop::Threads, Loop::Nothing, Loop::TwiceAndBeyond] {
        let tree = Tree::build(&mesh, &Options::default().tasks(tasks)).unwrap();
        let mut hits = vec![Hit::default(); rays.len()];
        tree.intersect(&rays, &mut hits).unwrap();
        assert_eq!(hits, wanted);
    }
    let tree = Tree::build(&mesh, &Options::default().tasks(Loop::Panic).threads(1)).unwrap();
    let mut hits = vec![Hit::default(); rays.len()];
    let query = Query::new().threads(2);
    let text = text_of_panic(|| tree.intersect_with(&rays, &mut hits, query));
    assert_eq!(text, "the pool is closed");
}

#[test]
fn no_task_runs_twice() {
    let boxes = shelves(1);
    let calls = Arc::new(AtomicUsize::new(0));
    let counted = Arc::clone(&calls);
    let objects = Objects::new(&boxes, move |object: u32, ray: &Ray| {
        counted.fetch_add(1, Ordering::Relaxed);
        hit_shelf(object, ray)
    });
    let options = Options::default().tasks(Loop::TwiceAndBeyond).threads(2);
    let tree = Tree::build(&Mesh::new(&[]).objects(objects), &options).unwrap();
    let rays = vec![DOWN; 5_000];
    tree.intersect(&rays, &mut vec![Hit::default(); rays.len()]).unwrap();
    assert_eq!(calls.load(Ordering::Relaxed), rays.len());
}

/// Counts how often it runs.
struct Counted(Arc<AtomicUsize>);

impl Tasks for Counted {
    fn run(&self, _count: u32, _task: &(dyn Fn(u32) + Sync)) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

#[test]
fn threads_say_whether_the_loop_runs() {
    let (positions, triangles) = terrain(10);
    let mesh = Mesh::new(&positions).indices(&triangles);
    let rays = rays_down(10, 2_000);
    let runs = Arc::new(AtomicUsize::new(0));
    for (build, query, wanted) in [(1, None, 0), (2, None, 1), (1, Some(2), 1), (2, Some(1), 0)] {
        let options = Options::default().threads(build).tasks(Counted(Arc::clone(&runs)));
        let tree = Tree::build(&mesh, &options).unwrap();
        runs.store(0, Ordering::Relaxed);
        let query = query.map_or_else(Query::new, |threads| Query::new().threads(threads));
        tree.intersect_with(&rays, &mut vec![Hit::default(); rays.len()], query).unwrap();
        assert_eq!(runs.load(Ordering::Relaxed), wanted, "{build} threads");
    }
}

/// Counts bytes that are out, and may refuse or panic at one allocation.
struct Ledger {
    out: Arc<AtomicUsize>,
    left: Arc<AtomicUsize>,
    panics: bool,
}

fn layout(bytes: usize) -> std::alloc::Layout {
    std::alloc::Layout::from_size_align(bytes.max(1), 4096).unwrap()
}

unsafe impl Allocator for Ledger {
    fn allocate(&self, bytes: usize, alignment: usize) -> *mut u8 {
        assert!(alignment <= 4096 && alignment.is_power_of_two());
        if self.left.fetch_sub(1, Ordering::Relaxed) == 0 {
            assert!(!self.panics, "the purse is empty");
            return std::ptr::null_mut();
        }
        self.out.fetch_add(bytes, Ordering::Relaxed);
        unsafe { std::alloc::alloc(layout(bytes)) }
    }

    unsafe fn release(&self, memory: *mut u8, bytes: usize) {
        self.out.fetch_sub(bytes, Ordering::Relaxed);
        unsafe { std::alloc::dealloc(memory, layout(bytes)) }
        assert!(!self.panics, "swallowed");
    }
}

#[test]
fn every_byte_comes_back_also_where_allocations_fail() {
    let (positions, triangles) = terrain(10);
    let mesh = Mesh::new(&positions).indices(&triangles);
    let out = Arc::new(AtomicUsize::new(0));
    let build = |left: usize, panics| {
        let ledger = Ledger { out: Arc::clone(&out), left: Arc::new(left.into()), panics };
        Tree::build(&mesh, &Options::new(Kind::AH).threads(1).allocator(ledger))
    };
    let tree = build(usize::MAX, false).unwrap();
    assert_eq!(out.load(Ordering::Relaxed) as u64, tree.stats().unwrap().bytes);
    drop(tree);
    let mut failures = 0;
    while let Err(error) = build(failures, false) {
        assert_eq!(error.kind(), ErrorKind::Memory);
        assert_eq!(out.load(Ordering::Relaxed), 0);
        assert_eq!(text_of_panic(|| build(failures, true)), "the purse is empty");
        assert_eq!(out.load(Ordering::Relaxed), 0);
        failures += 1;
    }
    assert!(failures > 3);
    assert_eq!(out.load(Ordering::Relaxed), 0);
}

#[test]
fn a_check_without_memory_says_so() {
    let (positions, triangles) = terrain(10);
    let mesh = Mesh::new(&positions).indices(&triangles);
    for panics in [false, true] {
        let (out, left) = (Arc::default(), Arc::new(AtomicUsize::new(usize::MAX)));
        let ledger = Ledger { out, left: Arc::clone(&left), panics };
        let tree = Tree::build(&mesh, &Options::default().allocator(ledger)).unwrap();
        left.store(0, Ordering::Relaxed);
        if panics {
            assert_eq!(text_of_panic(|| tree.check()), "the purse is empty");
        } else {
            assert_eq!(tree.check().unwrap_err().kind(), ErrorKind::Memory);
        }
        tree.check().unwrap();
    }
}

#[test]
fn counters_count_and_change_nothing() {
    let (positions, triangles) = terrain(30);
    let tree = Tree::new(&Mesh::new(&positions).indices(&triangles)).unwrap();
    let rays = rays_down(30, 2_000);
    let mut counters = vec![Counters::default(); rays.len()];
    let (mut hits, mut wanted) =
        (vec![Hit::default(); rays.len()], vec![Hit::default(); rays.len()]);
    tree.intersect(&rays, &mut wanted).unwrap();
    tree.intersect_with(&rays, &mut hits, Query::new().counters(&mut counters)).unwrap();
    assert_eq!(hits, wanted);
    for (hit, cost) in hits.iter().zip(&counters) {
        assert!(!hit.is_hit() || (cost.intersections > 0 && cost.leaf_steps > 0));
        assert!(cost.leaf_steps <= cost.traversal_steps);
    }
}

#[test]
fn measured_costs_change_no_hit() {
    let (positions, triangles) = terrain(20);
    let mesh = Mesh::new(&positions).indices(&triangles);
    let options = Options::default().calibrate().unwrap();
    assert!(options.costs().iter().all(|cost| *cost > 0.0));
    let rays = rays_down(20, 2_000);
    let hits = |tree: Tree| {
        let mut hits = vec![Hit::default(); rays.len()];
        tree.intersect(&rays, &mut hits).map(|()| hits).unwrap()
    };
    assert_eq!(hits(Tree::build(&mesh, &options).unwrap()), hits(Tree::new(&mesh).unwrap()));
    assert!(Options::new(Kind::from_code(99)).calibrate().is_err());
}
