// SPDX-License-Identifier: MIT
//! Every mistake of the conformance file gets its status: by the safe crate where its types allow
//! the mistake, else by the raw functions. Safe Rust has no NULL, no wrong size, no unknown flag.

mod common;

use common::{conformance, rays_down, terrain};
use htree::{sys, ErrorKind, Hit, How, Kind, LazyTree, Mesh, Options, Query, Ray, Tree};
use std::mem::{size_of, zeroed};
use std::ops::ControlFlow;
use std::ptr::{null, null_mut};

const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

fn code<T>(result: htree::Result<T>) -> i32 {
    let error = result.err().expect("a mistake");
    assert!(!error.text().is_empty());
    assert!(error.to_string().starts_with(error.kind().name()));
    error.code()
}

fn build(options: &Options) -> i32 {
    code(Tree::build(&Mesh::new(&CORNERS), options))
}

fn default() -> Options {
    Options::default()
}

fn stop(_done: f64) -> ControlFlow<()> {
    ControlFlow::Break(())
}

fn query_cancelled() -> i32 {
    let (positions, triangles) = terrain(20);
    let tree = Tree::new(&Mesh::new(&positions).indices(&triangles)).unwrap();
    let rays = rays_down(20, 100_000);
    let mut hits = vec![Hit::default(); rays.len()];
    code(tree.intersect_with(&rays, &mut hits, Query::new().progress(stop)))
}

fn build_cancelled() -> i32 {
    let (positions, triangles) = terrain(40);
    let mesh = Mesh::new(&positions).indices(&triangles);
    code(Tree::build_with_progress(&mesh, &default(), stop))
}

/// A raw mesh of one triangle, and raw options.
fn raw() -> (sys::htree_mesh, sys::htree_options) {
    // SAFETY: zeros are a value of both; the corners are static.
    unsafe {
        let mut mesh: sys::htree_mesh = zeroed();
        (mesh.positions, mesh.vertex_count, mesh.triangle_count) = (CORNERS.as_ptr().cast(), 3, 1);
        let mut options: sys::htree_options = zeroed();
        let size = size_of::<sys::htree_options>() as u64;
        assert_eq!(sys::htree_options_init(&mut options, size, sys::HTREE_H), sys::HTREE_OK);
        (mesh, options)
    }
}

fn raw_build(change: impl FnOnce(&mut sys::htree_mesh, &mut sys::htree_options)) -> i32 {
    let (mut mesh, mut options) = raw();
    change(&mut mesh, &mut options);
    let mut out = 1 as *mut sys::htree;
    let status = unsafe { sys::htree_build(&mut out, &mesh, &options) };
    assert!(out.is_null());
    status
}

/// Calls the raw function with a tree and a query of defaults.
fn raw_query(call: impl FnOnce(*const sys::htree, &mut sys::htree_query) -> i32) -> i32 {
    let tree = Tree::new(&Mesh::new(&CORNERS)).unwrap();
    let mut query: sys::htree_query = unsafe { zeroed() };
    let size = size_of::<sys::htree_query>() as u64;
    assert_eq!(unsafe { sys::htree_query_init(&mut query, size) }, sys::HTREE_OK);
    call(tree.as_ptr(), &mut query)
}

fn raw_update(mesh: *const sys::htree_mesh, how: i32) -> i32 {
    let (good, options) = raw();
    let mut tree = null_mut();
    unsafe {
        assert_eq!(sys::htree_build(&mut tree, &good, &options), sys::HTREE_OK);
        let status = sys::htree_update(tree, mesh, how, null_mut());
        sys::htree_free(tree);
        status
    }
}

fn make_mistake(case: &str) -> i32 {
    let ray = Ray::new([0.0; 3], [0.0, 0.0, 1.0]);
    let ray: *const sys::htree_ray = (&ray as *const Ray).cast();
    let mut hit = Hit::default();
    let hit: *mut sys::htree_hit = (&mut hit as *mut Hit).cast();
    match case {
        "build-index-out-of-range" => code(Tree::new(&Mesh::new(&CORNERS).indices(&[[0, 1, 3]]))),
        "build-strict-nan" => {
            code(Tree::build(&Mesh::new(&[[f32::NAN; 3]; 3]), &default().strict(true)))
        }
        "build-kind-unknown" => build(&Options::new(Kind::from_code(99))),
        "build-buckets-1" => build(&default().buckets(1)),
        "build-axes-2" => build(&default().axes(2)),
        "build-cost-nan" => build(&default().cost_skd(f32::NAN)),
        "build-cost-zero" => build(&default().cost_intersect(0.0)),
        "build-cells-huge" => build(&Options::new(Kind::AH).cells_per_prim(1e9)),
        "build-few-prims-0" => build(&Options::new(Kind::AH).few_prims(0)),
        "build-stride-8" => code(Tree::new(&Mesh::new(&CORNERS).position_stride(8))),
        "build-cancelled" => build_cancelled(),
        "query-cancelled" => query_cancelled(),
        "build-flags-unknown" => raw_build(|_, options| options.flags = 0x8000_0000),
        "build-too-few-vertices" => raw_build(|mesh, _| mesh.triangle_count = 2),
        "build-positions-null" => raw_build(|mesh, _| mesh.positions = null()),
        "query-flags-unknown" => raw_query(|tree, query| unsafe {
            query.flags = 1;
            sys::htree_intersect(tree, ray, 1, hit, query)
        }),
        "options-size-0" => unsafe { sys::htree_options_init(&mut raw().1, 0, sys::HTREE_H) },
        "query-size-0" => raw_query(|_, query| unsafe { sys::htree_query_init(query, 0) }),
        "stats-size-0" => raw_query(|tree, _| unsafe {
            sys::htree_get_stats(tree, &mut sys::htree_stats::default())
        }),
        "view-size-0" => raw_query(|tree, _| unsafe { sys::htree_get_view(tree, &mut zeroed()) }),
        "view-lazy" => {
            let (positions, triangles) = terrain(60);
            let mesh = Mesh::new(&positions).indices(&triangles);
            code(LazyTree::build(&mesh, &Options::new(Kind::WIDE)).unwrap().view())
        }
        "update-how-3" => raw_update(&raw().0, 3),
        "update-index-out-of-range" => {
            let mut tree = Tree::new(&Mesh::new(&CORNERS)).unwrap();
            code(tree.update(&Mesh::new(&CORNERS).indices(&[[0, 1, 3]]), How::Rebuild))
        }
        "update-mesh-null" => raw_update(null(), sys::HTREE_REFIT),
        "complete-null" => unsafe { sys::htree_complete(null_mut()) },
        "rays-null" => {
            raw_query(|tree, query| unsafe { sys::htree_intersect(tree, null(), 1, hit, query) })
        }
        "hits-null" => raw_query(|tree, query| unsafe {
            sys::htree_intersect(tree, ray, 1, null_mut(), query)
        }),
        "tree-null" => {
            raw_query(|_, query| unsafe { sys::htree_intersect(null(), ray, 1, hit, query) })
        }
        "out-null" => unsafe { sys::htree_build(null_mut(), &raw().0, null()) },
        "mesh-null" => unsafe { sys::htree_build(&mut null_mut(), null(), null()) },
        _ => panic!("this test knows no case {case}"),
    }
}

#[test]
fn every_mistake_gets_its_status() {
    let file = conformance();
    let cases = file["misuse"].as_array().unwrap();
    assert!(cases.len() >= 25);
    for entry in cases {
        let (case, status) = (entry["case"].as_str().unwrap(), entry["status"].as_str().unwrap());
        assert_eq!(make_mistake(case), file["statuses"][status].as_i64().unwrap() as i32, "{case}");
    }
}

#[test]
fn lengths_that_differ_are_refused() {
    let tree = Tree::new(&Mesh::new(&CORNERS)).unwrap();
    let ray = Ray::new([0.2, 0.2, 1.0], [0.0, 0.0, -1.0]);
    let argument = ErrorKind::Argument.code();
    assert_eq!(code(tree.intersect(&[ray], &mut [])), argument);
    assert_eq!(code(tree.occluded(&[ray], &mut [false; 2])), argument);
    let mut none = [];
    let query = Query::new().counters(&mut none);
    assert_eq!(code(tree.intersect_with(&[ray], &mut [Hit::default()], query)), argument);
    assert_eq!(tree.intersect(&[], &mut []), Ok(()));
}

#[test]
fn meshes_that_are_not_whole_are_refused() {
    assert_eq!(code(Tree::new(&Mesh::from_floats(&[0.0; 10]))), ErrorKind::Argument.code());
    assert_eq!(
        code(Tree::new(&Mesh::new(&CORNERS).flat_indices(&[0, 1]))),
        ErrorKind::Argument.code()
    );
    assert_eq!(code(Tree::new(&Mesh::new(&[[0.0; 3]; 4]))), ErrorKind::Geometry.code());
    assert_eq!(code(Tree::new(&Mesh::new(&[]).indices(&[[0; 3]]))), ErrorKind::Geometry.code());
    for stride in [1, 13, 14, u64::MAX, u64::MAX - 3] {
        let mesh = Mesh::new(&CORNERS).position_stride(stride);
        match Tree::new(&mesh) {
            // One vertex fits any stride, and it is no triangle.
            Err(error) => {
                assert!(matches!(error.kind(), ErrorKind::Argument | ErrorKind::Geometry))
            }
            Ok(_) => panic!("stride {stride}"),
        }
    }
}

#[test]
fn flags_add_up_and_go_away() {
    let nan = [[f32::NAN; 3]; 3];
    let mesh = Mesh::new(&nan);
    let strict = Options::new(Kind::AH).strict(true).any_planes(true).loose_planes(true);
    assert_eq!(code(Tree::build(&mesh, &strict)), ErrorKind::Geometry.code());
    assert!(Tree::build(&mesh, &strict.loose_planes(false).strict(false)).is_ok());
}

#[test]
fn a_stride_reads_no_further_than_the_slice() {
    // The last vertex has no room for a whole stride, and needs none.
    let floats = [0.0, 0.0, 0.0, 9.0, 1.0, 0.0, 0.0, 9.0, 0.0, 1.0, 0.0];
    let mesh = Mesh::from_floats(&floats).position_stride(16);
    let tree = Tree::build(&mesh, &Options::new(Kind::H)).unwrap();
    assert_eq!(tree.bounds().hi, [1.0, 1.0, 0.0]);
    assert_eq!(tree.view().unwrap().triangles, [CORNERS]);
}

#[test]
fn names_of_kinds_go_there_and_back() {
    for code in [1, 2, 3, 4, 5, 6, 7, 8, 101, 102, 103] {
        let kind = Kind::from_code(code);
        assert_eq!(kind.to_string().parse::<Kind>().unwrap(), kind);
    }
    for name in ["", "H", "h ", "bvh", "h\0"] {
        assert_eq!(name.parse::<Kind>().unwrap_err().kind(), ErrorKind::Argument);
    }
    assert_eq!(Kind::from_code(0).to_string(), "kind 0");
}
