"""grasp as an algorithm of ann-benchmarks: lies there as ann_benchmarks/algorithms/grasp/module.py."""

import os
import tempfile

import grasp
import numpy

from ..base.module import BaseANN


class Grasp(BaseANN):
    """An index that is asked for a recall and looks up by itself what effort that takes.

    Its distances are Euclidean. Between vectors of length 1 these put neighbours in the same order as angles.
    """

    def __init__(self, metric, originals):
        """`originals`: what exact distances are measured by, `f32`, `f16`, or `none`: by codes alone."""
        if metric not in ("euclidean", "angular"):
            raise NotImplementedError(f"grasp has no metric {metric!r}: euclidean or angular")
        self._is_angular, self._originals = metric == "angular", originals
        self._index = self._folder = self._found = None
        self._recall = 0.95
        self.name = f"grasp ({originals})"

    def fit(self, X):
        self.done()
        self._folder = tempfile.TemporaryDirectory()
        path = os.path.join(self._folder.name, "grasp.idx")
        self._index = grasp.build(self._placed(X), path, originals=self._originals)

    def set_query_arguments(self, recall):
        """`recall`: the share of the true neighbours that a search is asked for, above 0 and not above 1."""
        self._recall = recall
        self.name = f"grasp ({self._originals}, recall {recall:g})"

    def query(self, q, n):
        ids, _ = self._index.search(self._placed(q), n, self._recall, threads=1)
        return ids[ids >= 0]

    def batch_query(self, X, n):
        self._found, _ = self._index.search(self._placed(X), n, self._recall)

    def get_batch_results(self):
        return [ids[ids >= 0] for ids in self._found]

    def get_additional(self):
        return {"recall_asked": self._recall, "index_bytes": os.path.getsize(self._index.path)}

    def done(self):
        if self._index is not None:
            self._index.close()
            self._folder.cleanup()
            self._index = self._folder = None

    def _placed(self, vectors):
        vectors = numpy.ascontiguousarray(vectors, dtype=numpy.float32)
        if not self._is_angular:
            return vectors
        lengths = numpy.linalg.norm(vectors, axis=-1, keepdims=True)
        return vectors / numpy.where(lengths > 0, lengths, 1)
