#!/bin/sh
# embed.sh KERNEL...: the C source of lib/opencl's kernels: layout.h, common.cl and the file of every
# kernel as arrays of bytes, in the order of ht_cl_file in lib/opencl/cl.h.
set -eu
cd "$(dirname "$0")/.."

bytes() { # bytes FILE
    od -An -v -tu1 "$1" | sed 's/  *\([0-9][0-9]*\)/\1,/g'
    echo 0
}

printf '/* Written by cl/embed.sh. */\n#include "opencl/cl.h"\n'
printf '\nconst char ht_cl_layout[] = {\n' && bytes lib/tree/layout.h && printf '};\n'
printf '\nconst char ht_cl_common[] = {\n' && bytes cl/common.cl && printf '};\n'
for kernel; do
    printf '\nstatic const char %s_source[] = {\n' "$kernel" && bytes "cl/$kernel.cl" && printf '};\n'
done
printf '\nconst char *const ht_cl_source[HT_CL_FILES] = {\n'
for kernel; do printf '    %s_source,\n' "$kernel"; done
printf '};\n'
