"""What tests/cluster/ray.sh runs in a network of its own: a folder to work in is its argument."""

import filecmp
import os
import pathlib
import signal
import subprocess
import sys
import time

from ray.cluster_utils import Cluster

HERE = pathlib.Path(__file__).resolve().parent
OPTIONS = ["--hands", "8", "--step", "12", "--thumbnails", "0"]


def workers(ancestor):
    """The grasp-builders below a process that are writing a part."""
    tree = {}
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            parent = int((process / "stat").read_text().rsplit(")", 1)[1].split()[1])
            tree.setdefault(parent, []).append(int(process.name))
        except OSError:
            pass
    found, below = [], [ancestor]
    while below:
        pid = below.pop()
        below += tree.get(pid, [])
        try:
            open_files = [os.readlink(file) for file in pathlib.Path(f"/proc/{pid}/fd").iterdir()]
            if any(name.endswith(".shard.part") for name in open_files):
                found.append(pid)
        except OSError:
            pass
    return found


def wait_for_worker(ancestor):
    end = time.monotonic() + 120
    while time.monotonic() < end:
        if found := workers(ancestor):
            return found[0]
        time.sleep(0.05)
    sys.exit("FAILED: no worker came to work")


def main():
    work = pathlib.Path(sys.argv[1])
    parts, merged, single = work / "parts", work / "merged.idx", work / "single.idx"
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "node_ip_address": "127.0.0.1"})
    second = cluster.add_node(num_cpus=1, node_ip_address="127.0.0.1")
    driver = [sys.executable, HERE.parent.parent / "builder/cluster/ray/build.py", "--address", cluster.address]
    driver += ["--shards", "8", "--parts", parts, "--index", merged, *OPTIONS]
    build = subprocess.Popen(list(map(str, driver)))

    raylet = second.all_processes["raylet"][0].process.pid
    head = cluster.head_node.all_processes["raylet"][0].process.pid
    os.kill(wait_for_worker(head), signal.SIGKILL)
    print("killed a worker", flush=True)
    lost = wait_for_worker(raylet)
    cluster.remove_node(second, allow_graceful=False)
    try:
        os.kill(lost, signal.SIGKILL)  # With the node's power, everything on it goes.
    except ProcessLookupError:
        pass
    print("killed a node", flush=True)
    if build.wait(timeout=600) != 0:
        sys.exit("FAILED: the build on the cluster")
    cluster.shutdown()

    subprocess.run(["grasp-builder", "build", "--out", single, *OPTIONS], check=True, stdout=subprocess.DEVNULL)
    if not filecmp.cmp(single, merged, shallow=False):
        sys.exit("FAILED: the index has other bytes than a single build")
    names = sorted(file.name for file in parts.iterdir())
    if names != [f"{i}-of-8.shard" for i in range(1, 9)]:
        sys.exit(f"FAILED: files left: {names}")


if __name__ == "__main__":
    main()
