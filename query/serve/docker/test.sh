#!/usr/bin/env bash
# Builds the image and tries it: who it runs as, what it may write, its health, its answers, its
# end. Arguments go to the build, e.g. `--build-arg PROFILE=dev`. ENGINE is docker or podman.
# Says so and ends with status 0 where no engine runs.
set -euo pipefail
cd "$(dirname "$0")/../../.."
engine=${ENGINE:-docker}
"$engine" info >/dev/null 2>&1 || { echo "SKIPPED query/serve/docker/test.sh: $engine does not run"; exit 0; }

fail() { echo "query/serve/docker/test.sh: $1" >&2; exit 1; }
picture=tests/pictures/camera/01-large-diameter.jpg
image=grasp-test
"$engine" build --file query/serve/docker/Dockerfile --tag "$image" "$@" .

work=$(mktemp -d)
openssl rand -hex 32 >"$work/token"
chmod -R a+rX "$work"
name=grasp-test-$$
trap '"$engine" rm --force "$name" "$name-token" >/dev/null 2>&1; rm -r "$work"' EXIT
# As docs/install.md runs them, but without a network: the service needs none.
safely=(--detach --read-only --network none --cap-drop ALL --security-opt no-new-privileges)
# Podman leaves the clock of health checks to systemd, which is not everywhere; they are run below.
# What it mounts over /tmp unless told otherwise could be written.
[ "$engine" != podman ] || safely+=(--health-interval disable --read-only-tmpfs=false)
"$engine" run "${safely[@]}" --name "$name" "$image"
"$engine" run "${safely[@]}" --name "$name-token" --volume "$work/token:/run/secrets/token:ro" \
    "$image" serve --listen 0.0.0.0:8750 --token-file /run/secrets/token

is_healthy() {
    if [ "$engine" = podman ]; then
        podman healthcheck run "$1" >/dev/null
    else
        [ "$(docker inspect --format '{{.State.Health.Status}}' "$1")" = healthy ]
    fi
}
for one in "$name" "$name-token"; do
    for _ in {1..60}; do is_healthy "$one" && break; sleep 1; done
    is_healthy "$one" || { "$engine" logs "$one"; fail "$one is not healthy after a minute"; }
done

in_it() { "$engine" exec --interactive "$name" "$@"; }
[ "$(in_it id -u)" = 8750 ] || fail "it runs as $(in_it id)"
for file in /tmp/a /var/lib/grasp/a /usr/local/bin/a; do
    ! in_it touch "$file" 2>/dev/null || fail "it can write $file"
done
in_it grasp-query recognise - --json --server http://127.0.0.1:8750 <"$picture" >"$work/served"
"$engine" run --rm --read-only --interactive --network none "$image" recognise - --json <"$picture" >"$work/alone"
cmp "$work/served" "$work/alone" || fail "the service answers otherwise than the program"
grep -q '"grasp":"large-diameter"' "$work/alone" || fail "wrong: $(cat "$work/alone")"

"$engine" stop --time 20 "$name" >/dev/null
ended=$("$engine" inspect --format '{{.State.ExitCode}}' "$name")
[ "$ended" = 0 ] || fail "stopped, it ended with $ended"
echo "ok: $("$engine" image inspect --format '{{.Size}}' "$image") bytes, not root, read-only, healthy"
