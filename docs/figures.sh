#!/bin/sh
# figures.sh PAGE: the page on stdout, its blocks of figures taken anew from what was measured. Such a block follows
#
#   <!-- figures: FILE | PATTERN | PATTERN ... -->
#
# and holds, in the order of the file, of each pattern the first line that matches: alone if it begins with #,
# else with all lines up to an empty one.
set -eu
folder=$(dirname "$1")
awk -v folder="$folder" '
function take(file, patterns, count, line, i, open, any) {
    i = 2
    while ((getline line <file) > 0) {
        if (open && line == "") open = 0
        if (open) print line
        else if (i <= count && line ~ patterns[i]) {
            if (line !~ /^#/) {
                if (any) print ""
                open = 1
            }
            print line
            any = 1
            ++i
        }
    }
    close(file)
    if (i <= count) {
        print FILENAME ": " file " has no line with " patterns[i] >"/dev/stderr"
        failed = 1
    }
}
/^<!-- figures: .* -->$/ {
    print
    sub(/^<!-- figures: /, "")
    sub(/ -->$/, "")
    count = split($0, words, / \| /)
    getline
    print
    take(folder "/" words[1], words, count)
    while ((getline line) > 0 && line !~ /^```/) continue
    $0 = line
}
{ print }
END { exit failed }' "$1"
