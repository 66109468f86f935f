#!/bin/sh
# fresh_root.sh FOLDER: a Debian 12 with git, make, ca-certificates and nothing else, in FOLDER; there, what
# README.md says, word for word: the two commands, `make install`, then minimal.c through pkg-config, as a
# CMake project and over the one file. Prints `ok fresh-NAME` or `FAILED fresh-NAME: why` for each.
#
# It needs root, debootstrap and a network. A FOLDER that holds a system already is taken as it is. Of the second
# command only the tests of one config run, unless FULL=1 asks for all of them.
set -u
cd "$(dirname "$0")/.." || exit 1
root=${1:?fresh_root.sh FOLDER}
here=/root/libhtree
bad=0
trap 'umount "$root/proc" "$root/sys" 2>/dev/null' EXIT

rule() { # rule NAME WORD...: runs the words, their output into FOLDER.NAME.log, and prints their verdict
    name=$1
    shift
    start=$(date +%s)
    if "$@" >"$root.$name.log" 2>&1; then
        echo "ok fresh-$name ($(($(date +%s) - start)) s)"
    else
        bad=1
        tail -n 30 "$root.$name.log"
        echo "FAILED fresh-$name: see $root.$name.log"
    fi
}

# The first mirror that this machine itself installs from.
mirror() {
    apt-get indextargets --format "\$(REPO_URI)" 'Created-By: Packages' 'Codename: bookworm' | head -n 1
}

strap() {
    [ -x "$root/usr/bin/git" ] ||
        debootstrap --variant=minbase --include=git,make,ca-certificates bookworm "$root" "$(mirror)" || return 1
    mount -t proc proc "$root/proc" && mount -t sysfs sysfs "$root/sys"
}

# A clone of what is committed here.
clone() {
    git bundle create "$root/root/libhtree.bundle" HEAD || return 1
    rm -rf "$root$here"
    chroot "$root" git clone -q /root/libhtree.bundle $here
}

inside() { # inside COMMAND: by sh in the clone, with nothing of this machine's environment
    env -i HOME=/root PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
        chroot "$root" sh -ec "cd $here && $1"
}

# says PATTERN: the one line of README.md's blocks of sh that matches, without its comment
says() {
    line=$(awk '/^```/ { block = $0 == "```sh" } block' README.md | grep -e "$1" | sed 's/ *#.*//')
    [ -n "$line" ] || echo "false: README.md has no line with $1"
    printf '%s\n' "$line"
}

first_command() {
    inside "$(says '^make deps run')" || return 1
    [ "$(find "$root$here/build/release/out" -name '*.png' -size +4k | wc -l)" -ge 15 ]
}

second_command() {
    case ${FULL-} in
    1) inside "$(says '^make deps check')" ;;
    *) inside "$(says '^make deps check' | sed 's/check/test/')" ;;
    esac
}

installs() {
    inside 'make install && ldconfig'
}

by_pkg_config() {
    inside 'cp examples/minimal.c app.c'
    inside "$(says 'pkg-config --cflags')"' && ./app | grep "^triangle 3"'
}

by_cmake() {
    inside 'apt-get install -y -qq --no-install-recommends cmake >/dev/null
        mkdir -p consumer && cp examples/minimal.c consumer && cd consumer
        printf "%s\n" "cmake_minimum_required(VERSION 3.16)" "project(consumer C)" "find_package(htree 0.1 REQUIRED)" \
            "add_executable(app minimal.c)" "target_link_libraries(app PRIVATE htree::htree)" >CMakeLists.txt
        cmake -S . -B build && cmake --build build && build/app | grep "^triangle 3"'
}

by_one_file() {
    inside 'make amalgamation && rm -f app'
    inside "$(says 'app.c dist/htree.c')"' && ./app | grep "^triangle 3"'
}

rule strap strap
rule clone clone
rule first-command first_command
rule second-command second_command
rule installs installs
rule by-pkg-config by_pkg_config
rule by-cmake by_cmake
rule by-one-file by_one_file
exit $bad
