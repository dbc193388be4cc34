"""Cold start: a whole process that starts, opens the saved index, answers one query and ends."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .contender import Run
from .ours import FILE, program
from .pool import HERE, THREAD_VARIABLES
from .rounds import Entry

SCRIPTS = {
    "faiss-ivf": "faiss",
    "faiss-hnsw": "faiss",
    "hnswlib": "hnswlib",
    "usearch": "usearch",
    "grasp-python": "grasp",
}
"""The contenders (by the start of the name) that have a script, and what it is told."""


@dataclass
class Cold:
    """Medians, in milliseconds."""

    whole: float
    """The process from its start to its end."""
    inside: float | None
    """Of that, opening and answering; the rest is the interpreter and its imports. None for a program of its own."""


def measure(
    entries: list[Entry], run: Run, core: int, rounds: int, scratch: Path, say: Callable[[str], None]
) -> dict[str, Cold]:
    """The cold starts of those that have one, interleaved; the files are in the page cache."""
    query = scratch / "one.npy"
    np.save(query, np.load(run.queries)[:1])
    calls = {}
    for entry in entries:
        if entry.built is not None and not entry.failed:
            call = command(entry, run, query)
            if call:
                calls[entry.contender.name] = call
    own = {name for name, call in calls.items() if call[0] != sys.executable}
    whole: dict[str, list[float]] = {name: [] for name in calls}
    inside: dict[str, list[float]] = {name: [] for name in calls}
    environment = {**os.environ, **{name: "1" for name in THREAD_VARIABLES}}
    cores = os.sched_getaffinity(0)
    # Children inherit it. A function of ours between fork and exec would copy this process's page tables: several ms.
    os.sched_setaffinity(0, {core})
    try:
        time_all(calls, own, environment, rounds, whole, inside, say)
    finally:
        os.sched_setaffinity(0, cores)
    return {
        name: Cold(statistics.median(whole[name]), statistics.median(inside[name]) if inside[name] else None)
        for name in calls
        if whole[name]
    }


def time_all(
    calls: dict[str, list[str]],
    own: set[str],
    environment: dict[str, str],
    rounds: int,
    whole: dict[str, list[float]],
    inside: dict[str, list[float]],
    say: Callable[[str], None],
) -> None:
    """Runs every call once a round, and appends what it took to `whole` and `inside`."""
    for number in range(rounds + 1):
        say(f"cold start {number} of {rounds}")
        for name, call in calls.items():
            started = time.perf_counter_ns()
            done = subprocess.run(
                call, check=False, stdin=subprocess.DEVNULL, capture_output=True, env=environment
            )
            took = (time.perf_counter_ns() - started) / 1e6
            if done.returncode != 0 or number == 0:  # round 0 fills the page cache
                continue
            whole[name].append(took)
            if name not in own:
                inside[name].append(json.loads(done.stdout)["ns"] / 1e6)


def command(entry: Entry, run: Run, query: Path) -> list[str]:
    """The command line of a contender's cold start; empty where it has none."""
    name, folder = entry.contender.name, entry.built.folder
    for start, library in SCRIPTS.items():
        if name.startswith(start):
            file = next(path for path in folder.iterdir() if path.suffix in (".index", ".idx"))
            return [
                sys.executable,
                "-s",
                str(HERE / "coldstart.py"),
                library,
                str(file),
                str(query),
                str(run.k),
            ]
    if entry.contender.ours:
        index = str(folder / FILE)
        return [program(run, "grasp-query"), "search", str(query), "--index", index, "--k", str(run.k)]
    return []
