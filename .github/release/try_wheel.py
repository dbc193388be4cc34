"""The installed package builds an index and finds in it what is there."""

import tempfile
from pathlib import Path

import grasp
import numpy

vectors = numpy.random.default_rng(0).normal(size=(2_000, 16)).astype("float32")
with tempfile.TemporaryDirectory() as folder, grasp.build(vectors, Path(folder) / "x.idx") as index:
    ids, distances = index.search(vectors, k=1, exact=True)
    assert (ids[:, 0] == numpy.arange(len(vectors))).all() and (distances < 1e-3).all()
print(f"{grasp.__file__}: {len(vectors):,} vectors found")
