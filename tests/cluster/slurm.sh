#!/usr/bin/env bash
# builder/cluster/slurm on a cluster of two nodes on this machine: twelve shards, one worker and one node killed while at work; the
# merged index must be, byte for byte, the one of a single build, and no temporary file may be left.
#
# Takes one to two minutes. Says so and ends with status 0 where Slurm is not installed (Debian: slurm-wlm and munge) or may not be
# started. GRASP_BUILDER names the program to test; without it, it is built.
set -euo pipefail
cd "$(dirname "$0")/../.."

skip() { echo "SKIPPED tests/cluster/slurm.sh: $1"; exit 0; }
for program in slurmctld slurmd munged munge sbatch; do
    command -v "$program" >/dev/null || skip "$program is not installed (Debian: slurm-wlm, munge)"
done
[ "$(id -u)" = 0 ] || skip "only root can start its daemons"

if [ -z "${GRASP_BUILDER:-}" ]; then
    cargo build --locked --quiet --package grasp-builder
    GRASP_BUILDER=${CARGO_TARGET_DIR:-target}/debug/grasp-builder
fi
scripts=$PWD/builder/cluster/slurm
work=$(mktemp -d)
mkdir -m 700 "$work"/{bin,munge,state,spool-a,spool-b,log}
ln -s "$(readlink -f "$GRASP_BUILDER")" "$work/bin/grasp-builder"
export PATH="$work/bin:$PATH" SLURM_CONF="$work/slurm.conf"
options=(--hands 12 --step 12 --thumbnails 0)

environment() { { tr '\0' '\n' <"$1/environ"; } 2>/dev/null || true; }
declare -A daemon
end() {
    status=$?
    for pid in "${daemon[@]}"; do kill "$pid" 2>/dev/null || true; done
    wait 2>/dev/null || true
    # Steps that outlive their node's daemon: those that this run started carry its folder in their command line or environment.
    for process in /proc/[0-9]*; do
        if environment "$process" | grep -qxF "SLURM_CONF=$SLURM_CONF" && [ "${process#/proc/}" != $$ ]; then
            kill -9 "${process#/proc/}" 2>/dev/null || true
        fi
    done
    if [ "$status" != 0 ]; then tail -n 20 "$work"/log/* >&2 || true; fi
    rm -rf "$work"
    exit "$status"
}
trap end EXIT

cat >"$SLURM_CONF" <<END
ClusterName=grasp
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort=16917
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$work/munge/socket
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool-%n
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd-%n.pid
SlurmctldLogFile=$work/log/slurmctld
SlurmdLogFile=$work/log/slurmd-%n
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SwitchType=switch/none
MpiDefault=none
SlurmdTimeout=15
ReturnToService=2
SchedulerParameters=sched_interval=2,bf_interval=2
NodeName=a NodeHostname=localhost NodeAddr=127.0.0.1 Port=17001 CPUs=1 State=UNKNOWN
NodeName=b NodeHostname=localhost NodeAddr=127.0.0.1 Port=17002 CPUs=1 State=UNKNOWN
PartitionName=all Nodes=a,b Default=YES MaxTime=INFINITE State=UP
END
head -c 128 /dev/urandom >"$work/munge/key"
chmod 400 "$work/munge/key"

start() { # NAME COMMAND...: in the background, to be ended with this script
    local name=$1
    shift
    "$@" >"$work/log/$name.out" 2>&1 &
    daemon[$name]=$!
}
wait_for() { # SECONDS WHAT COMMAND...: until it succeeds
    local until=$((SECONDS + $1)) what=$2
    shift 2
    until "$@" >/dev/null 2>&1; do
        if [ $SECONDS -ge $until ]; then
            echo "FAILED: $what: not within the time given" >&2
            squeue --all >&2 || true
            sinfo -N -l >&2 || true
            exit 1
        fi
        sleep 0.2
    done
}
start munged munged --foreground --force --key-file="$work/munge/key" --socket="$work/munge/socket" \
    --pid-file="$work/munge/pid" --seed-file="$work/munge/seed" --log-file="$work/log/munged"
wait_for 10 "munged" munge --socket="$work/munge/socket" --no-input
start slurmctld slurmctld -D
start a slurmd -D -N a
start b slurmd -D -N b
both_are_idle() { [ "$(sinfo --noheader --Node --states=idle --format=%N | wc -l)" = 2 ]; }
wait_for 60 "two nodes" both_are_idle

cd "$work"
worker_on() { # NODE: the id of a grasp-builder that is writing a part there
    local pid
    for pid in $(pgrep -x grasp-builder); do
        if environment "/proc/$pid" | grep -qxF "SLURM_CONF=$SLURM_CONF" && environment "/proc/$pid" | grep -qx "SLURMD_NODENAME=$1" &&
            ls -l "/proc/$pid/fd" 2>/dev/null | grep -q '\.shard\.part$'; then
            echo "$pid"
            return
        fi
    done
    return 1
}
parent() { ps -o ppid= -p "$1" | tr -d ' '; }
"$scripts/submit.sh" 12 "$work/parts" "$work/merged.idx" "${options[@]}"

wait_for 60 "a worker at work on node a" worker_on a
kill -9 "$(worker_on a)"
echo "killed a worker"

wait_for 60 "a worker at work on node b" worker_on b
worker=$(worker_on b)
task=$(parent "$worker")
step=$(parent "$task")
[[ $(cat "/proc/$step/comm") = slurmstepd* ]]
# All at once, as when the power fails.
kill -9 "${daemon[b]}" "$step" "$task" "$worker"
echo "killed a node"

# A requeued task waits two minutes, lest its node be as it was; here it need not.
hurry() {
    local job
    for job in $(squeue --noheader --array --states=PENDING --name=grasp-shard --format=%A); do
        scontrol update JobId="$job" StartTime=now >/dev/null 2>&1 || true
    done
    [ -e "$work/merged.idx" ]
}
wait_for 600 "the merged index" hurry
queue_is_empty() { [ -z "$(squeue --noheader)" ]; }
wait_for 30 "the end of the merge" queue_is_empty

grasp-builder build --out single.idx "${options[@]}" >/dev/null
cmp single.idx merged.idx
left=$(find parts -type f ! -name '*-of-12.shard')
[ -z "$left" ] || { echo "FAILED: files left: $left" >&2; exit 1; }
[ "$(find parts -type f | wc -l)" = 12 ]
echo "OK tests/cluster/slurm.sh: 12 parts on 2 nodes, one worker and one node killed; the index is the single build's ($SECONDS s)"
