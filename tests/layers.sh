#!/bin/sh
# layers.sh: the include law of lib/, read from its #include lines, and the map lib/README.md.
#
#   base <- tree <- build, trace <- public (files directly in lib/)
#   base, tree's layout.h, the public header <- opencl (libhtree_cl)
#
# A file includes from lower layers, from its own folder, and htree.h. Prints what breaks the law; exits
# with 1 if anything does.
set -u
cd "$(dirname "$0")/.." || exit 1

files=$(find lib -type f \( -name '*.c' -o -name '*.h' \) | sort)
if [ -z "$files" ]; then
    echo "layers: no files in lib/"
    exit 1
fi

# shellcheck disable=SC2086
law=$(awk '
function layer_of(path, parts, n) {
    n = split(path, parts, "/")
    return n == 1 ? "public" : parts[1]
}
function complain(text) {
    printf "%s:%d: %s\n", FILENAME, FNR, text
}
BEGIN {
    may["base"] = " base "
    may["tree"] = " base tree "
    may["build"] = " base tree build "
    may["trace"] = " base tree trace "
    may["opencl"] = " base tree opencl "
    may["public"] = " base tree build trace public "
}
FNR == 1 {
    mine = substr(FILENAME, 5)
    layer = layer_of(mine)
    in_comment = 0
    if (!(layer in may)) complain("folder lib/" layer " is no layer: name it in tests/layers.sh")
}
/^[ \t]*#[ \t]*include[ \t]*"/ {
    split($0, quoted, "\"")
    wanted = quoted[2]
    if (wanted == "htree.h") next
    if (wanted == "htree_cl.h" && layer == "opencl") next
    if (layer == "opencl" && layer_of(wanted) == "tree" && wanted != "tree/layout.h")
        complain("libhtree_cl sees trees through htree_get_view, not through " wanted)
    # A name without a folder is a neighbour.
    from = wanted ~ /\// ? layer_of(wanted) : layer
    if (wanted ~ /\.\./) complain("includes " wanted ": paths start at lib/")
    else if (index(may[layer], " " from " ") == 0)
        complain("layer " layer " may not include " wanted " of layer " from)
    next
}
/^[ \t]*#[ \t]*include[ \t]*</ {
    if ($0 ~ /pthread|threads\.h/ && mine !~ /^base\/tasks\.[ch]$/)
        complain("only lib/base/tasks.[ch] may use threads")
    next
}
{
    # Comments and strings are not code.
    line = $0
    gsub(/"([^"\\]|\\.)*"/, "\"\"", line)
    while (1) {
        if (in_comment) {
            end = index(line, "*/")
            if (end == 0) { line = ""; break }
            line = substr(line, end + 2)
            in_comment = 0
        }
        start = index(line, "/*")
        if (start == 0) break
        rest = substr(line, start + 2)
        end = index(rest, "*/")
        if (end == 0) { line = substr(line, 1, start - 1); in_comment = 1; break }
        line = substr(line, 1, start - 1) " " substr(rest, end + 2)
    }
    code = " " line
    if (code ~ /[^A-Za-z0-9_>.](malloc|calloc|realloc|free|aligned_alloc|posix_memalign|alloca)[ \t]*\(/ &&
        mine != "base/memory.c") complain("only lib/base/memory.c may allocate")
    if (code ~ /[^A-Za-z0-9_](pthread_|thrd_)/ && mine !~ /^base\/tasks\.[ch]$/)
        complain("only lib/base/tasks.[ch] may use threads")
    if (code ~ /[^A-Za-z0-9_](printf|fprintf|vprintf|vfprintf|puts|fputs|putchar|perror|exit|abort)[ \t]*\(/)
        complain("the library does not print and does not exit")
    if (code ~ /[^A-Za-z0-9_](setjmp|longjmp|signal|getenv|setlocale|rand|srand|errno)[^A-Za-z0-9_]/)
        complain("the library keeps no global state")
}' $files)

# The map: every file is on it, and what it names exists. Paths start at lib/; names of files that are
# to come stand behind the words "to come".
map=lib/README.md
if [ -f "$map" ]; then
    on_map=$(for file in $files lib/htree.map lib/htree_cl.map; do
        [ -f "$file" ] || continue
        grep -q "\`${file#lib/}\`" "$map" || echo "$map: does not name \`${file#lib/}\`"
    done
    sed 's/to come.*//' "$map" | grep -o '`[A-Za-z0-9_./-]*/[A-Za-z0-9_.-]*\.[a-z]*`' | tr -d '\140' | sort -u |
        while read -r name; do
            [ -e "lib/$name" ] || [ -e "$name" ] || echo "$map: names $name, which does not exist"
        done)
else
    on_map="$map: missing"
fi

if [ -n "$law$on_map" ]; then
    printf '%s\n' "$law" "$on_map" | grep .
    exit 1
fi
echo "layers: $(echo "$files" | wc -l) files keep the include law and are on the map"
