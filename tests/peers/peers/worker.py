"""The process of one contender: `python -m peers.worker NAME RUN-JSON`, driven by lines of JSON on its pipes.

A request is `{"do": "build" | "load" | "search", ...}`, the answer one line, with `error` where it failed.
Libraries print what they like: the answers go through a descriptor of their own, and standard output to the log.
"""

from __future__ import annotations

import json
import os
import statistics
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from .contender import Contender, Run
from .libraries import contenders

BUDGET_S = 2.0
"""A setting slower than this for all queries is not repeated within a round."""


def resident_bytes() -> int:
    with open("/proc/self/statm") as numbers:
        return int(numbers.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


class Worker:
    def __init__(self, contender: Contender, run: Run) -> None:
        self.contender, self.run = contender, run
        contender.prepare()

    def build(self, folder: str) -> dict[str, Any]:
        started = time.perf_counter()
        self.contender.build(self.run, Path(folder))
        return {"seconds": time.perf_counter() - started}

    def load(self, folder: str, core: int) -> dict[str, Any]:
        os.sched_setaffinity(0, {core})
        self.queries = np.ascontiguousarray(np.load(self.run.queries), dtype=np.float32)
        before = resident_bytes()
        started = time.perf_counter()
        self.contender.load(self.run, Path(folder))
        return {"seconds": time.perf_counter() - started, "bytes": max(0, resident_bytes() - before)}

    def search(self, setting: dict[str, Any], repeats: int, out: str) -> dict[str, Any]:
        timed = self.contender.time_search(self.run, self.queries, setting, repeats)
        if timed is None:
            timed = self.measure(setting, repeats)
        nanoseconds, ids = timed
        if out:
            np.save(out, np.asarray(ids, dtype=np.int64))
        return {"ns": nanoseconds, "predicted": self.contender.predicted}

    def measure(self, setting: dict[str, Any], repeats: int) -> tuple[float, np.ndarray]:
        """Median nanoseconds a query of `repeats` batches of all queries, and the ids of the last one."""
        times: list[int] = []
        while len(times) < repeats and sum(times) < BUDGET_S * 1e9:
            started = time.perf_counter_ns()
            ids = self.contender.search(self.queries, self.run.k, setting)
            times.append(time.perf_counter_ns() - started)
        return statistics.median(times) / len(self.queries), ids


def main() -> None:
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    name, run = sys.argv[1], Run(**json.loads(sys.argv[2]))
    worker: Worker | None = None
    for line in sys.stdin:
        request = json.loads(line)
        try:
            if worker is None:
                worker = Worker(contenders()[name], run)
            answer = getattr(worker, request.pop("do"))(**request)
        except ModuleNotFoundError as error:
            answer = {"error": f"{error}: see requirements.txt and, for grasp, README.md"}
        except Exception as error:  # whatever a library throws is its result, not this program's end
            answer = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(answer), file=answers, flush=True)


if __name__ == "__main__":
    main()
