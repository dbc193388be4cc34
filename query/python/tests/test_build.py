"""`grasp.build`."""

from __future__ import annotations

import numpy
import pytest

import grasp


def test_the_builder_makes_an_index_that_answers_the_same(vectors, queries, program, tmp_path):
    numpy.save(tmp_path / "x.npy", vectors)
    made = program(
        "grasp-builder", "build", "--descriptors", tmp_path / "x.npy", "--seed", 5, "--out", tmp_path / "b.idx"
    )
    assert made.returncode == 0, made.stderr
    own = grasp.build(vectors, tmp_path / "own.idx", seed=5)
    other = grasp.Index(tmp_path / "b.idx")
    for array, same in zip(own.search(queries), other.search(queries), strict=True):
        assert (array == same).all()
    assert own.info()["measured"] == other.info()["measured"]


def test_same_input_same_bytes(vectors, tmp_path):
    once, again = tmp_path / "once.idx", tmp_path / "again.idx"
    grasp.build(vectors, once, threads=1)
    grasp.build(numpy.asfortranarray(vectors), again, threads=3)
    assert once.read_bytes() == again.read_bytes()
    grasp.build(vectors, again, seed=1)
    assert once.read_bytes() != again.read_bytes()


def test_options(vectors, queries, tmp_path):
    path = tmp_path / "o.idx"
    index = grasp.build(vectors, path, held_out=queries, hash="random", seed=3)
    assert index.info()["hash"]["kind"] == "random" and index.info()["measured"]["held_out"] is True
    index = grasp.build(vectors, path, originals="none")
    assert index.info()["originals"] == "none"
    with pytest.raises(grasp.ParameterError, match="the index keeps no descriptors to measure exact"):
        index.search(queries, exact=True)
    labelled = grasp.build(vectors[:4], path, numpy.array(["b", "a", "b", "c"]), cutkosky={"c": 1})
    named = {entry["name"]: (entry["cutkosky"], entry["entries"]) for entry in labelled.info()["classes"]}
    assert named == {"a": (0, 1), "b": (0, 2), "c": (1, 1)}
    assert [labelled.entry(number)["grasp"] for number in range(4)] == ["b", "a", "b", "c"]


def test_progress_is_heard_and_can_stop(vectors, tmp_path):
    heard = []
    grasp.build(vectors, tmp_path / "p.idx", progress=lambda phase, share: heard.append((phase, share)))
    phases = [phase for phase, _ in heard]
    assert phases[0] == "entries" and phases[-1] == "write"
    assert {"sigma", "tables", "measure"} <= set(phases) and all(0 <= share <= 1 for _, share in heard)

    def stop(phase, share):
        if phase == "tables":
            raise KeyError("enough")

    with pytest.raises(KeyError, match="enough"):
        grasp.build(vectors, tmp_path / "stopped.idx", progress=stop)
    assert not (tmp_path / "stopped.idx").exists()
    assert not list(tmp_path.glob("*stopped*tmp*"))


def test_an_existing_index_is_replaced_and_another_file_is_not(vectors, queries, tmp_path):
    path = tmp_path / "mine.idx"
    path.write_text("somebody's work")
    with pytest.raises(grasp.IndexFileError, match="exists, and is no index"):
        grasp.build(vectors, path)
    assert path.read_text() == "somebody's work"
    path.unlink()
    old = grasp.build(vectors, path)
    before = old.search(queries)
    grasp.build(vectors[:100], path)
    for array, same in zip(old.search(queries), before, strict=True):
        assert (array == same).all(), "who has it open goes on undisturbed"
    assert len(grasp.Index(path)) == 100


def test_what_cannot_be_built_is_refused(vectors, tmp_path):
    bad = vectors.copy()
    bad[2, 7] = numpy.inf
    cases = [
        ({"vectors": vectors[0]}, r"vectors have the shape \(24,\): \(n, dim\) is needed"),
        ({"vectors": vectors[:0]}, "the index would be empty: add at least one entry"),
        ({"vectors": vectors[:, :0]}, "vectors have 0 values each"),
        ({"vectors": bad}, "row 2 cannot be added: value 7 of its descriptor is not a finite number"),
        ({"labels": ["a"]}, "there are 1 labels and 3000 vectors"),
        ({"labels": [1] * 3000}, r"labels\[0\] is 1: a name \(str\) is needed"),
        ({"labels": "abc"}, "labels is a single text: a sequence of 3000 names is needed"),
        ({"cutkosky": {"a": 1}}, "cutkosky says which number a label has: give labels as well"),
        ({"labels": ["a"] * 3000, "cutkosky": {"misspelt": 3}}, 'cutkosky names "misspelt", which is none of'),
        ({"labels": ["a"] * 3000, "cutkosky": {"a": 300}}, r'cutkosky\["a"\] is 300: an integer from 0 to 255'),
        ({"labels": ["a"] * 3000, "cutkosky": {"a": 2**200}}, "is an integer of more than 128 bits: an"),
        ({"seed": -1}, "seed is -1: an integer from 0 to 18446744073709551615 is needed"),
        ({"seed": 2**64}, "seed is 18446744073709551616: an integer from 0 to"),
        ({"threads": 2**70}, "threads is 1180591620717411303424: 1 to 1024 are possible"),
        ({"vectors": [[1, 2], [3]]}, "vectors are no array: rows of numbers, all of one length, are needed"),
        ({"held_out": vectors[:, :3]}, "held_out has rows of 3 values, vectors of 24: they must agree"),
        ({"hash": "other"}, 'hash is "other": "learned" or "random" is needed'),
        ({"originals": "f8"}, 'originals is "f8": "f32", "f16" or "none" is needed'),
        ({"hash": "random", "originals": "none"}, "a random hash needs the original descriptors"),
    ]
    for arguments, message in cases:
        with pytest.raises(grasp.ParameterError, match=message):
            grasp.build(**{"vectors": vectors, "path": tmp_path / "x.idx", **arguments})
    with pytest.raises(grasp.GraspError):
        grasp.build(vectors, tmp_path / "no" / "such" / "folder.idx")
