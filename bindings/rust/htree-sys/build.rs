// SPDX-License-Identifier: MIT
//! Where the C library comes from: HTREE_LIB_DIR, else the feature `pkg-config`, else `bundled`.

use std::env;
use std::path::{Path, PathBuf};

fn main() {
    for name in ["HTREE_LIB_DIR", "HTREE_LINK", "HTREE_SOURCE_DIR"] {
        println!("cargo:rerun-if-env-changed={name}");
    }
    if let Some(folder) = env::var_os("HTREE_LIB_DIR") {
        link_folder(Path::new(&folder));
    } else if !link_system() && !compile_sources() {
        panic!(
            "no libhtree: set HTREE_LIB_DIR, or enable the feature `bundled`, or enable \
             `pkg-config` where htree.pc is installed"
        );
    }
}

/// A folder with libhtree.a or libhtree.so; HTREE_LINK says which where both are there.
fn link_folder(folder: &Path) {
    let library = folder.join("libhtree.a");
    let link = env::var("HTREE_LINK").unwrap_or_else(|_| {
        let kind = if library.is_file() { "static" } else { "dylib" };
        kind.to_string()
    });
    assert!(link == "static" || link == "dylib", "HTREE_LINK is {link:?}: use static or dylib");
    println!("cargo:rerun-if-changed={}", library.display());
    println!("cargo:rustc-link-search=native={}", folder.display());
    println!("cargo:rustc-link-lib={link}=htree");
    link_libc();
}

/// What libhtree.a needs; libhtree.so names it by itself.
fn link_libc() {
    if env::var("CARGO_CFG_TARGET_FAMILY").as_deref() == Ok("unix") {
        println!("cargo:rustc-link-lib=m");
        println!("cargo:rustc-link-lib=pthread");
    }
}

#[cfg(feature = "pkg-config")]
fn link_system() -> bool {
    match pkg_config::Config::new().range_version("0.1".."0.2").probe("htree") {
        Ok(_) => true,
        Err(why) if cfg!(feature = "bundled") => {
            println!("cargo:warning=pkg-config finds no htree, so it is compiled: {why}");
            false
        }
        Err(why) => panic!("{why}"),
    }
}

#[cfg(not(feature = "pkg-config"))]
fn link_system() -> bool {
    false
}

/// The checkout that holds include/ and lib/: HTREE_SOURCE_DIR, or the one around this crate.
#[cfg(feature = "bundled")]
fn source_folder() -> PathBuf {
    let root = env::var_os("HTREE_SOURCE_DIR").map_or_else(
        || Path::new(&env::var_os("CARGO_MANIFEST_DIR").unwrap()).join("../../.."),
        PathBuf::from,
    );
    assert!(
        root.join("include/htree.h").is_file(),
        "no include/htree.h in {}: set HTREE_SOURCE_DIR to a checkout of libhtree",
        root.display()
    );
    root
}

#[cfg(feature = "bundled")]
fn compile_sources() -> bool {
    let root = source_folder();
    let mut build = cc::Build::new();
    build
        .include(root.join("include"))
        .include(root.join("lib"))
        .define("HTREE_BUILDING", None)
        .define("NDEBUG", None)
        .define("_POSIX_C_SOURCE", "200809L")
        // The flags of the library's own Makefile: without contraction every build gives the same
        // bits. It is always optimised, since a debug build of a program wants its rays too.
        .flag("-std=c99")
        .flag("-ffp-contract=off")
        .flag("-fvisibility=hidden")
        .opt_level(3)
        .pic(true);
    for layer in ["base", "tree", "build", "trace"] {
        add_sources(&mut build, &root.join("lib").join(layer));
    }
    println!("cargo:rerun-if-changed={}", root.join("include/htree.h").display());
    build.compile("htree");
    link_libc();
    true
}

/// The C files of a layer, and those of its folders, which are for one processor each and empty for
/// others.
#[cfg(feature = "bundled")]
fn add_sources(build: &mut cc::Build, folder: &Path) {
    println!("cargo:rerun-if-changed={}", folder.display());
    let mut entries: Vec<_> =
        folder.read_dir().unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for entry in entries {
        if entry.is_dir() {
            add_sources(build, &entry);
        } else if entry.extension().map_or(false, |end| end == "c") {
            build.file(entry);
        }
    }
}

#[cfg(not(feature = "bundled"))]
fn compile_sources() -> bool {
    false
}
