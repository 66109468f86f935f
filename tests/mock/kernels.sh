#!/bin/sh
# kernels.sh OBJECT CLANG FLAGS KERNEL...: compiles the kernels of cl/ for the host into one object, each
# with and without double and for every size of stack that lib/opencl/program.c asks for, and the table
# mock_compiled_kernels of them. FLAGS is one word, as "-O2 -g".
set -eu
cd "$(dirname "$0")/../.."
object=$1 clang=$2 flags=$3
shift 3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
names=$work/names table=$work/table.c rows=$work/rows
: >"$names" && : >"$rows"
printf '#include "mock_inner.h"\n' >"$table"

for file; do
    cat lib/tree/layout.h cl/common.cl "cl/$file.cl" >"$work/$file.cl"
    full=96
    [ "$file" = wide ] && full=256
    for stack in 32 64 $full; do
        for fp64 in 0 1; do
            name=mock_${file}_${stack}_${fp64}
            double=
            [ $fp64 = 1 ] && double=-DHT_FP64
            # shellcheck disable=SC2086
            "$clang" -x cl -cl-std=CL1.2 -Xclang -finclude-default-header $flags $double -DHT_STACK=$stack \
                -Dhtree_closest=${name}_closest -Dhtree_any=${name}_any -Wno-psabi -fPIC -c \
                -o "$work/$name.o" "$work/$file.cl"
            # Every file has functions of the same names: only the kernels stay visible.
            objcopy --keep-global-symbol=${name}_closest --keep-global-symbol=${name}_any "$work/$name.o"
            printf 'void %s_closest(const void *, const void *, const void *, const void *,\n' "$name"
            printf '    const void *, void *, cl_ulong, cl_ulong);\n'
            printf 'void %s_any(const void *, const void *, const void *, const void *,\n' "$name"
            printf '    const void *, void *, cl_ulong, cl_ulong);\n'
            printf '    {"%s", %s, %s, %s_closest, %s_any},\n' "$file" $stack $fp64 "$name" "$name" >>"$rows"
            echo "$work/$name.o" >>"$names"
        done
    done
done >>"$table"
{
    printf 'const mock_compiled mock_compiled_kernels[] = {\n'
    cat "$rows"
    printf '    {NULL, 0, 0, NULL, NULL},\n};\n'
} >>"$table"
"$clang" -std=c99 -Itests/mock -fvisibility=hidden -fPIC -c -o "$work/table.o" "$table"
# shellcheck disable=SC2046
ld -r -o "$object" "$work/table.o" $(cat "$names")
