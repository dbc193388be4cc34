"""The adapter for ann-benchmarks, in the place of that project's base class a stub."""

from __future__ import annotations

import importlib.util
import itertools
import sys
from types import ModuleType

import numpy
import pytest
import yaml
from conftest import ROOT, nearest

FOLDER = ROOT / "tests" / "peers" / "ann_benchmarks"
ANGULAR = numpy.random.default_rng(3).uniform(0.2, 5, size=(3000, 1)).astype(numpy.float32)
"""Lengths that angles do not depend on."""


class BaseANN:
    """What the base class of ann-benchmarks declares, and no more."""

    def done(self): ...
    def fit(self, X): ...
    def query(self, q, n): ...
    def batch_query(self, X, n): ...
    def get_batch_results(self): ...
    def get_additional(self): ...


@pytest.fixture(scope="module")
def adapter():
    """The adapter's module, imported as that project imports it."""
    with pytest.MonkeyPatch.context() as patch:
        package = "ann_benchmarks.algorithms"
        for name in ("ann_benchmarks", package, f"{package}.base", f"{package}.base.module", f"{package}.grasp"):
            module = ModuleType(name)
            module.__path__ = []
            patch.setitem(sys.modules, name, module)
        sys.modules[f"{package}.base.module"].BaseANN = BaseANN
        found = importlib.util.spec_from_file_location(f"{package}.grasp.module", FOLDER / "module.py")
        module = importlib.util.module_from_spec(found)
        found.loader.exec_module(module)
        yield module


def definition() -> dict:
    (entry,) = yaml.safe_load((FOLDER / "config.yml").read_text())["float"]["any"]
    return entry


@pytest.mark.parametrize("metric", ["euclidean", "angular"])
def test_it_finds_what_it_is_asked_for(adapter, metric, vectors, queries):
    entry = definition()
    (group,) = entry["run_groups"].values()
    stored = vectors * ANGULAR if metric == "angular" else vectors
    unit = [part / numpy.linalg.norm(part, axis=1, keepdims=True) for part in (stored, queries)]
    truth, _ = nearest(*(unit if metric == "angular" else (stored, queries)), k=10)
    for arguments in itertools.product(*group["args"]):
        algorithm = getattr(adapter, entry["constructor"])(metric, *arguments)
        algorithm.fit(stored)
        (levels,) = group["query_args"]
        for recall in levels:
            algorithm.set_query_arguments(recall)
            algorithm.batch_query(queries, 10)
            batch = algorithm.get_batch_results()
            single = [algorithm.query(query, 10) for query in queries]
            assert [list(ids) for ids in batch] == [list(ids) for ids in single]
            found = numpy.mean([len(set(ids) & set(near)) / 10 for ids, near in zip(single, truth, strict=True)])
            assert found >= recall, f"{recall} asked, {found} found"
            assert f"{recall:g}" in algorithm.name
            assert algorithm.get_additional()["recall_asked"] == recall
        assert algorithm.get_additional()["index_bytes"] > stored.nbytes
        algorithm.done()
        algorithm.done()


def test_what_it_cannot_do_it_says(adapter):
    with pytest.raises(NotImplementedError, match="hamming"):
        adapter.Grasp("hamming", "f32")


def test_few_vectors_give_few_neighbours(adapter):
    algorithm = adapter.Grasp("angular", "none")
    algorithm.fit([[1.0, 0.0], [0.0, 0.0], [0.0, 3.0]])
    assert list(algorithm.query([2.0, 0.1], 10)) == [0, 1, 2]
    algorithm.done()


def test_it_is_the_algorithm_that_the_settings_name(adapter):
    entry = definition()
    assert entry["module"] == "ann_benchmarks.algorithms.grasp"
    assert entry["docker_tag"] == "ann-benchmarks-grasp"
    assert issubclass(getattr(adapter, entry["constructor"]), BaseANN)
