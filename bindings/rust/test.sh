#!/bin/sh
# test.sh: formats, lints, documents and tests the crates, from any folder. See README.md.
# HTREE_LIB_DIR       the folder of libhtree.a and libhtree.so (build/release of this checkout)
# HTREE_CONFORMANCE   the conformance file (build/release/conformance.json)
# HTREE_BINDINGS_OUT  where everything is built (build/bindings/rust)
# SPDX-License-Identifier: MIT
set -u
cd "$(dirname "$0")" || exit 1
repo=$(cd ../.. && pwd)
HTREE_LIB_DIR=$(cd "${HTREE_LIB_DIR:-$repo/build/release}" && pwd) || exit 1
HTREE_CONFORMANCE=${HTREE_CONFORMANCE:-$repo/build/release/conformance.json}
out=${HTREE_BINDINGS_OUT:-$repo/build/bindings/rust}
mkdir -p "$out" || exit 1
out=$(cd "$out" && pwd)
CARGO_TARGET_DIR=$out/target
# Only the steps that link libhtree.so look there.
library_path=$HTREE_LIB_DIR${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
export HTREE_LIB_DIR HTREE_CONFORMANCE CARGO_TARGET_DIR

have() {
    command -v "$1" >/dev/null 2>&1
}

have cargo || { echo "skipped rust: cargo is missing (apt-get install cargo)"; exit 77; }
[ -f "$HTREE_LIB_DIR/libhtree.a" ] || { echo "no libhtree.a in $HTREE_LIB_DIR: make lib"; exit 1; }

passed=0
failed=0

# Runs the words after $1, and counts the tests that cargo reports, or else the command itself as one.
step() {
    name=$1
    shift
    echo "== $name"
    if "$@" >"$out/log" 2>&1; then
        status=0
    else
        status=$?
    fi
    ok=$(sed -n 's/^test result:.* \([0-9]*\) passed; .*/\1/p' "$out/log" | paste -s -d + - )
    bad=$(sed -n 's/^test result:.* \([0-9]*\) failed; .*/\1/p' "$out/log" | paste -s -d + - )
    ok=$((${ok:-0}))
    bad=$((${bad:-0}))
    if [ $status -eq 0 ]; then
        [ $((ok + bad)) -gt 0 ] || ok=1
    else
        [ $bad -gt 0 ] || bad=1
        cat "$out/log"
        echo "FAILED $name"
    fi
    passed=$((passed + ok))
    failed=$((failed + bad))
}

# Layout and hits with the library that the feature $1 gives.
elsewhere() {
    env -u HTREE_LIB_DIR cargo test --locked -p htree-sys -p htree --test abi --test conformance \
        --no-default-features --features "htree/$1"
}

# A prefix with htree.pc, as an installed library has it.
with_pkg_config() {
    version=$(sed -n 's/^#define HTREE_VERSION_[MP][A-Z]* *//p' "$repo/include/htree.h" | paste -s -d . -)
    mkdir -p "$out/pkgconfig" &&
        printf 'Name: htree\nDescription: ray queries\nVersion: %s\nLibs: -L%s -lhtree -lm -lpthread\n' \
            "$version" "$HTREE_LIB_DIR" >"$out/pkgconfig/htree.pc" &&
        (
            export PKG_CONFIG_PATH="$out/pkgconfig" LD_LIBRARY_PATH="$library_path"
            elsewhere pkg-config
        )
}

render() {
    cargo run --locked --release -p htree --example render "$out/torus.ppm" &&
        [ "$(wc -c <"$out/torus.ppm")" -eq 192015 ]
}

if cargo fmt --version >/dev/null 2>&1; then
    step format cargo fmt --all --check
else
    echo "note: not checked: format (apt-get install rustfmt)"
fi
if cargo clippy --version >/dev/null 2>&1; then
    step clippy cargo clippy --locked --workspace --all-targets -- -D warnings
else
    echo "note: not checked: lints (apt-get install rust-clippy)"
fi
step documentation env RUSTDOCFLAGS="-D warnings" cargo doc --locked --workspace --no-deps
step tests cargo test --locked --workspace --no-fail-fast
step "tests, optimised" cargo test --locked --release --workspace --tests --no-fail-fast
step "libhtree.so" env HTREE_LINK=dylib LD_LIBRARY_PATH="$library_path" \
    cargo test --locked -p htree-sys -p htree --test abi --test conformance
step bundled elsewhere bundled
if have pkg-config; then
    step pkg-config with_pkg_config
else
    echo "note: not checked: the feature pkg-config (apt-get install pkg-config)"
fi
step "example render" render
step "example query" cargo run --locked -p htree --example query
echo "rust: $passed passed, $failed failed"
[ $failed -eq 0 ]
