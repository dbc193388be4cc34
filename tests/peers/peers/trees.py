"""The libraries that partition space: Annoy and ScaNN."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .contender import Contender, Run, Setting


class Annoy(Contender):
    name, title, package = "annoy", "Annoy", "annoy"
    trees = 100

    def parameters(self, run: Run) -> str:
        return f"{self.trees} trees, one call a query"

    def prepare(self) -> None:
        from annoy import AnnoyIndex

        self.AnnoyIndex = AnnoyIndex

    def build(self, run: Run, folder: Path) -> None:
        index = self.AnnoyIndex(run.dim, "euclidean")
        index.set_seed(run.seed)
        for row, vector in enumerate(run.base_vectors()):
            index.add_item(row, vector)
        index.build(self.trees, n_jobs=run.build_threads)
        index.save(str(folder / "annoy.index"))

    def load(self, run: Run, folder: Path) -> None:
        self.index = self.AnnoyIndex(run.dim, "euclidean")
        self.index.load(str(folder / "annoy.index"), prefault=True)

    def settings(self, run: Run) -> list[Setting]:
        return [
            {"search_k": s} for s in (200, 400, 700, 1000, 1500, 2000, 3000, 5000, 8000, 12000, 20000, 40000)
        ]

    def search(self, queries: np.ndarray, k: int, setting: Setting) -> np.ndarray:
        find, search_k = self.index.get_nns_by_vector, setting["search_k"]
        ids = np.full((len(queries), k), -1, dtype=np.int64)
        for row, query in enumerate(queries):
            found = find(query, k, search_k)
            ids[row, : len(found)] = found
        return ids


class ScaNN(Contender):
    """Tree, 4-bit codes and re-ranking.

    SOAR and codes of residuals are for inner products only, so that many must be re-ranked at this distance.
    """

    name, title, package = "scann", "ScaNN", "scann"

    def parameters(self, run: Run) -> str:
        return f"{self.leaves(run.n)} leaves, 2 dimensions a code"

    def leaves(self, n: int) -> int:
        return max(8, int(2 * n**0.5))

    def prepare(self) -> None:
        from scann import scann_ops_pybind

        self.scann = scann_ops_pybind

    def build(self, run: Run, folder: Path) -> None:
        leaves = self.leaves(run.n)
        builder = self.scann.builder(run.base_vectors(), run.k, "squared_l2")
        builder.set_n_training_threads(run.build_threads)
        builder.tree(leaves, max(1, leaves // 20), training_sample_size=min(run.n, 250_000))
        builder.score_ah(2, anisotropic_quantization_threshold=float("nan"))
        builder.reorder(100)
        builder.build().serialize(str(folder), relative_path=True)

    def load(self, run: Run, folder: Path) -> None:
        self.searcher = self.scann.load_searcher(str(folder))

    def settings(self, run: Run) -> list[Setting]:
        leaves = (1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 30, 50)
        reorder = (20, 30, 50, 80, 120, 200, 300, 500, 800)
        return [{"leaves": leaf, "reorder": again} for again in reorder for leaf in leaves]

    def search(self, queries: np.ndarray, k: int, setting: Setting) -> np.ndarray:
        ids, _ = self.searcher.search_batched(
            queries, k, pre_reorder_num_neighbors=setting["reorder"], leaves_to_search=setting["leaves"]
        )
        return np.asarray(ids).astype(np.int64)
