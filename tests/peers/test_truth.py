"""`python -m unittest` here: the figures of the table rest on these two."""

import tempfile
import unittest
from pathlib import Path

import numpy as np

import truth


class Truth(unittest.TestCase):
    def setUp(self) -> None:
        rng = np.random.default_rng(3)
        base = rng.random((500, 12), dtype=np.float32)
        base[400:] = base[:100]  # every early row twice: ties everywhere
        self.base, self.queries = base, rng.random((40, 12), dtype=np.float32)
        self.folder = tempfile.TemporaryDirectory()
        self.paths = [str(Path(self.folder.name) / name) for name in ("base.npy", "queries.npy")]
        for path, array in zip(self.paths, (base, self.queries), strict=True):
            np.save(path, array)

    def tearDown(self) -> None:
        self.folder.cleanup()

    def test_distances_are_those_of_a_plain_scan(self) -> None:
        difference = self.base[None].astype(np.float64) - self.queries[:, None].astype(np.float64)
        plain = np.sort(np.sqrt((difference**2).sum(axis=2)), axis=1)[:, :10]
        for _ in range(2):  # measured, then kept
            found = truth.true_distances(*self.paths, 10, Path(self.folder.name))
            np.testing.assert_allclose(found, plain, rtol=1e-12)
        by_numpy = truth.nearest_by_numpy(self.base, self.queries, 32, block=77)
        found = np.sort(truth.distances(self.base, self.queries, by_numpy), axis=1)[:, :10]
        np.testing.assert_allclose(found, plain, rtol=1e-12)

    def judge(self) -> tuple[truth.Judge, np.ndarray]:
        k_distances = truth.true_distances(*self.paths, 10, Path(self.folder.name))
        ids = truth.nearest_by_numpy(self.base, self.queries, 12)
        order = np.argsort(truth.distances(self.base, self.queries, ids), axis=1, kind="stable")
        return truth.Judge(*self.paths, k_distances, 0.05), np.take_along_axis(ids, order, 1)[:, :10]

    def test_the_twin_of_a_neighbour_counts(self) -> None:
        judge, ids = self.judge()
        self.assertEqual(judge.score(ids.copy()), truth.Score(1.0, 1.0))
        twins = np.where(ids < 100, ids + 400, np.where(ids >= 400, ids - 400, ids))
        self.assertEqual(judge.score(twins), truth.Score(1.0, 1.0))

    def test_repeats_and_unknown_ids_do_not(self) -> None:
        judge, ids = self.judge()
        repeated = np.repeat(ids[:, :1], 10, axis=1)
        self.assertAlmostEqual(judge.score(repeated).recall, 0.1)
        for nowhere in (-1, 500):
            self.assertEqual(judge.score(np.full_like(ids, nowhere)), truth.Score(0.0, 0.0))


if __name__ == "__main__":
    unittest.main()
