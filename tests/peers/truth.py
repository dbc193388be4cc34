"""The true neighbours by brute force, and what an answer is worth against them."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

SLACK = 22
"""Candidates kept beyond k in single precision, so that its rounding cannot lose a true neighbour."""
SAMPLE = 20
"""Queries whose truth is measured again in double precision alone."""
TIE = 1e-6
"""A neighbour this share farther than the k-th is as good as the k-th."""


def file_hash(path: str | Path) -> str:
    """The first 12 hexadecimal digits of a file's hash."""
    with open(path, "rb") as stream:
        return hashlib.file_digest(stream, lambda: hashlib.blake2b(digest_size=6)).hexdigest()


def distances(base: np.ndarray, queries: np.ndarray, ids: np.ndarray) -> np.ndarray:
    """Euclidean distances in double precision, (Q, m), of the rows `ids` (Q, m); infinite where an id is no row."""
    known = (ids >= 0) & (ids < len(base))
    out = np.full(ids.shape, np.inf)
    for row in range(len(queries)):
        vectors = base[ids[row, known[row]]].astype(np.float64)
        out[row, known[row]] = np.sqrt(((vectors - queries[row].astype(np.float64)) ** 2).sum(axis=1))
    return out


def exact_distances(base: np.ndarray, query: np.ndarray, k: int, block: int = 65_536) -> np.ndarray:
    """The k least distances of one query, all in double precision."""
    best = np.empty(0)
    for start in range(0, len(base), block):
        difference = base[start : start + block].astype(np.float64) - query.astype(np.float64)
        best = np.sort(np.concatenate([best, (difference**2).sum(axis=1)]))[:k]
    return np.sqrt(best)


def nearest_in_single(base: np.ndarray, queries: np.ndarray, m: int) -> np.ndarray:
    """The ids of the m nearest by single-precision distances, (Q, m): FAISS' exact scan, or numpy without it."""
    try:
        import faiss

        return faiss.knn(np.ascontiguousarray(queries), np.ascontiguousarray(base), m)[1]
    except ImportError:
        return nearest_by_numpy(base, queries, m)


def nearest_by_numpy(base: np.ndarray, queries: np.ndarray, m: int, block: int = 16_384) -> np.ndarray:
    """As above, a block of the vectors at a time."""
    best_d = np.empty((len(queries), 0), dtype=np.float32)
    best_i = np.empty((len(queries), 0), dtype=np.int64)
    for start in range(0, len(base), block):
        part = base[start : start + block]
        d = (part**2).sum(axis=1) - 2 * queries @ part.T
        best_d = np.concatenate([best_d, d], axis=1)
        best_i = np.concatenate(
            [best_i, np.broadcast_to(np.arange(start, start + len(part)), d.shape)], axis=1
        )
        if best_d.shape[1] > m:
            keep = np.argpartition(best_d, m - 1, axis=1)[:, :m]
            best_d, best_i = np.take_along_axis(best_d, keep, 1), np.take_along_axis(best_i, keep, 1)
    return best_i


def true_distances(base_path: str, queries_path: str, k: int, work: Path) -> np.ndarray:
    """The k least distances of every query in double precision, (Q, k), ascending; kept in `work`.

    A sample is measured again by another way, and the program stops where the two disagree.
    """
    cached = work / f"truth-{file_hash(base_path)}-{file_hash(queries_path)}-{k}.npy"
    if cached.exists():
        return np.load(cached)
    base, queries = np.load(base_path), np.load(queries_path)
    m = min(len(base), k + SLACK)
    truth = np.sort(distances(base, queries, nearest_in_single(base, queries, m)), axis=1)[:, :k]
    for row in np.linspace(0, len(queries) - 1, min(SAMPLE, len(queries))).astype(int):
        if not np.allclose(truth[row], exact_distances(base, queries[row], k), rtol=1e-9, atol=1e-12):
            raise RuntimeError(f"the truth of query {row} differs between single and double precision")
    unfinished = cached.with_suffix(".part.npy")
    np.save(unfinished, truth)
    unfinished.rename(cached)
    return truth


@dataclass
class Score:
    """What a setting's answers are worth."""

    recall: float
    """Share of the true k nearest found; one as near as the k-th counts as found."""
    eps_success: float
    """Share of queries whose nearest answer is within (1 + eps) of the true nearest."""


class Judge:
    """Scores answers. Holds the base mapped, not loaded: a few rows a query are read."""

    def __init__(self, base_path: str, queries_path: str, truth: np.ndarray, eps: float) -> None:
        self.base = np.load(base_path, mmap_mode="r")
        self.queries = np.load(queries_path)
        self.truth, self.eps = truth, eps

    def score(self, ids: np.ndarray) -> Score:
        """Scores ids (Q, k). An id given twice for a query counts once."""
        k = self.truth.shape[1]
        if ids.shape != self.truth.shape:
            raise ValueError(f"{self.truth.shape} ids expected, {ids.shape} given")
        ids = np.sort(ids, axis=1)
        ids[:, 1:][ids[:, 1:] == ids[:, :-1]] = -1
        found = distances(self.base, self.queries, ids)
        hits = (found <= self.truth[:, -1:] * (1 + TIE)).sum(axis=1)
        near = found.min(axis=1) <= self.truth[:, 0] * (1 + self.eps)
        return Score(float(hits.mean() / k), float(near.mean()))
