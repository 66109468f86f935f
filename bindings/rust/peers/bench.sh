#!/bin/sh
# bench.sh BUILD OUT [MESH.ply]...: what `make bench-rust` runs: saves the rays of each mesh by BUILD/htree-bench, and
# writes to OUT/bench-rust.txt how fast the binding and other crates build and trace, or over hills without a mesh.
# SPDX-License-Identifier: MIT
set -eu
build=$(cd "$1" && pwd)
out=$2
shift 2
command -v cargo >/dev/null 2>&1 || { echo "bench-rust needs cargo (https://rustup.rs)"; exit 1; }
target=${CARGO_TARGET_DIR:-$build/../bench-rust}

names=
for mesh; do # each becomes itself and its rays
    shift
    names="$names $(basename "$mesh")"
    rays=$out/$(basename "$mesh" .ply).rays
    "$build/htree-bench" --kind fast --threads 1 --rounds 1 --seconds 0.001 --size 512x512 --frame 64 --ambient 1 \
        --save-rays "$rays" -q "$mesh" >"$out/bench-rust.log"
    set -- "$@" "$mesh" "$rays"
done

# The peers have no code for several instruction sets to choose from: they get what this machine has.
RUSTFLAGS="-C target-cpu=native" HTREE_LIB_DIR=$build CARGO_TARGET_DIR=$target \
    cargo build --locked --release --manifest-path "$(dirname "$0")/Cargo.toml"
"$target/release/htree-peers" "$@" >"$out/bench-rust.log"
{
    echo "# machine: $(sed -n 's/^model name.*: //p' /proc/cpuinfo | sed 1q), $(nproc) cores, $(uname -sm), $(rustc --version)"
    echo "# command: make bench-rust MESH=\"${names# }\""
    sed -n '/^# crates/,$p' "$out/bench-rust.log"
} >"$out/bench-rust.txt"
