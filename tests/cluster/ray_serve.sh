#!/usr/bin/env bash
# builder/cluster/ray/serve.py on a cluster of two nodes on this machine: four segments whose answers must be, byte for byte, those of the
# single index, before and after a segment's service and a node are killed; then a segment is missing for good, which is an error or told.
# What it needs: ray_set_up.sh.
set -euo pipefail
cd "$(dirname "$0")/../.."
source tests/cluster/ray_set_up.sh

set_up ray.serve grasp-builder grasp-query
alone "$python" tests/cluster/ray_serve.py "$work"
echo "OK tests/cluster/ray_serve.sh: 4 segments on 2 nodes answer as their index, a service and a node being killed ($SECONDS s)"
