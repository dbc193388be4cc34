#!/usr/bin/env bash
# builder/cluster/ray/serve.py on a cluster of two nodes on this machine: four segments whose answers must be, byte for byte, those of the
# single index, before and after a segment's service and a node are killed; then a segment is missing for good, which is an error or told.
#
# Runs in a network namespace of its own, since Ray would listen at the machine's address. GRASP_PYTHON names a Python that has what
# builder/cluster/ray/requirements.txt lists (by default python3), GRASP_PROGRAMS the folder of the programs to test; without it, they
# are built. Says so and ends with status 0 where that is not there or not allowed.
set -euo pipefail
cd "$(dirname "$0")/../.."

skip() { echo "SKIPPED tests/cluster/ray_serve.sh: $1"; exit 0; }
python=${GRASP_PYTHON:-python3}
"$python" -c 'import ray.serve' 2>/dev/null || skip "$python has no Ray Serve (builder/cluster/ray/requirements.txt)"
unshare --net true 2>/dev/null || skip "a network namespace cannot be made"
command -v ip >/dev/null || skip "there is no ip (Debian: iproute2)"

if [ -z "${GRASP_PROGRAMS:-}" ]; then
    cargo build --locked --quiet --package grasp-builder --package grasp-query
    GRASP_PROGRAMS=${CARGO_TARGET_DIR:-target}/debug
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/bin"
ln -s "$(readlink -f "$GRASP_PROGRAMS")"/grasp-{builder,query} "$work/bin/"
export PATH="$work/bin:$PATH" RAY_USAGE_STATS_ENABLED=0
unshare --net -- bash -c 'ip link set lo up && exec "$@"' ray "$python" tests/cluster/ray_serve.py "$work"
echo "OK tests/cluster/ray_serve.sh: 4 segments on 2 nodes answer as their index, a service and a node being killed ($SECONDS s)"
