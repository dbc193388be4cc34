"""The graph libraries: hnswlib, USearch, Glass, SymphonyQG, SVS."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .contender import Contender, Run, Setting, hnsw_size, widths

EF = (10, 12, 14, 16, 20, 24, 28, 32, 40, 48, 64, 80, 96, 128, 192, 256)
"""Widths of a graph's search. All of these libraries want at least k."""


class HnswLib(Contender):
    name, title, package = "hnswlib", "hnswlib", "hnswlib"

    def parameters(self, run: Run) -> str:
        return "M {}, ef_construction {}".format(*hnsw_size(run.n))

    def prepare(self) -> None:
        import hnswlib

        self.hnswlib = hnswlib

    def build(self, run: Run, folder: Path) -> None:
        links, width = hnsw_size(run.n)
        index = self.hnswlib.Index(space="l2", dim=run.dim)
        index.init_index(max_elements=run.n, M=links, ef_construction=width, random_seed=run.seed)
        index.add_items(run.base_vectors(), num_threads=run.build_threads)
        index.save_index(str(folder / "hnswlib.index"))

    def load(self, run: Run, folder: Path) -> None:
        self.index = self.hnswlib.Index(space="l2", dim=run.dim)
        self.index.load_index(str(folder / "hnswlib.index"))
        self.index.set_num_threads(1)

    def settings(self, run: Run) -> list[Setting]:
        return [{"ef": ef} for ef in widths(*EF, least=run.k)]

    def search(self, queries: np.ndarray, k: int, setting: Setting) -> np.ndarray:
        self.index.set_ef(setting["ef"])
        return self.index.knn_query(queries, k=k, num_threads=1)[0]


class USearch(Contender):
    package = "usearch"

    def __init__(self, dtype: str) -> None:
        self.dtype = dtype
        self.name, self.title = f"usearch-{dtype}", f"USearch {dtype}"

    def parameters(self, run: Run) -> str:
        return "connectivity {}, expansion_add {}".format(*hnsw_size(run.n))

    def prepare(self) -> None:
        from usearch.index import Index

        self.Index = Index

    def build(self, run: Run, folder: Path) -> None:
        links, width = hnsw_size(run.n)
        index = self.Index(
            ndim=run.dim, metric="l2sq", dtype=self.dtype, connectivity=links, expansion_add=width
        )
        index.add(np.arange(run.n), run.base_vectors(), threads=run.build_threads)
        index.save(str(folder / "usearch.index"))

    def load(self, run: Run, folder: Path) -> None:
        self.index = self.Index.restore(str(folder / "usearch.index"))

    def settings(self, run: Run) -> list[Setting]:
        return [{"expansion_search": ef} for ef in widths(*EF, least=run.k)]

    def search(self, queries: np.ndarray, k: int, setting: Setting) -> np.ndarray:
        self.index.expansion_search = setting["expansion_search"]
        keys = self.index.search(queries, k, threads=1).keys
        # Missing neighbours have the greatest 64-bit key; as a signed number that is -1.
        return np.asarray(keys).reshape(len(queries), -1).astype(np.int64)


class Glass(Contender):
    """Glass' graph with 8-bit codes, re-ranked with float32 vectors.

    Its half-precision vectors are left out: they reach a recall of 0.87 on these data, however wide the search.
    """

    name, title, package = "glass", "Glass HNSW SQ8U, refined", "pyglass-portable"
    needs_vectors = True

    def parameters(self, run: Run) -> str:
        return "R {}, L {}".format(*hnsw_size(run.n))

    def prepare(self) -> None:
        import glass

        self.glass = glass

    def build(self, run: Run, folder: Path) -> None:
        self.glass.set_num_threads(run.build_threads)
        links, width = hnsw_size(run.n)
        index = self.glass.Index("HNSW", "L2", "FP32", R=links, L=width)
        index.build(run.base_vectors()).save(str(folder / "glass.graph"))

    def load(self, run: Run, folder: Path) -> None:
        self.glass.set_num_threads(1)
        graph = self.glass.Graph(str(folder / "glass.graph"))
        # The graph alone is saved; the codes are made anew at every start.
        self.searcher = self.glass.Searcher(graph, run.base_vectors(), "L2", "SQ8U", "FP32")
        self.searcher.optimize(1)

    def settings(self, run: Run) -> list[Setting]:
        # It re-ranks one and a half times as many as asked for: to ask for more pays where recall must be high.
        return [{"ef": ef, "ask": ask} for ask in (run.k, 2 * run.k) for ef in widths(*EF, least=ask)]

    def search(self, queries: np.ndarray, k: int, setting: Setting) -> np.ndarray:
        self.searcher.set_ef(setting["ef"])
        found = self.searcher.batch_search(queries, setting["ask"], 1)
        ids = found[0] if isinstance(found, tuple) else found
        return np.asarray(ids).reshape(len(queries), -1)[:, :k]


class SymphonyQg(Contender):
    name, title, package = "symphonyqg", "SymphonyQG", "rabitqlib"
    degree, width = 32, 400

    def parameters(self, run: Run) -> str:
        return f"degree {self.degree}, ef_construction {self.width}"

    def prepare(self) -> None:
        import rabitqlib

        self.rabitqlib = rabitqlib

    def build(self, run: Run, folder: Path) -> None:
        index = self.rabitqlib.SymqgIndex(run.dim, self.degree, "l2")
        index.build(run.base_vectors(), self.width, num_threads=run.build_threads)
        index.save(str(folder / "symphonyqg.index"))

    def load(self, run: Run, folder: Path) -> None:
        self.index = self.rabitqlib.SymqgIndex.load(str(folder / "symphonyqg.index"))

    def settings(self, run: Run) -> list[Setting]:
        return [{"ef": ef} for ef in widths(*EF, least=run.k)]

    def search(self, queries: np.ndarray, k: int, setting: Setting) -> np.ndarray:
        ids = self.index.search_batch(queries, k, setting["ef"], num_threads=1)[0]
        return np.asarray(ids).astype(np.int64)


class Svs(Contender):
    """SVS' Vamana graph. Its compressed vectors (LVQ, LeanVec) refuse to run on other than Intel processors."""

    name, title, package = "svs", "SVS Vamana", "scalable-vs"
    dtype, degree, width = "float16", 32, 400

    def parameters(self, run: Run) -> str:
        return f"{self.dtype}, degree {self.degree}, window {self.width}"

    def prepare(self) -> None:
        import svs

        self.svs = svs

    def build(self, run: Run, folder: Path) -> None:
        parameters = self.svs.VamanaBuildParameters(
            alpha=1.2, graph_max_degree=self.degree, window_size=self.width
        )
        vectors = run.base_vectors().astype(self.dtype)
        index = self.svs.Vamana.build(parameters, vectors, self.svs.L2, num_threads=run.build_threads)
        index.save(*(str(folder / part) for part in ("config", "graph", "data")))

    def load(self, run: Run, folder: Path) -> None:
        svs = self.svs
        data = svs.VectorDataLoader(str(folder / "data"), getattr(svs, self.dtype), dims=run.dim)
        graph = svs.GraphLoader(str(folder / "graph"))
        self.index = svs.Vamana(str(folder / "config"), graph, data, svs.L2, num_threads=1)

    def settings(self, run: Run) -> list[Setting]:
        return [{"search_window_size": window} for window in widths(*EF, least=run.k)]

    def search(self, queries: np.ndarray, k: int, setting: Setting) -> np.ndarray:
        self.index.search_window_size = setting["search_window_size"]
        return self.index.search(queries, k)[0].astype(np.int64)
