"""What a library must be able to do to take part."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

Setting = dict[str, Any]
"""One point of the sweep: the search parameters that a library is given, by its own names."""


@dataclass(frozen=True)
class Run:
    """What every contender is told. It crosses to the worker processes as JSON, so plain values only."""

    base: str
    """Path of the vectors to index, float32 (N, D) in C order."""
    queries: str
    """Path of the queries, float32 (Q, D) in C order."""
    n: int
    dim: int
    k: int = 10
    seed: int = 1
    build_threads: int = 1
    binaries: str = ""
    """Folder of grasp-builder and grasp-query; empty: the PATH."""
    held_out: str = ""
    """Path of queries that our own index measures its search by; empty: by its own rows."""

    def base_vectors(self) -> np.ndarray:
        return np.load(self.base)


class Contender:
    """One library with one way of building its index. Searching has settings; building has none.

    A subclass is a row of the table. What was tried and left out is said where the choice is made.
    """

    name: str
    """How `--only` and `--skip` call it."""
    title: str
    """How the table calls it."""
    package: str
    """The distribution whose version is reported."""
    needs_vectors = False
    """Whether `load` needs the vectors beside what `build` saved; they then count as part of the index on disk."""

    ours = False
    """Whether it is this project, which has no version that tells one build from the next."""

    predicted: float | None = None
    """The recall that the last search was said to find, of a contender that says so."""

    def parameters(self, run: Run) -> str:
        """How the index is built, for the table; indexes on disk are kept apart by it."""
        return ""

    def prepare(self) -> None:
        """Imports the library; apart from `load`, so that its code does not count as the index's memory."""

    def build(self, run: Run, folder: Path) -> None:
        """Builds from `run.base` and saves into `folder`, which exists and is empty."""
        raise NotImplementedError

    def load(self, run: Run, folder: Path) -> None:
        """Opens what `build` saved, for searching with one thread."""
        raise NotImplementedError

    def settings(self, run: Run) -> list[Setting]:
        """The sweep, cheapest first."""
        raise NotImplementedError

    def search(self, queries: np.ndarray, k: int, setting: Setting) -> np.ndarray:
        """The row numbers of the k nearest found, (Q, k); -1 where fewer were found."""
        raise NotImplementedError

    def time_search(
        self, run: Run, queries: np.ndarray, setting: Setting, repeats: int
    ) -> tuple[float, np.ndarray] | None:
        """Median nanoseconds a query over `repeats` and the ids, where the library times itself; else None."""
        return None


def widths(*values: int, least: int = 0) -> list[int]:
    """The values of a search width that are not below `least`, which most libraries refuse."""
    return [value for value in values if value >= least]


def hnsw_size(n: int) -> tuple[int, int]:
    """Edges a node, and the width of the search that chooses them, of every library with an HNSW graph.

    The usual 16 and 200 are the faster at thousands of vectors. At half a million of these, which lie in tight
    clusters (the views of one hand), such a graph stops at a recall of 0.95 however wide the search; twice the
    size does not.
    """
    return (16, 200) if n < 50_000 else (32, 500)
