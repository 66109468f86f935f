#!/bin/sh
# deps.sh STAMP PACKAGE...: install the Debian packages that are missing, or say exactly what to install.
# The file STAMP is newer afterwards if anything was installed.
#
# Exit status: 0 if everything required is there. What is optional is worth a note.
set -eu

# A name without an architecture means this machine's, though another's may be there beside it.
list_missing() {
    native=$(dpkg --print-architecture 2>/dev/null || true)
    for package in "$@"; do
        case $package in *:*) wanted=${package#*:} ;; *) wanted="$native|all" ;; esac
        dpkg-query -W -f '${Architecture} ${Status}\n' "$package" 2>/dev/null |
            grep -qEx "($wanted) install ok installed" || printf ' %s' "$package"
    done
}

# Root needs no sudo; anybody else may use it only if it asks for no password.
may_install() {
    command -v apt-get >/dev/null || return 1
    [ "$(id -u)" -eq 0 ] && return 0
    sudo=sudo
    sudo -n true 2>/dev/null
}

stamp=$1
shift
[ -e "$stamp" ] || : >"$stamp"
missing=$(list_missing "$@")
[ -n "$missing" ] || exit 0

sudo=
if may_install; then
    echo "installing$missing"
    export DEBIAN_FRONTEND=noninteractive
    $sudo apt-get update -qq || true
    # One by one: a package that cannot be had must not keep the others out.
    for package in $missing; do
        $sudo apt-get install -y -qq --no-install-recommends "$package" >/dev/null || true
    done
    before=$missing
    missing=$(list_missing "$@")
    [ "$missing" = "$before" ] || touch "$stamp"
fi

required=
for package in $missing; do
    case $package in
    libassimp-dev) without="meshes other than PLY" ;;
    libwebp-dev) without="animated pictures" ;;
    gnuplot-nox) without="make plots" ;;
    opencl-headers) without="libhtree_cl" ;;
    ocl-icd-libopencl1 | pocl-opencl-icd) without="OpenCL on the CPU" ;;
    *) required="$required $package" && continue ;;
    esac
    echo "note: there will be no $without (apt-get install $package)" >&2
done
[ -n "$required" ] || exit 0
echo "error: please run: sudo apt-get install$required" >&2
exit 1
