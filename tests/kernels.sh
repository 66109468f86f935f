#!/bin/sh
# kernels.sh: every kernel of cl/ compiles without a warning: with clang's OpenCL front end, for the SPIR of
# GPUs, for x86-64 and for one with AVX-512, as OpenCL 1.2 and 3.0, with double and, on devices that know no such type, without.
# Prints `ok NAME` or `FAILED NAME: why` for each. CLANG names the compiler.
set -u
cd "$(dirname "$0")/.." || exit 1
prefix=kernel-
. tests/common/rules.sh
clang=${CLANG:-clang}

have "$clang" || skip_all "no $clang (apt-get install clang)"
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT

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

compiles() { # compiles FILE: for every target
    cat lib/tree/layout.h cl/common.cl "$1" >"$work/in.cl"
    wrong=0
    for target in spir64-unknown-unknown x86_64-unknown-linux-gnu x86_64-unknown-linux-gnu+skylake-avx512; do
        for standard in CL1.2 CL3.0; do
            for fp64 in 0 1; do
                compile "$1" $target $standard $fp64 96 && continue
                wrong=1
                echo "$1 for $target, $standard, double $fp64"
            done
        done
    done
    return $wrong
}

for path in cl/*.cl; do
    [ "$path" = cl/common.cl ] || rule "$(basename "$path" .cl)" compiles "$path"
done
exit $bad
