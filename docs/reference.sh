#!/bin/sh
# reference.sh HEADER: the header with comments that doxygen reads, for INPUT_FILTER of the Doxyfile. Words like
# `Errors` that begin a line of a contract begin a paragraph.
exec awk '
NR == 1 { sub(/^\/\* [a-z_]+\.h: /, "/** @file\n * "); print; next }
/^\/\* ----/ { print; next }
/^\/\* / { sub(/^\/\*/, "/**") }
/[;,{] +\/\* / || /^ +[A-Z_0-9]+ = [0-9]+ +\/\* / { sub(/\/\* /, "/**< ") }
/^ \* (Geometry|Lazy|Threads|Errors|NULL|Refit|quality) +/ {
    word = $2
    sub(/^ \* [A-Za-z]+ +/, " *\n * @par " word "\n * ")
}
{ print }' "$1"
