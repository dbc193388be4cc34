#!/usr/bin/env bash
# Builds the node and tries it beside CycloneDDS and beside ROS 2 itself, both as Python packages in
# an environment of its own (target/ros/venv). Besides Rust it needs Python 3.10 or later and its
# packages' index. GRASP_PROGRAMS names a folder with grasp-builder and grasp-query that are built
# already, GRASP_ROS the node. Arguments go to pytest: `--seconds 60` publishes pictures as long.
set -euo pipefail
cd "$(dirname "$0")"
root=$(cd ../.. && pwd)
target=${CARGO_TARGET_DIR:-$root/target}/ros

"${PYTHON:-python3}" -m venv --clear "$target/venv"
export PATH=$target/venv/bin:$PATH
python -m pip --disable-pip-version-check --quiet install --requirement tests/requirements.txt

if [ -z "${GRASP_PROGRAMS:-}" ]; then
    # What answers are compared with needs neither the service nor the physics engine.
    cargo build --locked --manifest-path "$root/Cargo.toml" --target-dir "$target/programs" \
        --package grasp-builder --package grasp-query --no-default-features
    export GRASP_PROGRAMS=$target/programs/debug
fi
if [ -z "${GRASP_ROS:-}" ]; then
    cargo test --locked --target-dir "$target/cargo"
    cargo build --locked --target-dir "$target/cargo"
    export GRASP_ROS=$target/cargo/debug/grasp-ros
fi
python -m pytest -q -p no:cacheprovider tests "$@"
