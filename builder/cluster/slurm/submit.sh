#!/usr/bin/env bash
# Builds an index on a Slurm cluster: submit.sh SHARDS PARTS INDEX [options of grasp-builder build]
#
#     submit.sh 1000 /shared/parts /shared/grasp.idx --preset wide --hands 10000
#
# PARTS and INDEX lie on a file system that all nodes share; grasp-builder is in the PATH. Options of sbatch, such as the partition,
# are given as SBATCH_PARTITION and so on. Running it again makes only the parts that are missing.
set -euo pipefail
[ $# -ge 3 ] || { sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 2; } >&2
here=$(dirname "$(readlink -f "$0")")
shards=$1 parts=$2 index=$3
shift 3
job=$(sbatch --parsable --array="1-$shards" "$here/shards.sbatch" "$shards" "$parts" "$@")
merge=$(sbatch --parsable --dependency="afterok:$job" "$here/merge.sbatch" "$parts" "$index")
echo "parts: job $job; index: job $merge, once all parts are there"
