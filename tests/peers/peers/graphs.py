"""The graph libraries: hnswlib, USearch, Glass, SymphonyQG, SVS."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .contender import Contender, Run, Setting, widths

EF = (10, 12, 14, 16, 20, 24, 28, 32, 40, 48, 64, 80, 96, 128, 192, 256)
"""Widths of a graph's search. All of these libraries want at least k."""


LINKS, WIDTH = 32, 500
"""Edges a node and width of the search that chooses them, of all libraries with an HNSW graph.

The usual 16 and 200 build twice as fast, and stop at a recall of 0.95 at half a million of these vectors, which lie in
tight clusters: views of one hand."""


class HnswLib(Contender):
    package = "hnswlib"

    def __init__(self, links: int = LINKS, width: int = WIDTH) -> None:
        self.links, self.width = links, width
        self.name, self.title = "hnswlib", f"hnswlib (M {links}, ef_construction {width})"

    def prepare(self) -> None:
        import hnswlib

        self.hnswlib = hnswlib

    def build(self, run: Run, folder: Path) -> None:
        index = self.hnswlib.Index(space="l2", dim=run.dim)
        index.init_index(max_elements=run.n, M=self.links, ef_construction=self.width, random_seed=run.seed)
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

    def __init__(self, dtype: str, links: int = LINKS, width: int = WIDTH) -> None:
        self.dtype, self.links, self.width = dtype, links, width
        self.name = f"usearch-{dtype}"
        self.title = f"USearch {dtype} (connectivity {links}, expansion_add {width})"

    def prepare(self) -> None:
        from usearch.index import Index

        self.Index = Index

    def build(self, run: Run, folder: Path) -> None:
        index = self.Index(
            ndim=run.dim,
            metric="l2sq",
            dtype=self.dtype,
            connectivity=self.links,
            expansion_add=self.width,
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

    package = "pyglass-portable"
    needs_vectors = True

    def __init__(self, links: int = LINKS, width: int = WIDTH) -> None:
        self.links, self.width = links, width
        self.name, self.title = "glass", f"Glass HNSW SQ8U, refined (R {links}, L {width})"

    def prepare(self) -> None:
        import glass

        self.glass = glass

    def build(self, run: Run, folder: Path) -> None:
        self.glass.set_num_threads(run.build_threads)
        index = self.glass.Index("HNSW", "L2", "FP32", R=self.links, L=self.width)
        index.build(run.base_vectors()).save(str(folder / "glass.graph"))

    def load(self, run: Run, folder: Path) -> None:
        self.glass.set_num_threads(1)
        graph = self.glass.Graph(str(folder / "glass.graph"))
        # The graph alone is saved; the codes are made anew at every start.
        self.searcher = self.glass.Searcher(graph, run.base_vectors(), "L2", "SQ8U", "FP32")
        self.searcher.optimize(1)

    def settings(self, run: Run) -> list[Setting]:
        # Only one and a half times as many as asked for are re-ranked, so asking for more pays where recall must be high.
        return [{"ef": ef, "ask": ask} for ask in (run.k, 2 * run.k) for ef in widths(*EF, least=ask)]

    def search(self, queries: np.ndarray, k: int, setting: Setting) -> np.ndarray:
        self.searcher.set_ef(setting["ef"])
        found = self.searcher.batch_search(queries, setting["ask"], 1)
        ids = found[0] if isinstance(found, tuple) else found
        return np.asarray(ids).reshape(len(queries), -1)[:, :k]


class SymphonyQg(Contender):
    package = "rabitqlib"

    def __init__(self, degree: int = 32, width: int = 400) -> None:
        self.degree, self.width = degree, width
        self.name, self.title = "symphonyqg", f"SymphonyQG (degree {degree}, ef_construction {width})"

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

    package = "scalable-vs"

    def __init__(self, dtype: str = "float16", degree: int = 32, width: int = 400) -> None:
        self.dtype, self.degree, self.width = dtype, degree, width
        self.name, self.title = "svs", f"SVS Vamana {dtype} (degree {degree}, window {width})"

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
