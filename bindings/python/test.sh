#!/bin/sh
# test.sh: builds the wheel and an sdist, installs the wheel into a virtual environment, then types, tests
# and examples. Everything that it makes lies in HTREE_BINDINGS_OUT. The last line is
# `python: N passed, N failed`; exit status 77 says that something to run it with is missing.
set -u
here=$(cd "$(dirname "$0")" && pwd)
repository=$(cd "$here/../.." && pwd)
out=${HTREE_BINDINGS_OUT:-$repository/build/bindings/python}
libraries=${HTREE_LIB_DIR:-$repository/build/release}
export HTREE_CONFORMANCE="${HTREE_CONFORMANCE:-$repository/build/release/conformance.json}"
export PYTHONDONTWRITEBYTECODE=1 PIP_DISABLE_PIP_VERSION_CHECK=1 MPLCONFIGDIR="$out/matplotlib"
unset HTREE_LIBRARY
PYTHON=${PYTHON:-python3}

skip() {
    echo "skipped python: $1"
    exit 77
}
command -v "$PYTHON" >/dev/null || skip "no $PYTHON: apt-get install python3 python3-venv"
"$PYTHON" -c 'import sys; sys.exit(sys.version_info < (3, 10))' || skip "it needs Python 3.10 or later"
"$PYTHON" -c 'import ensurepip, venv' 2>/dev/null || skip "no venv: apt-get install python3-venv"
command -v cc >/dev/null || skip "no C compiler: apt-get install gcc"

passed=0 failed=0
# Runs the words after name $1 as one test.
step() {
    name=$1
    shift
    if "$@"; then
        passed=$((passed + 1))
        echo "ok $name"
    else
        failed=$((failed + 1))
        echo "FAILED $name"
    fi
}

finish() {
    echo "python: $passed passed, $failed failed"
    [ "$failed" -eq 0 ]
    exit
}

# ---- Build and install --------------------------------------------------------------------------------

wheel=
build_wheel() {
    rm -rf "$out/wheel"
    pip wheel -q --no-deps --config-settings=build-dir="$out/build" -w "$out/wheel" "$here" || return 1
    wheel=$(ls "$out"/wheel/htree-*.whl)
}

wheel_is_right() {
    case $wheel in *-py3-none-*.whl) ;; *) echo "$wheel is for one Python only" && return 1 ;; esac
    unzipped=$(python -m zipfile -l "$wheel") || return 1
    for file in libhtree. py.typed _abi.py LICENSE trimesh.py; do
        case $unzipped in *"htree/$file"*) ;; *) echo "$wheel lacks $file" && return 1 ;; esac
    done
}

# The sdist must hold all that a wheel is made of.
sdist_is_whole() {
    rm -rf "$out/sdist"
    python -m build -q --sdist -o "$out/sdist" "$here" &&
        pip wheel -q --no-deps -w "$out/sdist" "$out"/sdist/htree-*.tar.gz &&
        diff=$(python - "$wheel" "$out"/sdist/htree-*.whl <<'PYTHON'
import sys, zipfile
print(*set.symmetric_difference(*(set(zipfile.ZipFile(path).namelist()) for path in sys.argv[1:])))
PYTHON
        ) && [ -z "$diff" ] || { echo "the wheel from the sdist differs: ${diff-}" && return 1; }
}

install() {
    pip install -q --force-reinstall --no-deps "$wheel" && pip install -q "${wheel}[test]" build
}

mkdir -p "$out"
version=$("$PYTHON" -c 'import sys; print(*sys.version_info[:2])')
[ "$(cat "$out/venv/version" 2>/dev/null)" = "$version" ] || rm -rf "$out/venv"
"$PYTHON" -m venv "$out/venv" && echo "$version" >"$out/venv/version" || exit 1
PATH=$out/venv/bin:$PATH
cd "$out" || exit 1 # the sources must not be found but through the wheel

step wheel build_wheel
[ -n "$wheel" ] || finish
step wheel-is-right wheel_is_right
step install install
[ "$failed" -eq 0 ] || finish
step sdist-is-whole sdist_is_whole

# ---- Types, tests, examples ---------------------------------------------------------------------------

types() {
    mypy --strict --cache-dir "$out/mypy" -p htree &&
        MYPYPATH=$here/tests mypy --strict --cache-dir "$out/mypy" "$here"/tests/*.py "$here"/examples/*.py \
            "$here/make_abi.py"
}

# Runs pytest with the words after report name $1 and adds its numbers to ours.
tests() {
    report=$out/$1.xml
    shift
    rm -f "$report"
    python -m pytest --rootdir "$here" -c "$here/pyproject.toml" --junit-xml "$report" "$@"
    numbers=$(python - "$report" <<'PYTHON'
import sys, xml.etree.ElementTree as tree
suite = tree.parse(sys.argv[1]).getroot()[0]
bad = int(suite.get("failures")) + int(suite.get("errors"))
print(int(suite.get("tests")) - bad - int(suite.get("skipped")), bad)
PYTHON
    ) || numbers="0 1"
    passed=$((passed + ${numbers% *}))
    failed=$((failed + ${numbers#* }))
}

step types types
tests all "$here/tests"
if [ -f "$libraries/libhtree.so" ]; then # the project's own build of the library, by the same measure
    HTREE_LIBRARY=$libraries/libhtree.so tests library "$here/tests/test_conformance.py"
fi
step quickstart python "$here/examples/quickstart.py"
step ambient-occlusion python "$here/examples/ambient_occlusion.py" "$out/ambient_occlusion.png"
finish
