"""FAISS: exact scan, inverted files with whole and with quantised vectors, HNSW.

Batches go in one call with one OpenMP thread. The wheel chooses AVX2 or AVX-512 kernels at run time by itself.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .contender import Contender, Run, Setting, hnsw_size, widths

FILE = "faiss.index"


class Faiss(Contender):
    package = "faiss-cpu"

    def prepare(self) -> None:
        import faiss

        self.faiss = faiss

    def parameters(self, run: Run) -> str:
        return self.factory(run)

    def factory(self, run: Run) -> str:
        """The index in the words of `faiss.index_factory`."""
        raise NotImplementedError

    def tune_build(self, index, run: Run) -> None:
        """Sets what the factory's words cannot say."""

    def build(self, run: Run, folder: Path) -> None:
        faiss = self.faiss
        faiss.omp_set_num_threads(run.build_threads)
        base = run.base_vectors()
        index = faiss.index_factory(run.dim, self.factory(run), faiss.METRIC_L2)
        self.tune_build(index, run)
        index.train(base)
        index.add(base)
        faiss.write_index(index, str(folder / FILE))

    def load(self, run: Run, folder: Path) -> None:
        self.faiss.omp_set_num_threads(1)
        self.index = self.faiss.read_index(str(folder / FILE))

    def set(self, setting: Setting) -> None:
        """Hands a setting to the index."""

    def search(self, queries: np.ndarray, k: int, setting: Setting) -> np.ndarray:
        self.set(setting)
        return self.index.search(queries, k)[1]


class Flat(Faiss):
    name, title = "faiss-flat", "FAISS exact"

    def factory(self, run: Run) -> str:
        return "Flat"

    def settings(self, run: Run) -> list[Setting]:
        return [{}]


def lists(n: int, share: float) -> int:
    """`share` times sqrt(n) inverted lists; FAISS advises 4 to 16, fewer win where a batch is short of work."""
    return max(8, int(share * n**0.5))


class Ivf(Faiss):
    """Inverted lists; a subclass says what is kept in them."""

    def __init__(self, share: float) -> None:
        self.share = share

    def tune_build(self, index, run: Run) -> None:
        clustering = self.faiss.extract_index_ivf(index).cp
        clustering.seed = run.seed
        # 64 training vectors a list are enough for lists (the least that FAISS takes without a warning is 39);
        # the default of 256 takes four times as long at millions of vectors.
        clustering.max_points_per_centroid = 256 if run.n < 1_000_000 else 64

    def probes(self, run: Run) -> list[int]:
        grid = (1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 28, 32, 40, 48, 64, 96, 128)
        return [value for value in grid if value <= lists(run.n, self.share)]


class IvfFlat(Ivf):
    def __init__(self, share: float) -> None:
        super().__init__(share)
        self.name = f"faiss-ivf-{share:g}"
        self.title = "FAISS IVF-Flat"

    def factory(self, run: Run) -> str:
        return f"IVF{lists(run.n, self.share)},Flat"

    def settings(self, run: Run) -> list[Setting]:
        return [{"nprobe": probes} for probes in self.probes(run)]

    def set(self, setting: Setting) -> None:
        self.index.nprobe = setting["nprobe"]


class IvfPqFastScan(Ivf):
    """4-bit codes of two dimensions each, scanned by byte shuffles, the best re-ranked with the whole vectors.

    Codes of the residuals are the better ones, codes of the vectors need one set of tables a query.
    """

    title = "FAISS IVF-PQFastScan, refined"

    def __init__(self, share: float, residuals: bool) -> None:
        super().__init__(share)
        self.residuals = residuals
        self.name = f"faiss-pq-{'residuals' if residuals else 'vectors'}"

    def factory(self, run: Run) -> str:
        return f"IVF{lists(run.n, self.share)},PQ{run.dim // 2}x4fs{'r' if self.residuals else ''},RFlat"

    def settings(self, run: Run) -> list[Setting]:
        return [{"nprobe": p, "k_factor": f} for f in (2, 4, 6, 8, 12, 20, 40) for p in self.probes(run)]

    def set(self, setting: Setting) -> None:
        self.faiss.extract_index_ivf(self.index).nprobe = setting["nprobe"]
        self.index.k_factor = setting["k_factor"]


class Hnsw(Faiss):
    name, title = "faiss-hnsw", "FAISS HNSW"

    def parameters(self, run: Run) -> str:
        return "M {}, efConstruction {}".format(*hnsw_size(run.n))

    def factory(self, run: Run) -> str:
        return f"HNSW{hnsw_size(run.n)[0]},Flat"

    def tune_build(self, index, run: Run) -> None:
        index.hnsw.efConstruction = hnsw_size(run.n)[1]

    def settings(self, run: Run) -> list[Setting]:
        return [
            {"efSearch": ef}
            for ef in widths(10, 12, 14, 16, 20, 24, 28, 32, 40, 48, 64, 80, 96, 128, 192, 256)
        ]

    def set(self, setting: Setting) -> None:
        self.index.hnsw.efSearch = setting["efSearch"]
