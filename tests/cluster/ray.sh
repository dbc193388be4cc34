#!/usr/bin/env bash
# builder/cluster/ray on a cluster of two nodes on this machine: eight shards, one worker and one node killed while at work; the merged
# index must be, byte for byte, the one of a single build, and no temporary file may be left.
#
# Runs in a network namespace of its own, since Ray would listen at the machine's address. GRASP_PYTHON names a Python that has what
# builder/cluster/ray/requirements.txt lists (by default python3), GRASP_BUILDER the program to test; without it, it is built. Says so
# and ends with status 0 where that is not there or not allowed.
set -euo pipefail
cd "$(dirname "$0")/../.."

skip() { echo "SKIPPED tests/cluster/ray.sh: $1"; exit 0; }
python=${GRASP_PYTHON:-python3}
"$python" -c 'import ray' 2>/dev/null || skip "$python has no Ray (builder/cluster/ray/requirements.txt)"
unshare --net true 2>/dev/null || skip "a network namespace cannot be made"
command -v ip >/dev/null || skip "there is no ip (Debian: iproute2)"

if [ -z "${GRASP_BUILDER:-}" ]; then
    cargo build --locked --quiet --package grasp-builder
    GRASP_BUILDER=${CARGO_TARGET_DIR:-target}/debug/grasp-builder
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/bin"
ln -s "$(readlink -f "$GRASP_BUILDER")" "$work/bin/grasp-builder"
export PATH="$work/bin:$PATH" RAY_USAGE_STATS_ENABLED=0
unshare --net -- bash -c 'ip link set lo up && exec "$@"' ray "$python" tests/cluster/ray_build.py "$work"
echo "OK tests/cluster/ray.sh: 8 parts on 2 nodes, one worker and one node killed; the index is the single build's ($SECONDS s)"
