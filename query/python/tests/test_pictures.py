"""Pictures and parameters that are refused, and with which words."""

from __future__ import annotations

import numpy
import pytest
from conftest import CAMERA, SEGMENTED

import grasp


def test_arrays_that_could_be_meant_otherwise_are_refused(recogniser):
    picture = numpy.zeros((40, 50, 3), dtype=numpy.uint8)
    cases = [
        (picture.astype(float), "of the type float64: uint8 is needed"),
        (picture.astype(numpy.uint16), "of the type uint16: uint8 is needed"),
        (picture.astype(bool), "of the type bool: uint8 is needed"),
        (picture.astype(numpy.int8), "of the type int8: uint8 is needed"),
        (numpy.zeros((40, 50, 4), numpy.uint8), r"\(40, 50, 4\) has four channels: give \(h, w, 3\), RGB"),
        (numpy.zeros((40, 50, 1), numpy.uint8), r"\(40, 50, 1\): give a grey one as \(h, w\)"),
        (numpy.zeros((3, 40, 50), numpy.uint8), r"\(3, 40, 50\) seems to have its channels first"),
        (numpy.zeros((2, 40, 50, 3), numpy.uint8), r"\(2, 40, 50, 3\): .* one picture at a time"),
        (numpy.zeros(40, numpy.uint8), r"\(40,\): \(h, w, 3\), RGB, or \(h, w\), grey, is needed"),
        (numpy.zeros((0, 50, 3), numpy.uint8), r"\(0, 50, 3\) has no pixels"),
        (numpy.zeros((0, 0), numpy.uint8), r"\(0, 0\) has no pixels"),
        (numpy.broadcast_to(numpy.uint8(0), (1 << 14, 1 << 14)), "is too large: shrink it to at most 134 megapixels"),
        ([[1, 2], [3, 4]], "a picture is a path, or a NumPy array"),
        (None, "a picture is a path, or a NumPy array"),
    ]
    for image, message in cases:
        with pytest.raises(grasp.PictureError, match=message) as raised:
            recogniser.recognise(image)
        assert raised.value.kind == "not_an_image" and not raised.value.is_rejection


def test_pictures_without_an_answer_say_why_as_the_program_does(recogniser, index_path, program, tmp_path):
    (tmp_path / "text.jpg").write_text("no picture")
    (tmp_path / "empty.png").write_bytes(b"")
    (tmp_path / "cut.png").write_bytes(SEGMENTED.read_bytes()[:400])
    (tmp_path / "black.ppm").write_bytes(b"P6 64 64 255\n" + bytes(3 * 64 * 64))
    kinds = {"text.jpg": "not_an_image", "empty.png": "not_an_image", "cut.png": "truncated"}
    for name, kind in (kinds | {"black.ppm": "no_hand", "none.jpg": "unreadable"}).items():
        path = tmp_path / name
        said = program("grasp-query", "recognise", path, "--index", index_path)
        with pytest.raises(grasp.PictureError) as raised:
            recogniser.recognise(path)
        assert str(raised.value) == said.stderr.strip()
        assert raised.value.kind == kind
        assert raised.value.is_rejection == (said.returncode == 1)


def test_masks_that_do_not_fit_are_refused(recogniser, tmp_path):
    picture = numpy.zeros((40, 50, 3), dtype=numpy.uint8)
    ones = numpy.ones((40, 50), dtype=numpy.uint8)
    places = numpy.ones((21, 2))
    parameters = [
        ({"mask": ones}, "the mask's greatest value is 1, and a hand is 128 or more: give it as bool"),
        ({"mask": ones.astype(float)}, "a mask of the type float64: bool, or uint8"),
        ({"mask": picture}, r"a mask of the shape \(40, 50, 3\): \(h, w\) is needed"),
        ({"mask": 5}, "a mask is a path, or a NumPy array of bool or uint8"),
        ({"mask": ones, "segmented": True}, "only one of mask, landmarks, segmented and depth"),
        ({"landmarks": places, "mask": ones}, "only one of mask, landmarks"),
        ({"landmarks": places[:20]}, "20 landmarks, 21 expected"),
        ({"landmarks": places[:, :1]}, r"landmarks of the shape \(21, 1\): \(21, 2\) or \(21, 3\) is needed"),
        ({"landmarks": places * numpy.nan}, "landmark 0 is not at a place"),
        ({"landmarks": [["a", "b"]] * 21}, "landmarks are of the type"),
        ({"landmarks": [[1, 2]] * 20 + [[3]]}, "landmarks are no array: rows of numbers, all of one length"),
        ({"landmarks": places, "landmark_unit": "m"}, 'landmark_unit is "m": "pixel" or "share" is needed'),
        ({"depth": ones}, "depth and depth_range, .* go together"),
        ({"depth_range": (1, 2)}, "depth and depth_range, .* go together"),
        ({"depth": ones, "depth_range": (1, 2)}, "a depth picture of the type uint8: uint16 is needed"),
        ({"depth": ones.astype(numpy.uint16), "depth_range": (0, 2)}, r"depth_range is \(0, 2\): 1 <= near"),
        ({"depth": ones.astype(numpy.uint16), "depth_range": (1, 2**70)}, r"depth_range is \(1, 1180"),
    ]
    for arguments, message in parameters:
        with pytest.raises(grasp.ParameterError, match=message):
            recogniser.recognise(picture, **arguments)
    with pytest.raises(grasp.PictureError, match="the mask has 20 x 40 pixels, its picture 50 x 40") as raised:
        recogniser.recognise(picture, ones[:, :20] > 0)
    assert raised.value.kind == "mask"
    with pytest.raises(grasp.PictureError, match="cannot use the mask .*none.png"):
        recogniser.recognise(picture, tmp_path / "none.png")


def test_parameters_of_a_recogniser(index_path, vector_index_path):
    cases = [
        ({"hand": "both"}, 'hand is "both": "auto", "left" or "right" is needed'),
        ({"segment": "depth"}, 'segment is "depth": "scene" or "skin" is needed'),
        ({"accept": "never"}, 'accept is "never": "calibrated" or "always" is needed'),
        ({"recall": 1.5}, "a recall of 1.5 is not possible"),
        ({"k": 0}, "k is 0: an integer from 1 to 100000"),
        ({"rolls": -1}, "rolls is -1: an integer from 1 to 360"),
        ({"rolls": 0}, "rolls is 0: an integer from 1 to 360"),
        ({"rolls": 361}, "rolls is 361: an integer from 1 to 360"),
        ({"rolls": 2**70}, "rolls is 1180591620717411303424: an integer from 1 to 360"),
    ]
    for arguments, message in cases:
        with pytest.raises(grasp.ParameterError, match=message):
            grasp.Recogniser(index_path, **arguments)
    with pytest.raises(grasp.IndexFileError, match="the index holds raw vectors"):
        grasp.Recogniser(vector_index_path)
    with pytest.raises(grasp.IndexFileError, match="no index at none.idx"):
        grasp.Recogniser("none.idx")
    closing = grasp.Recogniser(index_path)
    answer = closing.recognise(CAMERA)
    closing.index.close()
    assert answer.explain().size, "an answer keeps what it came from"
    with pytest.raises(grasp.ParameterError, match="is closed: open it again"):
        closing.recognise(CAMERA)
