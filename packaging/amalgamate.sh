#!/bin/sh
# amalgamate.sh VERSION FILE.c...: writes the library as one file of C to stdout. Headers come first, in the
# order in which they are needed, then the files, in the order in which they are named; #include lines
# of our own vanish.
#
# What a file keeps to itself may be called the same in another file. Such names get the file's name in
# front, by a #define that ends with the file. A header that is compiled once per instruction set (it
# uses HT_TARGET) or is included under a condition stays where it is included.
set -eu
cd "$(dirname "$0")/.."
version=$1
shift

exec awk -v version="$version" '
function path_of(name, from, folder) {
    if (name == "htree.h") return "include/htree.h"
    if (name ~ /\//) return "lib/" name
    folder = from
    sub(/[^\/]*$/, "", folder)
    return folder name
}
function read_all(path, line, n) { # text[path, 1..lines[path]]
    if (path in lines) return
    n = 0
    while ((getline line < path) > 0) text[path, ++n] = line
    if (n == 0) {
        print "amalgamate.sh: cannot read " path >"/dev/stderr"
        failed = 1
        exit 1
    }
    close(path)
    lines[path] = n
}
function quoted(line, parts) {
    split(line, parts, "\"")
    return parts[2]
}
# True if a header belongs into each file that includes it.
function is_repeated(path, i) {
    read_all(path)
    for (i = 1; i <= lines[path]; ++i) if (text[path, i] ~ /HT_TARGET/) return 1
    return 0
}
# The depth of conditions after a line, without the guard of a header.
function depth_after(depth, line) {
    if (line ~ /^#ifndef (HT|HTREE)_([A-Z0-9_]*_)?(H|HEADER)$/) { guarded = 1; return depth }
    if (line ~ /^#if/) return depth + 1
    if (line ~ /^#endif/) return depth > 0 ? depth - 1 : 0
    return depth
}

# ---- What is needed by all -----------------------------------------------------------------------------

function gather(path, depth, i, line, header) {
    read_all(path)
    depth = 0
    for (i = 1; i <= lines[path]; ++i) {
        line = text[path, i]
        depth = depth_after(depth, line)
        if (depth > 0) continue
        if (line ~ /^#include </ && !(line in system_seen)) {
            system_seen[line] = 1
            systems[++system_count] = line
        }
        if (line !~ /^#include "/) continue
        header = path_of(quoted(line), path)
        if (header == "include/htree.h" || header in shared || is_repeated(header)) continue
        shared[header] = 1
        gather(header)
        headers[++header_count] = header
    }
}

# ---- Names ---------------------------------------------------------------------------------------------

function add_name(file, name) {
    if (name == "" || (file, name) in is_local) return
    is_local[file, name] = 1
    if (users[name]++ == 0) names[++name_count] = name
}
# The last word before the first of some marks, which may be one of a name.
function word_before(line, marks) {
    sub(marks ".*", "", line)
    sub(/.*[ *]/, "", line)
    return line
}
# The functions that a macro of a header defines in the file that uses it.
function add_defined(file, macro, path, i, line, inside) {
    for (path in lines) {
        inside = 0
        for (i = 1; i <= lines[path]; ++i) {
            line = text[path, i]
            if (index(line, "#define " macro "(") == 1) inside = 1
            else if (inside && line ~ / static [^=(]*[a-z_0-9]\(/) add_name(file, word_before(line, "\\("))
            if (line !~ /\\$/) inside = 0
        }
    }
}
# Names that file `file` has for itself, read off `path`, which is it or a part of it. Lines at the left
# margin begin whatever is at file scope.
function find_names(file, path, i, line, n, parts, in_enum) {
    read_all(path)
    in_enum = 0
    for (i = 1; i <= lines[path]; ++i) {
        line = text[path, i]
        sub(/ *\/\*.*/, "", line)
        if (line ~ /^#include "/ && is_repeated(path_of(quoted(line), path)))
            find_names(file, path_of(quoted(line), path))
        if (match(line, /^HT_DEFINE_[A-Z_]+\(/)) add_defined(file, substr(line, 1, RLENGTH - 1))
        if (line ~ /^(enum|typedef enum [a-z_0-9]+) \{/) in_enum = 1
        if (in_enum) {
            n = split(line, parts, /[{},]/)
            for (n = n; n > 0; --n) if (match(parts[n], /[A-Z][A-Z_0-9]+( =|$)/)) {
                sub(/ *=.*/, "", parts[n])
                gsub(/ /, "", parts[n])
                add_name(file, parts[n])
            }
            if (line ~ /}/) in_enum = 0
        }
        if (line ~ /^} [a-z_0-9]+(\[\])?( =.*|;)$/) {
            add_name(file, word_before(line, "(\\[| =|;)"))
        } else if (line ~ /^typedef [^({]*[a-z_0-9];$/) {
            add_name(file, word_before(line, ";"))
        } else if (line ~ /^typedef struct [a-z_0-9]+ \{$/) {
            split(line, parts, " ")
            add_name(file, parts[3])
        } else if (line ~ /^(HT_TARGET |HT_NOINLINE )*(static|HT_INLINE) [^=(]*[a-z_0-9]\(/) {
            add_name(file, word_before(line, "\\("))
        } else if (line ~ /^static .*[=;]/) {
            add_name(file, word_before(line, "(\\[| =|;)"))
        }
    }
}
# subtree of lib/build/bvh.c: subtree_of_build_bvh
function renamed(name, path) {
    gsub(/^lib\/|\.c$/, "", path)
    gsub(/\//, "_", path)
    return name "_of_" path
}
function is_clash(name, path) {
    return users[name] > 1 && (path, name) in is_local
}

# ---- Writing -------------------------------------------------------------------------------------------

function title(path) {
    sub(/^lib\//, "", path)
    return "/* ==== " path " " substr(rule, 1, 88 - length(path)) " */"
}
# What is ours is hidden, but not what a header of the system declares.
function visible(how) {
    how = "#ifdef __GNUC__\n#pragma GCC visibility " how "\n#endif"
    return how ~ /push/ ? how "\n" : "\n" how
}
# A file without what is written already; headers that stay in place are marked to be forgotten after it.
function write(path, i, line, header) {
    for (i = 1; i <= lines[path]; ++i) {
        line = text[path, i]
        if (line ~ /^#include </ && line in system_seen) continue
        if (line !~ /^#include "/) {
            if (line ~ /^#define HT_TARGET/) targeted = 1
            print line ~ /^#include </ ? visible("push(default)") line visible("pop") : line
            continue
        }
        header = path_of(quoted(line), path)
        if (header == "include/htree.h" || header in shared) continue
        read_all(header)
        if (is_repeated(header)) repeated[++repeated_count] = header
        write(header)
    }
}
function write_file(path, i) {
    print "\n" title(path)
    for (i = 1; i <= name_count; ++i)
        if (is_clash(names[i], path)) print "#define " names[i] " " renamed(names[i], path)
    repeated_count = targeted = 0
    write(path)
    for (i = 1; i <= name_count; ++i)
        if (is_clash(names[i], path)) print "#undef " names[i]
    if (targeted) print "#undef HT_TARGET"
    for (i = 1; i <= repeated_count; ++i) print "#undef " guard_of(repeated[i])
}
function guard_of(path, i) {
    for (i = 1; i <= lines[path]; ++i) if (text[path, i] ~ /^#ifndef HT_.*_H$/) {
        return substr(text[path, i], 9)
    }
}

BEGIN {
    while (length(rule) < 100) rule = rule "="
    for (f = 1; f < ARGC; ++f) gather(ARGV[f])
    for (f = 1; f < ARGC; ++f) find_names(ARGV[f], ARGV[f])
    print "/* htree.c: libhtree " version " as one file, made by `make amalgamation`; with htree.h, all of it:"
    print " *"
    print " *     cc -O3 -c htree.c"
    print " *"
    print " * and -lm -lpthread when it is linked, or -DHTREE_NO_THREADS. HTREE_PORTABLE leaves out vector"
    print " * instructions, which are chosen at run time otherwise. Copyright and licence: MIT, see below."
    print " *"
    while ((getline line < "LICENSE") > 0) print (line == "" ? " *" : " * " line)
    print " *\n * SPDX-License-Identifier: MIT */"
    print "#ifndef NDEBUG /* else every build checks the tree that it has built */\n#define NDEBUG\n#endif"
    print "#ifndef _POSIX_C_SOURCE\n#define _POSIX_C_SOURCE 200809L\n#endif"
    print "#ifndef HTREE_BUILDING\n#define HTREE_BUILDING\n#endif\n#include \"htree.h\"\n"
    for (i = 1; i <= system_count; ++i) print systems[i]
    print "\n/* A product is rounded before it is added to, whatever the compiler was told: the same bits. */"
    print "#if defined(__clang__)\n#pragma STDC FP_CONTRACT OFF\n#elif defined(__GNUC__)"
    print "#pragma GCC optimize(\"fp-contract=off\")\n#endif"
    printf "%s", visible("push(hidden)")
    for (i = 1; i <= header_count; ++i) {
        print "\n" title(headers[i])
        write(headers[i])
    }
    for (f = 1; f < ARGC; ++f) write_file(ARGV[f])
    print visible("pop")
    exit failed
}' "$@"
