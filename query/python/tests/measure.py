"""How much Python costs: `Index.search` beside `grasp-query search` on the same vectors.

    GRASP_PROGRAMS=target/release target/python/venv/bin/python query/python/tests/measure.py

prints the processor's time on one thread in microseconds a query: batches of 1,000 by both, and
queries one by one; medians of interleaved rounds. Both must be release builds. Time that other
programs take does not count, what they do to the caches does.
"""

from __future__ import annotations

import os
import resource
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy

import grasp

ENTRIES, DIM, QUERIES, ROUNDS = 100_000, 84, 1_000, 9
# Batches of the program in a round, so many that its start does not count; and before, to warm up.
BATCHES, BEFORE = 200, 10


def data() -> tuple[numpy.ndarray, numpy.ndarray]:
    """Vectors around 1,000 places, and queries near some of them."""
    random = numpy.random.default_rng(0)
    places = random.normal(size=(1_000, DIM))
    vectors = places[random.integers(1_000, size=ENTRIES)] + 0.4 * random.normal(size=(ENTRIES, DIM))
    queries = vectors[:: ENTRIES // QUERIES] + 0.1 * random.normal(size=(QUERIES, DIM))
    return vectors.astype(numpy.float32), queries.astype(numpy.float32)


def own(work: Callable[[], object]) -> float:
    """Seconds of this thread."""
    started = time.thread_time()
    work()
    return time.thread_time() - started


def program(command: list[str], rounds: int) -> float:
    """Seconds of a program that searches so many times."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([*command, "--rounds", str(rounds)], stdout=subprocess.DEVNULL, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    vectors, queries = data()
    with tempfile.TemporaryDirectory() as folder:
        path, asked = Path(folder) / "x.idx", Path(folder) / "q.npy"
        index = grasp.build(vectors, path)
        numpy.save(asked, queries)
        command = [os.path.join(os.environ["GRASP_PROGRAMS"], "grasp-query"), "search", str(asked)]
        command += ["--index", str(path), "--threads", "1", "--out", str(Path(folder) / "ids.npy")]
        rounds: dict[str, list[float]] = {"grasp-query": [], "batch": [], "one by one": []}
        index.search(queries)
        for _ in range(ROUNDS):
            searched = program(command, BATCHES + BEFORE) - program(command, BEFORE)
            rounds["grasp-query"].append(searched / BATCHES)
            for _ in range(BEFORE):
                index.search(queries, threads=1)
            batches = own(lambda: [index.search(queries, threads=1) for _ in range(BATCHES)])
            rounds["batch"].append(batches / BATCHES)
            singles = list(queries)
            rounds["one by one"].append(own(lambda: [index.search(query, threads=1) for query in singles]))
    for name, seconds in rounds.items():
        print(f"{name:12} {statistics.median(seconds) / QUERIES * 1e6:6.2f} us a query")


if __name__ == "__main__":
    main()
