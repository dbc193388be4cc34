#!/usr/bin/env bash
# builder/cluster/ray on a cluster of two nodes on this machine: eight shards, one worker and one node killed while at work; the merged
# index must be, byte for byte, the one of a single build, and no temporary file may be left. What it needs: ray_set_up.sh.
set -euo pipefail
cd "$(dirname "$0")/../.."
source tests/cluster/ray_set_up.sh

set_up ray grasp-builder
alone "$python" tests/cluster/ray_build.py "$work"
echo "OK tests/cluster/ray.sh: 8 parts on 2 nodes, one worker and one node killed; the index is the single build's ($SECONDS s)"
