# What the tests of builder/cluster/ray share; sourced by them, in the workspace's root.
#
# They run in a network namespace of their own, since Ray would listen at the machine's address. GRASP_PYTHON names a Python that has what
# builder/cluster/ray/requirements.txt lists (by default python3), GRASP_PROGRAMS the folder of the programs to test; without it, they
# are built. A test says so and ends with status 0 where that is not there or not allowed.

skip() { echo "SKIPPED $0: $1"; exit 0; }

# set_up MODULE PROGRAM...: sets `python`, which has the module, and `work`, a folder that goes when the test ends; puts the programs on
# the path.
set_up() {
    local module=$1
    shift
    python=${GRASP_PYTHON:-python3}
    "$python" -c "import $module" 2>/dev/null || skip "$python has no $module (builder/cluster/ray/requirements.txt)"
    unshare --net true 2>/dev/null || skip "a network namespace cannot be made"
    command -v ip >/dev/null || skip "there is no ip (Debian: iproute2)"
    if [ -z "${GRASP_PROGRAMS:-}" ]; then
        cargo build --locked --quiet "${@/#/--package=}"
        GRASP_PROGRAMS=${CARGO_TARGET_DIR:-target}/debug
    fi
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    mkdir "$work/bin"
    local program
    for program; do
        ln -s "$(readlink -f "$GRASP_PROGRAMS/$program")" "$work/bin/$program"
    done
    export PATH="$work/bin:$PATH" RAY_USAGE_STATS_ENABLED=0
}

# alone COMMAND...: runs it where there is no network but this machine's own.
alone() { unshare --net -- bash -c 'ip link set lo up && exec "$@"' alone "$@"; }
