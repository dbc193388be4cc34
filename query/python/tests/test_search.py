"""`grasp.Index`: what it finds, in which form, and what it refuses."""

from __future__ import annotations

import json
import os
import re
import tracemalloc
from pathlib import Path

import numpy
import pytest
from conftest import nearest

import grasp


def test_exact_search_finds_the_true_neighbours(index, vectors, queries):
    ids, distances = index.search(queries, k=5, exact=True)
    true_ids, true_distances = nearest(vectors, queries, 5)
    assert (ids == true_ids).all()
    numpy.testing.assert_allclose(distances, true_distances, rtol=1e-5)


def test_search_reaches_the_recall_that_is_asked_for(index, vectors, queries):
    true_ids, _ = nearest(vectors, queries, 10)
    for recall in (0.9, 0.99):
        ids, _ = index.search(queries, recall=recall)
        found = [len(set(row) & set(true)) / 10 for row, true in zip(ids, true_ids, strict=True)]
        assert numpy.mean(found) > recall - 0.05, recall


def test_answers_have_their_types_and_shapes(index, queries):
    ids, distances = index.search(queries, k=3)
    assert (ids.dtype, distances.dtype) == (numpy.int64, numpy.float32)
    assert ids.shape == distances.shape == (len(queries), 3)
    one_ids, one_distances = index.search(queries[7], k=3)
    assert (one_ids == ids[7:8]).all() and (one_distances == distances[7:8]).all()
    none = numpy.empty((0, index.dim), dtype=numpy.float32)
    assert [array.shape for array in index.search(none, k=4)] == [(0, 4), (0, 4)]


def test_missing_neighbours_are_marked(tmp_path):
    few = grasp.build(numpy.eye(3, dtype=numpy.float32), tmp_path / "few.idx")
    for exact in (False, True):
        ids, distances = few.search(numpy.zeros((2, 3), dtype=numpy.float32), k=5, exact=exact)
        assert ids.tolist() == [[0, 1, 2, -1, -1]] * 2
        assert numpy.isinf(distances[:, 3:]).all() and numpy.allclose(distances[:, :3], 1)


def test_arrays_of_other_kinds_give_the_same_answers(index, queries):
    expected = index.search(queries, k=4)
    wide = numpy.zeros((len(queries), 2 * index.dim), dtype=numpy.float32)
    wide[:, ::2] = queries
    unaligned = numpy.frombuffer(b"x" + queries.tobytes(), dtype=numpy.uint8)[1:].view(numpy.float32)
    others = {
        "double": queries.astype(numpy.float64),
        "columns": numpy.asfortranarray(queries),
        "strided": wide[:, ::2],
        "byte order": queries.astype(">f4"),
        "read-only": numpy.frombuffer(queries.tobytes(), dtype=numpy.float32).reshape(queries.shape),
        "unaligned": unaligned.reshape(queries.shape),
        "lists": queries.tolist(),
    }
    for name, other in others.items():
        for array, same in zip(index.search(other, k=4), expected, strict=True):
            assert (array == same).all(), name


def test_float32_rows_are_read_where_they_lie(index, queries):
    many = numpy.tile(queries, (50, 1))

    def copied(array):
        tracemalloc.start()
        index.search(array, k=1)
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return most

    assert copied(many) < many.nbytes / 10 < many.nbytes <= copied(many.astype(float))


def test_the_number_of_threads_changes_nothing(index, queries):
    one = index.search(queries, threads=1)
    for threads in (2, 3, 64):
        for array, same in zip(index.search(queries, threads=threads), one, strict=True):
            assert (array == same).all()


def test_the_program_finds_the_same(index, vector_index_path, queries, program, tmp_path):
    numpy.save(tmp_path / "q.npy", queries)
    outputs = ["--out", tmp_path / "ids.npy", "--distances", tmp_path / "distances.npy"]
    for options, asked in (
        ([], {}),
        (["--recall", "0.99"], {"recall": 0.99}),
        (["--exact"], {"exact": True}),
    ):
        found = program(
            "grasp-query", "search", tmp_path / "q.npy", "--index", vector_index_path, *outputs, *options
        )
        assert found.returncode == 0, found.stderr
        ids, distances = index.search(queries, k=10, **asked)
        assert (ids == numpy.load(tmp_path / "ids.npy")).all()
        assert (distances == numpy.load(tmp_path / "distances.npy")).all()


def test_what_cannot_be_searched_for_is_refused_with_what_can(index, queries):
    bad = queries.copy()
    bad[150, 3] = numpy.nan
    wide = queries.copy()
    wide[199, 23] = -2e15
    cases = [
        ({"queries": queries[:, :5]}, "the query has 5 values, the index's descriptors have 24"),
        ({"queries": queries[None]}, r"queries have the shape \(1, 200, 24\): \(n, dim\) or \(dim,\)"),
        ({"queries": bad}, r"queries\[150\]\[3\] is not a finite number"),
        ({"queries": bad, "threads": 2}, r"queries\[150\]\[3\] is not a finite number"),
        ({"queries": numpy.vstack([queries] * 100 + [bad])}, r"queries\[20150\]\[3\] is not a finite number"),
        ({"queries": bad[150]}, r"queries\[3\] is not a finite number"),
        ({"queries": wide}, r"queries\[199\]\[23\] is larger than 1e15"),
        ({"queries": wide, "exact": True}, r"queries\[199\]\[23\] is larger than 1e15"),
        ({"queries": [[1.0, 2.0], [3.0]]}, "queries are no array: rows of numbers, all of one length"),
        ({"queries": numpy.array(["a"])}, "queries are of the type <U1: real numbers are needed"),
        ({"queries": queries.astype(complex)}, "queries are of the type complex128"),
        ({"queries": 1.0}, "queries are a single number"),
        ({"queries": queries, "k": 0}, "k is 0: an integer from 1 to 100000"),
        ({"queries": queries, "k": -1}, "k is -1: an integer from 1 to 100000"),
        ({"queries": queries, "k": 2**70}, "k is 1180591620717411303424: an integer from 1 to 100000"),
        ({"queries": queries, "k": -(2**200)}, "k is an integer of more than 128 bits: an integer from 1"),
        ({"queries": queries, "recall": 10**400}, "a recall of inf is not possible"),
        ({"queries": queries, "recall": 0.0}, "a recall of 0 is not possible: it must be above 0"),
        ({"queries": queries[:0], "recall": 2.0}, "a recall of 2 is not possible"),
        ({"queries": queries, "threads": 0}, "threads is 0: 1 to 1024 are possible"),
        ({"queries": queries, "threads": 10**6}, "threads is 1000000: 1 to 1024 are possible"),
    ]
    for arguments, message in cases:
        with pytest.raises(grasp.ParameterError, match=message) as raised:
            index.search(**arguments)
        assert isinstance(raised.value, grasp.GraspError) and isinstance(raised.value, ValueError)


def test_an_index_says_what_it_is(index, vector_index_path, program):
    info = index.info()
    assert (len(index), index.dim) == (info["entries"], info["descriptor"]["dim"]) == (3000, 24)
    assert info["recognises"] is False
    assert "3000 entries of 24 values" in repr(index)
    inspected = program("grasp-builder", "inspect", "--json", vector_index_path)
    report = json.loads(inspected.stdout)
    for key in info.keys() - {"descriptor", "recognises"}:
        assert info[key] == report[key], key
    assert index.entry(1)["grasp"] == "power-sphere"
    for missing in (3000, -1, 2**40, 2**70):
        with pytest.raises(grasp.ParameterError, match=f"there is no entry {missing}: the index holds 3000"):
            index.entry(missing)


def test_a_closed_index_says_so(vector_index_path, queries):
    with grasp.Index(vector_index_path) as index:
        assert len(index) == 3000 and not index.closed
    assert index.closed and "closed" in repr(index)
    for use in (lambda: index.search(queries), lambda: len(index), index.info, index.__enter__):
        with pytest.raises(grasp.ParameterError, match="is closed: open it again"):
            use()
    index.close()


def test_a_file_that_is_no_index_is_refused_in_the_programs_words(vector_index_path, program, tmp_path):
    whole = vector_index_path.read_bytes()
    cases = {"text.idx": b"not an index" * 100, "empty.idx": b"", "short.idx": whole[: len(whole) // 2]}
    numpy.save(tmp_path / "q.npy", numpy.zeros((1, 24), dtype=numpy.float32))
    for name, content in cases.items():
        path = tmp_path / name
        path.write_bytes(content)
        said = program("grasp-query", "search", tmp_path / "q.npy", "--index", path)
        assert said.returncode == 2
        for mmap in (True, False):
            with pytest.raises(grasp.IndexFileError) as raised:
                grasp.Index(path, mmap=mmap)
            assert str(raised.value) in said.stderr
    with pytest.raises(grasp.IndexFileError, match="it is a folder: name the index file itself"):
        grasp.Index(tmp_path)
    with pytest.raises(grasp.IndexFileError, match=re.escape(f"no index at {tmp_path / 'none.idx'}: build one")):
        grasp.Index(tmp_path / "none.idx")


@pytest.mark.skipif(os.name != "posix", reason="only there the fault can be handled")
def test_an_index_that_is_cut_short_raises_and_does_not_end_the_process(vector_index_path, queries, tmp_path):
    path = tmp_path / "cut.idx"
    path.write_bytes(vector_index_path.read_bytes())
    mapped, read = grasp.Index(path), grasp.Index(path, mmap=False)
    expected = read.search(queries)
    os.truncate(path, 4096)
    with pytest.raises(grasp.IndexFileError, match="was overwritten or cut short while it was in use"):
        mapped.search(queries, exact=True)
    for array, same in zip(read.search(queries), expected, strict=True):
        assert (array == same).all()


def test_paths_of_all_kinds(vector_index_path):
    for path in (str(vector_index_path), Path(vector_index_path)):
        assert grasp.Index(path).path == str(vector_index_path)
    with pytest.raises(TypeError):
        grasp.Index(3)
