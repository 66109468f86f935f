// SPDX-License-Identifier: MIT
//! Ray queries over triangle meshes, by hierarchies that are cheap enough to build anew for every
//! frame: the safe face of [libhtree](htree_sys).
//!
//! ```
//! use htree::{Mesh, Options, Ray, Tree};
//!
//! let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
//! let tree = Tree::build(&Mesh::new(&positions), &Options::default())?;
//! let hit = tree.intersect_one(&Ray::new([0.2, 0.2, 1.0], [0.0, 0.0, -1.0]))?.unwrap();
//! assert_eq!((hit.prim, hit.t), (0, 1.0));
//! # Ok::<(), htree::Error>(())
//! ```
//!
//! Data takes one way: [`Mesh`] -> [`Tree::build`] -> [`Tree::intersect`] -> [`Hit`]s. A mesh borrows
//! your slices for the build; a tree copies what it keeps, changes by [`Tree::update`] only, and is
//! `Send + Sync`. A [`LazyTree`] borrows them until it is complete. The closest hit is the same bits
//! for every [`Kind`], batch and number of threads. Queries take whole batches and spread them over
//! all cores; one ray is a batch of one.
//!
//! A panic in a closure of yours does not cross the C library: the call is cancelled, and the panic
//! goes on in the thread that made it.
#![deny(missing_docs)]
#![deny(unsafe_op_in_unsafe_fn)]
#![warn(missing_debug_implementations)]

mod change;
mod error;
mod file;
mod hooks;
mod mesh;
mod options;
mod query;
mod ray;
mod tree;
mod view;

pub use change::{How, LazyTree};
pub use error::{Error, ErrorKind, Result};
pub use file::LoadOptions;
pub use hooks::{Allocator, Tasks};
pub use htree_sys as sys;
pub use mesh::{Intersect, Mesh, ObjectHit, Objects};
pub use options::{Kind, Options};
pub use query::Query;
pub use ray::{Aabb, Counters, Hit, Ray, COORDINATE_MAX, NONE};
pub use tree::Tree;
pub use view::{Stats, View};

/// Version of this crate.
///
/// ```
/// assert!(htree::VERSION.starts_with("0.1."));
/// ```
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Version of the C library that is linked: major, minor, patch.
///
/// ```
/// let (major, minor, _patch) = htree::library_version();
/// assert_eq!((major, minor), (0, 1));
/// ```
pub fn library_version() -> (u32, u32, u32) {
    // SAFETY: takes nothing, changes nothing.
    let version = unsafe { sys::htree_version() };
    (version / 10_000, version / 100 % 100, version % 100)
}

/// Refuses a library of another ABI, as a system library may be.
fn verify_library() -> Result<()> {
    let (major, minor, patch) = library_version();
    if (major, minor) == (sys::HTREE_VERSION_MAJOR, sys::HTREE_VERSION_MINOR) {
        return Ok(());
    }
    Err(Error::new(
        ErrorKind::Unsupported,
        format!("libhtree {major}.{minor}.{patch} is linked, and htree {VERSION} is for 0.1"),
    ))
}

#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;
