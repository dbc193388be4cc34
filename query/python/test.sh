#!/usr/bin/env bash
# Builds the wheel, installs it into an environment of its own (target/python/venv) and runs its
# tests and the check of its types. Besides Rust it needs Python 3.10 or later and its packages'
# index. GRASP_PROGRAMS names a folder with grasp-builder and grasp-query that are built already;
# further arguments go to pytest.
set -euo pipefail
cd "$(dirname "$0")"
root=$(cd ../.. && pwd)
target=${CARGO_TARGET_DIR:-$root/target}/python

"${PYTHON:-python3}" -m venv --clear "$target/venv"
# The build's backend looks for maturin there.
export PATH=$target/venv/bin:$PATH
pip() { python -m pip --disable-pip-version-check --quiet "$@"; }
pip install --requirement tests/requirements.txt

if [ -z "${GRASP_PROGRAMS:-}" ]; then
    # What the tests compare with needs neither the service nor the physics engine.
    cargo build --locked --manifest-path "$root/Cargo.toml" --target-dir "$target/programs" \
        --package grasp-builder --package grasp-query --no-default-features
    export GRASP_PROGRAMS=$target/programs/debug
fi

rm -rf "$target/wheels"
CARGO_TARGET_DIR=$target/cargo pip wheel --no-deps --no-build-isolation --wheel-dir "$target/wheels" .
pip install --no-deps "$target"/wheels/grasp-*.whl
python -m mypy.stubtest grasp
python -m pytest "$@"
