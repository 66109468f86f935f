#!/bin/sh
# kernels.sh: every kernel of cl/ compiles without a warning: with clang's OpenCL front end, for the SPIR of
# GPUs, for x86-64 and for one with AVX-512, as OpenCL 1.2 and 3.0, with double and, on devices that know no such type, without.
# Prints `ok NAME` or `FAILED NAME: why` for each. CLANG names the compiler.
set -u
cd "$(dirname "$0")/.." || exit 1
clang=${CLANG:-clang}

if ! command -v "$clang" >/dev/null; then
    [ "${HTREE_REQUIRE_ALL-}" = 1 ] && { echo "FAILED kernels: no $clang"; exit 1; }
    echo "skipped kernels: no $clang (apt-get install clang)"
    exit 0
fi
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
bad=0

# All walks have the same parameters, and not all need all; vectors are never passed between compilers.
warnings="-Wall -Wextra -Wshadow -Wdouble-promotion -Werror -Wno-unused-parameter -Wno-psabi"

compile() { # compile FILE TARGET[+CPU] STANDARD FP64 STACK
    cpu=
    [ "${2%+*}" = "$2" ] || cpu=-march=${2#*+}
    double=-DHT_FP64
    # Without the extension the word double is an error.
    [ "$4" = 1 ] || double='-Xclang -cl-ext=-cl_khr_fp64,-__opencl_c_fp64'
    # shellcheck disable=SC2086
    "$clang" -x cl "-cl-std=$3" -target "${2%+*}" $cpu -Xclang -finclude-default-header $double -DHT_STACK="$5" \
        $warnings -emit-llvm -c -o "$work/out.bc" "$work/in.cl"
}

for path in cl/*.cl; do
    [ "$path" = cl/common.cl ] && continue
    file=$(basename "$path" .cl)
    cat lib/tree/layout.h cl/common.cl "$path" >"$work/in.cl"
    why=$(for target in spir64-unknown-unknown x86_64-unknown-linux-gnu \
        x86_64-unknown-linux-gnu+skylake-avx512; do
        for standard in CL1.2 CL3.0; do
            for fp64 in 0 1; do
                compile "$file" $target $standard $fp64 96 ||
                    echo "$file for $target, $standard, double $fp64"
            done
        done
    done 2>&1)
    if [ -z "$why" ]; then
        echo "ok kernel-$file"
    else
        bad=1
        printf '%s\n' "$why" | head -n 40
        echo "FAILED kernel-$file: $(printf '%s\n' "$why" | tail -n 1)"
    fi
done
exit $bad
