#!/usr/bin/env bash
# Builds what a release has for one platform: build.sh TARGET OUT
#
#     .github/release/build.sh x86_64-unknown-linux-gnu dist
#
# TARGET is the platform, as Rust names it, and has to be the one on which this runs: programs and
# wheel are tried before they are packed. Besides Rust it needs Python with what
# requirements.txt beside this file lists.
#
# On Linux it is glibc 2.28 (2018: Debian 10, Ubuntu 20.04, RHEL 8 and later), linked by zig, which
# has the symbols of each version. Programs with musl would run everywhere, but its allocator has
# one lock for all threads, and wheels need glibc anyway.
set -euo pipefail
cd "$(dirname "$0")/../.."
[ $# = 2 ] || { sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 2; } >&2
target=$1 out=$2

build=(cargo build --target "$target")
wheel=(--strip --target "$target")
case $target in
*-linux-gnu)
    build=(cargo zigbuild --target "$target.2.28")
    wheel+=(--zig --compatibility manylinux_2_28)
    ;;
esac

# A panic names its line all the same, without the lines of its callers.
export CARGO_PROFILE_RELEASE_STRIP=debuginfo
"${build[@]}" --release --locked --package grasp-builder --package grasp-query
third_party=target/$target/LICENSE-THIRD-PARTY
python .github/release/licences.py "$target" Cargo.toml grasp-builder grasp-query >"$third_party"
python .github/release/package.py "$target" "target/$target/release" "$third_party" "$out"

# maturin packs what lies beside pyproject.toml under such a name.
licences=(query/python/LICENSE-{APACHE,MIT,poses,THIRD-PARTY})
trap 'rm -f "${licences[@]}"' EXIT
cp LICENSE-APACHE LICENSE-MIT renders/data/LICENSE-poses query/python
python .github/release/licences.py "$target" query/python/Cargo.toml grasp-python >query/python/LICENSE-THIRD-PARTY
maturin build --release --locked --manifest-path query/python/Cargo.toml --out "$out" "${wheel[@]}"
python -m pip install --no-index --no-deps --force-reinstall --find-links "$out" grasp
python .github/release/try_wheel.py
