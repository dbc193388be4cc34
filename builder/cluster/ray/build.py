"""Builds an index on a Ray cluster.

    python build.py --shards 1000 --parts /shared/parts --index /shared/grasp.idx --preset wide --hands 10000

PARTS and INDEX lie on a file system that all nodes share; grasp-builder is in the PATH of each. What is not known here is handed on
to grasp-builder. Running it again makes only the parts that are missing.
"""

import argparse
import subprocess

import ray


@ray.remote(num_cpus=1, max_retries=3, retry_exceptions=True)
def shard(number, of, parts, options):
    """Makes one part. A worker or a node that is lost on the way, and an error, are tried again elsewhere."""
    share = ["--shard", f"{number}/{of}", "--threads", "1", "--out", parts]
    subprocess.run(["grasp-builder", "shard", *share, *options], check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--address", help="the cluster, as ray.init takes it; without it, the one of RAY_ADDRESS or a local one")
    parser.add_argument("--shards", type=int, required=True)
    parser.add_argument("--parts", required=True)
    parser.add_argument("--index", required=True)
    arguments, options = parser.parse_known_args()
    ray.init(address=arguments.address)
    ray.get([shard.remote(i + 1, arguments.shards, arguments.parts, options) for i in range(arguments.shards)])
    subprocess.run(["grasp-builder", "merge", arguments.parts, "--out", arguments.index], check=True)


if __name__ == "__main__":
    main()
