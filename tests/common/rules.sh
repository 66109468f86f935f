# rules.sh: for scripts of tests/, which set `prefix` and source it: verdicts, as run.sh counts them. A
# script ends with `exit $bad`.
bad=0

have() { # have TOOL
    command -v "$1" >/dev/null 2>&1
}

rule() { # rule NAME WORD...: runs the words and prints their verdict; they print why they fail
    name=$prefix$1
    shift
    if why=$("$@" 2>&1); then
        echo "ok $name"
        printf '%s\n' "$why" | sed -n 's/^count: /    /p'
    else
        bad=1
        printf '%s\n' "$why" | tail -n 60
        echo "FAILED $name: $(printf '%s\n' "$why" | tail -n 1)"
    fi
}

# What a machine lacks is no failure, unless HTREE_REQUIRE_ALL=1 says that it has all.
skip() { # skip NAME WHY
    if [ "${HTREE_REQUIRE_ALL-}" = 1 ]; then
        bad=1
        echo "FAILED $prefix$1: $2"
    else
        echo "skipped $prefix$1: $2"
    fi
}

skip_all() { # skip_all WHY: and ends
    skip all "$1"
    exit $bad
}

exported() { # exported LIBRARY: its symbols
    nm -D --defined-only "$1" | awk '$2 != "A" { sub(/@.*/, "", $3); print $3 }' | sort
}
