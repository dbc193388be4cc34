"""Times this project's index against other libraries on the same vectors: those of an index, or two arrays. See
README.md."""

from __future__ import annotations

import argparse
import dataclasses
import os
import signal
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import report
import truth
import vectors
from peers import cold, rounds
from peers.contender import Run
from peers.libraries import contenders
from peers.pool import Failed, Store

EXAMPLES = """\
examples:
  bench.py grasp.idx --work peers-work --binaries ../../target/release --csv points.csv
  bench.py grasp.idx --work peers-work --entries 5000 --only grasp,faiss-ivf,hnswlib --rounds 2
  bench.py base.npy queries.npy --work peers-work --skip annoy --recall-levels .9,.99
"""


def names(text: str) -> list[str]:
    """A comma-separated list; a name stands for all contenders that begin with it."""
    every = list(contenders())
    chosen = []
    for name in text.split(","):
        found = [one for one in every if one == name or one.startswith(f"{name}-")]
        if not found:
            raise argparse.ArgumentTypeError(f"no contender {name!r}; there are {', '.join(every)}")
        chosen += found
    return chosen


def shares(text: str) -> list[float]:
    try:
        values = [float(value) for value in text.split(",")]
    except ValueError:
        values = [0.0]
    if not all(0 < value <= 1 for value in values):
        raise argparse.ArgumentTypeError("comma-separated levels, above 0 and not above 1")
    return values


def positive(text: str) -> int:
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"a whole number, at least 1, in place of {text!r}")
    return int(text)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "data",
        nargs="+",
        metavar="GRASP.idx | BASE.npy QUERIES.npy",
        help="an index of this project, whose entries are indexed; or the vectors to index and the queries, float32",
    )
    parser.add_argument(
        "--pictures",
        type=Path,
        default=vectors.SAMPLES,
        metavar="LABELS.csv",
        help="with an index: the pictures that are searched for beside renders; default: the sample pictures",
    )
    parser.add_argument(
        "--entries",
        type=positive,
        metavar="N",
        help="with an index: take N of its entries, evenly; default: all",
    )
    parser.add_argument("--work", type=Path, required=True, help="folder that keeps truth and built indexes")
    parser.add_argument("--only", type=names, help="comma-separated contenders, or beginnings of their names")
    parser.add_argument("--skip", type=names, default=[], help="likewise")
    parser.add_argument("--k", type=positive, default=10)
    parser.add_argument("--eps", type=float, default=0.05)
    parser.add_argument("--recall-levels", type=shares, default=[0.9, 0.95, 0.99])
    parser.add_argument("--success-levels", type=shares, default=[0.95, 0.99])
    parser.add_argument("--rounds", type=positive, default=5)
    parser.add_argument("--repeats", type=positive, default=3, help="batches of all queries in a round")
    parser.add_argument("--cold-rounds", type=int, default=9, help="0 leaves the cold starts out")
    parser.add_argument(
        "--time-limit", type=float, default=3600, metavar="SECONDS", help="of a build, a load or a search"
    )
    parser.add_argument(
        "--core", type=int, help="where searches run; default: the last that this process may use"
    )
    parser.add_argument(
        "--build-threads", type=positive, help="default: every core that this process may use"
    )
    parser.add_argument("--in-turn", action="store_true", help="hold one index in memory at a time")
    parser.add_argument("--rebuild", action="store_true", help="do not use the indexes kept in --work")
    parser.add_argument(
        "--binaries", default="", help="folder of grasp-builder and grasp-query; default: the PATH"
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--csv", type=Path, help="every measured point goes here")
    given = parser.parse_args()
    if len(given.data) > 2 or (len(given.data) == 1 and given.data[0].endswith(".npy")):
        parser.error("name one index, or two arrays")
    if given.entries is not None and len(given.data) == 2:
        parser.error("--entries takes some of an index's entries: name an index, in place of two arrays")
    cores = sorted(os.sched_getaffinity(0))
    if given.core is None:
        given.core = cores[-1]
    elif given.core not in cores:
        parser.error(f"--core {given.core}: this process may use {', '.join(map(str, cores))}")
    return given


def checked_shape(path: str) -> tuple[int, int]:
    """The shape of a file of vectors; raises ValueError saying what is wrong with it."""
    try:
        array = np.load(path, mmap_mode="r")
    except ValueError:
        raise ValueError(f"{path}: no array; numpy.save writes one") from None
    if array.ndim != 2 or array.dtype != np.float32 or not array.flags.c_contiguous:
        raise ValueError(
            f"{path}: float32, two-dimensional, C order expected, {array.dtype} {array.shape} found"
        )
    return array.shape


def memory_is_short(n: int, dim: int, how_many: int) -> bool:
    """Whether all indexes at once might not fit: a graph takes about twice its vectors."""
    for text in Path("/proc/meminfo").read_text().splitlines():
        if text.startswith("MemAvailable:"):
            return how_many * n * (dim * 4 + 200) * 1.5 > int(text.split()[1]) * 1024
    return False


def say(text: str) -> None:
    print(f"{time.strftime('%H:%M:%S')} {text}", file=sys.stderr, flush=True)


def data(given: argparse.Namespace, work: Path) -> vectors.Vectors:
    """What is compared on."""
    if len(given.data) == 1:
        return vectors.of_index(given.data[0], given.pictures, work, given.binaries, given.entries)
    base, queries = (str(Path(path).resolve()) for path in given.data)
    dim = checked_shape(base)[1]
    return vectors.Vectors(base, {given.data[1]: queries}, held_out="", descriptor=f"D = {dim}")


def main() -> int:
    given = arguments()
    given.binaries = given.binaries and str(Path(given.binaries).resolve())
    try:
        given.work.mkdir(parents=True, exist_ok=True)
        work = given.work.resolve()
        if given.csv:
            # What cannot be written is said before an hour of measuring; nothing is written yet.
            given.csv.open("a").close()
        say("vectors")
        compared = data(given, work)
        n, dim = checked_shape(compared.base)
        for queries in compared.queries.values():
            q, query_dim = checked_shape(queries)
            if dim != query_dim or q == 0 or n < given.k:
                raise ValueError(
                    f"{n} x {dim} vectors and {q} x {query_dim} queries do not fit, or are fewer than k"
                )
    except (OSError, ValueError) as error:
        print(f"bench: {error}", file=sys.stderr)
        return 2
    run = Run(
        base=compared.base,
        queries="",
        n=n,
        dim=dim,
        k=given.k,
        seed=given.seed,
        build_threads=given.build_threads or len(os.sched_getaffinity(0)),
        binaries=given.binaries,
        held_out=compared.held_out,
    )
    store = Store(work, run, truth.file_hash(run.base))
    chosen = [one for one in contenders().values() if one.name in (given.only or contenders())]
    built = [rounds.Entry(one) for one in chosen if one.name not in given.skip]
    for entry in built:
        say(f"index: {entry.contender.name}")
        try:
            entry.built = store.built(entry.contender, given.time_limit, given.rebuild)
        except Failed as error:
            entry.failed = str(error)
            say(f"{entry.contender.name} did not run: {error}")
    levels = [("recall", level) for level in given.recall_levels]
    levels += [("eps_success", level) for level in given.success_levels]
    written: list[tuple[str, list[rounds.Entry]]] = []
    starts: dict[str, cold.Cold] = {}
    for title, queries in compared.queries.items():
        run = dataclasses.replace(run, queries=queries)
        say(f"truth: {title}")
        judge = truth.Judge(
            run.base, run.queries, truth.true_distances(run.base, run.queries, run.k, work), given.eps
        )
        entries = [rounds.Entry(one.contender, one.built, failed=one.failed) for one in built]
        with tempfile.TemporaryDirectory() as scratch:
            plan = rounds.Plan(
                run=run,
                levels=levels,
                rounds=given.rounds,
                repeats=given.repeats,
                core=given.core,
                limit=given.time_limit,
                in_turn=given.in_turn or memory_is_short(n, dim, len(entries)),
                scratch=Path(scratch),
            )
            rounds.hold(entries, plan, store, judge, say)
            if given.cold_rounds and not written:
                starts = cold.measure(entries, run, plan.core, given.cold_rounds, plan.scratch, say)
        if written:
            print()
        print(f"**{n:,} entries, {compared.descriptor}; queries: {title}**\n")
        print(report.table(entries, levels, starts, run))
        print()
        print(report.notes(entries, plan, checked_shape(queries)[0], given.eps))
        written.append((title, entries))
    if given.csv:
        with open(given.csv, "w", newline="") as stream:
            report.write_csv(written, stream)
    return 1 if any(entry.failed for _, entries in written for entry in entries) else 0


def interrupt(*_: object) -> None:
    raise KeyboardInterrupt


if __name__ == "__main__":
    # A termination ends the workers too: they have sessions of their own.
    signal.signal(signal.SIGTERM, interrupt)
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)
