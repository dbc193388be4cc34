"""What tests/cluster/ray_serve.sh runs in a network of its own: a folder to work in is its argument."""

import os
import pathlib
import signal
import subprocess
import sys
import time
import urllib.request

from ray.cluster_utils import Cluster

DRIVER = pathlib.Path(__file__).resolve().parents[2] / "builder/cluster/ray/serve.py"
SERVER = "http://127.0.0.1:8750"
EFFORTS = [[], ["--recall", "0.9"], ["--recall", "0.99"], ["--probes", "1", "--k", "60"], ["--exact", "--k", "30"]]


def program(*arguments, status=0):
    done = subprocess.run(list(map(str, arguments)), capture_output=True)
    if done.returncode != status:
        sys.exit(f"FAILED: {arguments}: {done.returncode}: {done.stderr.decode()}")
    return done.stdout if status == 0 else done.stderr.decode()


def below(ancestor):
    """The processes below a process."""
    tree = {}
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            parent = int((process / "stat").read_text().rsplit(")", 1)[1].split()[1])
            tree.setdefault(parent, []).append(int(process.name))
        except OSError:
            pass
    found, waiting = [], [ancestor]
    while waiting:
        children = tree.get(waiting.pop(), [])
        found += children
        waiting += children
    return found


def services(ancestor):
    """The segments' services below a process: their numbers by the segment's name."""
    found = {}
    for pid in below(ancestor):
        try:
            line = pathlib.Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
        except OSError:
            continue
        if line[0].endswith(b"grasp-query") and b"--index" in line:
            found[os.path.basename(line[line.index(b"--index") + 1].decode())] = pid
    return found


def wait_for_service(driver):
    end = time.monotonic() + 180
    while time.monotonic() < end and driver.poll() is None:
        try:
            with urllib.request.urlopen(f"{SERVER}/readyz") as answer:
                return answer.status
        except OSError:
            time.sleep(0.5)
    sys.exit("FAILED: the cluster does not come to serve")


def main():
    work = pathlib.Path(sys.argv[1])
    single, queries, folder = work / "single.idx", work / "q.npy", work / "segments"
    program("grasp-builder", "build", "--hands", 5, "--step", 30, "--thumbnails", 0, "--out", single)
    program("grasp-builder", "split", single, "--segments", 4, "--out-dir", folder)
    program("grasp-builder", "queries", "--preset", "paper", "--count", 150, "--out", queries)
    expected = [program("grasp-query", "search", queries, "--index", single, "--neighbours", *effort) for effort in EFFORTS]

    def compare(when):
        started = time.monotonic()
        for effort, answer in zip(EFFORTS, expected):
            if program("grasp-query", "search", queries, "--server", SERVER, "--neighbours", *effort) != answer:
                sys.exit(f"FAILED: {when}, the answers are others than the single index's ({effort})")
        print(f"{when}: the answers of the single index ({time.monotonic() - started:.1f} s)", flush=True)

    log = (work / "driver.log").open("w")
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 2, "node_ip_address": "127.0.0.1"})
    second = cluster.add_node(num_cpus=2, node_ip_address="127.0.0.1")
    segments = [folder / f"{at}-of-4.idx" for at in range(1, 5)]
    command = [sys.executable, DRIVER, *segments, "--address", cluster.address, "--patience", "40"]
    driver = subprocess.Popen(command, stdout=log, stderr=log)
    wait_for_service(driver)
    nodes = [node.all_processes["raylet"][0].process.pid for node in (cluster.head_node, second)]
    own, lost = map(services, nodes)
    print(f"segments on the first node: {sorted(own)}, on the second: {sorted(lost)}", flush=True)
    if len(own) + len(lost) != 4 or not own or not lost:
        sys.exit("FAILED: the segments are not on both nodes")
    compare("two nodes")

    os.kill(min(own.values()), signal.SIGKILL)
    compare("a service was killed")
    cluster.remove_node(second, allow_graceful=False)
    compare("a node was killed")
    if alive := [pid for pid in lost.values() if pathlib.Path(f"/proc/{pid}/cmdline").exists()]:
        sys.exit(f"FAILED: the lost node's services live on: {alive}")

    (folder / "3-of-4.idx").unlink()
    os.kill(services(nodes[0])["3-of-4.idx"], signal.SIGKILL)
    said = program("grasp-query", "search", queries, "--server", SERVER, "--neighbours", status=2)
    if "3 of 4 segments answer" not in said:
        sys.exit(f"FAILED: a missing segment is not told: {said}")
    request = urllib.request.Request(f"{SERVER}/v1/search?k=3&allow_missing=true", queries.read_bytes(), method="POST")
    with urllib.request.urlopen(request) as answer:
        lines, segments = answer.read().splitlines(), answer.headers["Grasp-Segments"]
    if segments != "3/4" or len(lines) != 150:
        sys.exit(f"FAILED: {segments} segments, {len(lines)} answers")
    print(f"a segment is missing: an error, or {segments}", flush=True)
    driver.terminate()
    driver.wait(timeout=60)
    cluster.shutdown()


if __name__ == "__main__":
    try:
        main()
    except BaseException:
        log = pathlib.Path(sys.argv[1]) / "driver.log"
        print(log.read_text()[-4000:] if log.exists() else "nothing was served", file=sys.stderr)
        raise
