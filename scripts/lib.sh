# shellcheck shell=bash disable=SC2034
# Shared by the scripts beside it: packages, configuring, building. Messages go to standard error.

ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
JOBS=${RECURSE_JOBS:-$(nproc)}
BUILD_PACKAGES=(g++ cmake ninja-build ccache libglm-dev libopenimageio-dev libtbb-dev libflann-dev
    libembree-dev libcli11-dev nlohmann-json3-dev libgtest-dev libbenchmark-dev zlib1g-dev libfftw3-dev libassimp-dev libosd-dev libzip-dev
    libjs-chart.js libjs-three)
TEST_PACKAGES=(libnanovdb-dev chromium python3 gnuplot-nox libopenmpi-dev openmpi-bin procps
    pybind11-dev python3-dev python3-numpy) # the HTML pages are tested in a browser

PACKAGE_LIST=/var/lib/dpkg/status # changes with every package that is installed or removed

# Every checkout shares what ccache keeps: paths below the root count as relative ones.
export CCACHE_BASEDIR=$ROOT CCACHE_NOHASHDIR=1

say() { printf '%s\n' "$*" >&2; }

# requirePackages NAME...: installs the Debian packages that are missing.
requirePackages() {
    if ! command -v dpkg-query apt-get >/dev/null; then
        say "Not a Debian system: if the build stops, install what corresponds to: $*"
        return 0
    fi
    local installed missing=() name
    installed=$'\n'$(dpkg-query -W -f='${Package} ${db:Status-Status}\n' "$@" 2>/dev/null || true)$'\n'
    for name in "$@"; do
        [[ $installed == *$'\n'"$name installed"$'\n'* ]] || missing+=("$name")
    done
    [[ ${#missing[@]} -gt 0 ]] || return 0

    say "Installing Debian packages: ${missing[*]}"
    local asRoot=()
    if [[ $(id -u) != 0 ]]; then
        if ! command -v sudo >/dev/null; then
            say "This needs root, and there is no sudo. As root, run: apt-get install ${missing[*]}"
            return 1
        fi
        asRoot=(sudo)
    fi
    local apt=("${asRoot[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=300)
    "${apt[@]}" update >&2 </dev/null || say "The package lists could not be updated; trying with those at hand."
    if ! "${apt[@]}" install -y --no-install-recommends "${missing[@]}" >&2 </dev/null; then
        say "Installing failed. Needed are: ${missing[*]}"
        return 1
    fi
}

# configure PRESET [CMAKE-OPTION...]: only when it has not been done here, when there are options, or when packages were
# installed or removed since: what is built and tested goes by what is there.
configure() {
    local preset=$1 directory=$ROOT/build/$1 home=
    shift
    if [[ -f $directory/CMakeCache.txt ]]; then
        home=$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$directory/CMakeCache.txt")
        if [[ $home != "$ROOT" ]]; then # the checkout was moved
            rm -rf "$directory/CMakeCache.txt" "$directory/CMakeFiles"
        fi
    fi
    if [[ ! -f $directory/build.ninja || $home != "$ROOT" || $# -gt 0 || $PACKAGE_LIST -nt $directory/build.ninja ]]; then
        (cd "$ROOT" && cmake --preset "$preset" "$@") >&2 </dev/null
    fi
}

# build PRESET [TARGET...]: with progress; silent when there is nothing to do.
build() {
    local directory=$ROOT/build/$1
    shift
    local status=0
    ninja -C "$directory" -j "$JOBS" "$@" </dev/null 2>&1 |
        sed -u -e '/^ninja: Entering directory/d' -e '/^ninja: no work to do/d' -e '/Re-checking globbed/d' >&2 || status=$?
    return "$status"
}

# runTests PRESET [CTEST-OPTION...]: says what was not tested, and closes with the line 'N passed, N failed', which counts
# single cases where ctest counts suites of them.
runTests() {
    local preset=$1 results=$ROOT/build/$1/Testing/Temporary/LastTest.log summary status=0 failures
    shift
    rm -f "$results"
    summary=$(mktemp)
    (cd "$ROOT" && ctest --preset "$preset" -j "$JOBS" "$@" </dev/null) 2>&1 | tee "$summary" || status=$?
    failures=$(sed -n 's/.*tests passed, \([0-9]*\) tests failed out of .*/\1/p' "$summary")
    rm -f "$summary"
    [[ -f $results ]] || results=/dev/null
    awk -v failures="${failures:-0}" -v status="$status" '
        / Testing: / { ok = bad = skip = untested = 0 }
        /^not tested: / { untested = 1; if (!said[$0]++) print }
        /^\[       OK \]/ { ++ok }
        /^\[  FAILED  \] .*\([0-9]+ ms\)$/ { ++bad }
        /^\[  SKIPPED \] .*\([0-9]+ ms\)$/ { ++skip }
        /^Test Passed/ { passed += (ok + skip + untested ? ok : 1); skipped += skip + untested }
        /^Test Failed/ { passed += ok; failed += (bad ? bad : 1); skipped += skip }
        END {
            if (failed < failures) failed = failures
            if (failed == 0 && status != 0) failed = 1 # ctest itself failed, or found no test
            printf "%d passed, %d failed%s\n", passed, failed, (skipped ? ", " skipped " skipped" : "")
        }' "$results"
    return "$status"
}
