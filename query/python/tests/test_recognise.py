"""`grasp.Recogniser` and `grasp.Answer`, beside what the program prints."""

from __future__ import annotations

import json
import pickle

import numpy
import pytest
from conftest import CAMERA, PICTURES, ROOT, SEGMENTED, record_of
from PIL import Image

import grasp

DATA = ROOT / "query" / "data"


def printed(program, index_path, picture, *options):
    return record_of(program("grasp-query", "recognise", picture, "--json", "--index", index_path, *options))


def test_an_answer_is_the_record_that_the_program_prints(recogniser, index_path, program):
    for picture in sorted((PICTURES / "camera").glob("[0-9]*.jpg")):
        assert recogniser.recognise(picture).to_dict() == printed(program, index_path, picture)
    relative = CAMERA.relative_to(ROOT)
    options = ["--hand", "right", "--segment", "skin", "--exact", "--accept", "always", "--k", 3, "--rolls", 2]
    other = grasp.Recogniser(
        index_path, "right", segment="skin", exact=True, accept="always", k=3, rolls=2
    )
    answer = other.recognise(CAMERA).to_dict()
    assert answer == printed(program, index_path, CAMERA, *options)
    assert answer["file"] == str(CAMERA) and str(relative) in answer["file"]


def test_masks_and_segmented_pictures(recogniser, index_path, program, tmp_path):
    mask = PICTURES / "mask" / SEGMENTED.name
    expected = printed(program, index_path, SEGMENTED, "--mask", mask)
    assert recogniser.recognise(SEGMENTED, mask).to_dict() == expected
    grey = numpy.asarray(Image.open(mask).convert("L"))
    for array in (grey, grey >= 128, (grey >= 128) * numpy.uint8(255)):
        assert recogniser.recognise(SEGMENTED, array).to_dict() == expected
    segmented = recogniser.recognise(SEGMENTED, segmented=True).to_dict()
    assert segmented == printed(program, index_path, SEGMENTED, "--segmented")

    depth = numpy.where(grey >= 128, 600, 2000).astype(numpy.uint16)
    Image.fromarray(depth).save(tmp_path / "depth.png")
    by_depth = ["--depth", tmp_path / "depth.png", "--depth-range", "400..900"]
    expected = printed(program, index_path, SEGMENTED, *by_depth)
    for given in (depth, tmp_path / "depth.png"):
        answer = recogniser.recognise(SEGMENTED, depth=given, depth_range=(400, 900))
        assert answer.to_dict() == expected


def test_landmarks_of_a_tracker(recogniser, index_path, program):
    path = PICTURES / "landmarks" / "09-pinch.json"
    picture = PICTURES / "camera" / "09-pinch.jpg"
    expected = printed(program, index_path, picture, "--landmarks-json", path)
    places = numpy.array(json.loads(path.read_text())["landmarks"], float)
    deep = numpy.column_stack([places, numpy.zeros(21)])
    with Image.open(picture) as opened:
        shares = places / opened.size
    for given in (places, places.tolist(), deep, places.astype(numpy.int32)):
        assert recogniser.recognise(picture, landmarks=given).to_dict() == expected
    by_shares = recogniser.recognise(picture, landmarks=shares, landmark_unit="share")
    assert by_shares.grasp == expected["grasp"]


def test_a_sequence_is_answered_as_the_program_answers_it(recogniser, index_path, program):
    pictures = sorted((PICTURES / "camera").glob("[0-9]*.jpg"))
    options = ["--json", "--index", index_path, "--sequence", "--switch", 0.1, "--motion", 20]
    outcome = program("grasp-query", "recognise", *pictures, *options)
    expected = [json.loads(line) for line in outcome.stdout.splitlines()]
    sequence = grasp.Sequence(recogniser, switch=0.1, motion_deg=20)
    assert sequence.recogniser is recogniser and "switch=0.1" in repr(sequence)
    for again in range(2):
        for picture, record in zip(pictures, expected, strict=True):
            if "grasp" in record:
                assert sequence.recognise(picture).to_dict() == record
            else:
                with pytest.raises(grasp.PictureError):
                    sequence.recognise(picture)
        sequence.clear()
    assert sum("single" in record for record in expected) >= 5
    assert any(record["single"]["probability"] != record["probability"] for record in expected[1:])


def test_what_is_no_sequence_is_refused(recogniser):
    for wrong in ({"switch": -0.1}, {"switch": float("nan")}, {"motion_deg": 181}, {"switch": 10**400}):
        with pytest.raises(grasp.ParameterError, match="it must be from 0 to"):
            grasp.Sequence(recogniser, **wrong)
    sequence = grasp.Sequence(recogniser)
    with pytest.raises(grasp.PictureError):
        sequence.recognise(numpy.zeros((40, 40, 3), numpy.uint8))
    assert sequence.recognise(CAMERA).to_dict()["single"]["grasp"]


def test_an_array_is_answered_as_the_same_pixels_in_a_file(recogniser, tmp_path):
    rgb = numpy.asarray(Image.open(CAMERA).convert("RGB"))
    grey = numpy.asarray(Image.open(CAMERA).convert("L"))
    for pixels, name in ((rgb, "rgb.ppm"), (grey, "grey.pgm")):
        Image.fromarray(pixels).save(tmp_path / name)
        try:
            expected = recogniser.recognise(tmp_path / name).to_dict()
        except grasp.PictureError as refused:
            with pytest.raises(grasp.PictureError) as raised:
                recogniser.recognise(pixels)
            assert raised.value.kind == refused.kind
            continue
        answer = recogniser.recognise(pixels).to_dict()
        assert answer.pop("file") == "array" and expected.pop("file")
        assert answer == expected
    bgr = rgb[:, :, ::-1]
    turned = recogniser.recognise(bgr[:, :, ::-1]).to_dict()
    assert turned == recogniser.recognise(rgb).to_dict(), "strided arrays are read as they are seen"


def test_attributes(recogniser):
    answer = recogniser.recognise(CAMERA)
    record = answer.to_dict()
    assert answer.grasp == record["grasp"] and answer.probability == record["probability"]
    assert list(answer.classes) == [entry["grasp"] for entry in record["classes"]]
    assert sum(answer.classes.values()) == pytest.approx(1)
    assert answer.hand in ("left", "right") and answer.cutkosky == record["cutkosky"]
    assert (answer.reason is None) == (answer.grasp != "unknown")
    assert list(answer.orientation) == record["orientation"]["quaternion_xyzw"]
    assert numpy.linalg.norm(answer.orientation) == pytest.approx(1)
    assert answer.spread_deg == record["orientation"]["spread_deg"]
    assert answer.neighbours == record["neighbours"] and answer.warnings == record["warnings"]
    for name in ("grasp", "probability", "classes", "other"):
        with pytest.raises(AttributeError):
            setattr(answer, name, None)
    answer.neighbours.clear()
    answer.to_dict().clear()
    assert answer.to_dict() == record
    assert answer.grasp in repr(answer)


def test_rotation(recogniser):
    answer = recogniser.recognise(CAMERA)
    pytest.importorskip("scipy")
    rotation = answer.rotation()
    x, y, z, w = answer.orientation
    fingers = [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)]
    numpy.testing.assert_allclose(rotation.apply([1, 0, 0]), fingers, atol=1e-12)


def test_explain_is_the_program_s_sheet(recogniser, index_path, program, tmp_path):
    sheet = recogniser.recognise(CAMERA).explain()
    assert sheet.dtype == numpy.uint8 and sheet.shape[2] == 3
    drawn = program("grasp-query", "recognise", CAMERA, "--index", index_path, "--explain", tmp_path / "why.png")
    assert drawn.returncode < 2, drawn.stderr
    assert (sheet == numpy.asarray(Image.open(tmp_path / "why.png"))).all()


def test_html_names_what_was_recognised_and_nothing_unescaped(recogniser, tmp_path):
    hostile = tmp_path / "<script>.jpg"
    hostile.write_bytes(CAMERA.read_bytes())
    answer = recogniser.recognise(hostile)
    page = answer._repr_html_()
    assert answer.grasp in page and "<script>" not in page and "&lt;script&gt;" in page
    assert all(name in page for name in answer.classes)


def test_answers_and_recognisers_are_pickled(recogniser):
    answer = recogniser.recognise(CAMERA)
    copy = pickle.loads(pickle.dumps(answer))
    assert copy.to_dict() == answer.to_dict()
    with pytest.raises(grasp.GraspError, match="recognise it again"):
        copy.explain()
    strict = grasp.Recogniser(recogniser.index, "right", k=2)
    again = pickle.loads(pickle.dumps(strict))
    assert again.recognise(CAMERA).to_dict() == strict.recognise(CAMERA).to_dict()


def test_batches(recogniser):
    pictures = sorted((PICTURES / "camera").glob("[0-9]*.jpg"))
    single = [recogniser.recognise(picture).to_dict() for picture in pictures]
    for threads in (1, 2, None):
        batch = recogniser.recognise_batch(pictures, threads=threads)
        assert [answer.to_dict() for answer in batch] == single
    mixed = [pictures[0], "none.jpg", PICTURES / "camera" / "no-hand.jpg", 7]
    with pytest.raises(grasp.PictureError, match=r"none\.jpg"):
        recogniser.recognise_batch(mixed)
    answer, *errors = recogniser.recognise_batch(mixed, errors="return")
    assert answer.to_dict() == single[0]
    assert [error.kind for error in errors] == ["unreadable", "no_hand", "not_an_image"]
    assert recogniser.recognise_batch([]) == []
    assert recogniser.recognise_batch(iter(pictures[:1]))[0].to_dict() == single[0]
    with pytest.raises(grasp.ParameterError, match="a single path: give a list"):
        recogniser.recognise_batch(str(CAMERA))
    with pytest.raises(grasp.ParameterError, match='errors is "hide"'):
        recogniser.recognise_batch([], errors="hide")


def test_a_strategy_is_the_program_s(index_path, program):
    right = grasp.Recogniser(index_path, "right", accept="always")
    answer = right.recognise(CAMERA)
    files = {"object": DATA / "objects" / "handle.toml", "camera": DATA / "objects" / "camera.toml"}
    options = ["--hand", "right", "--accept", "always", "--robot", "barrett"]
    options += [word for name, file in files.items() for word in (f"--{name}", file)]
    for arm in ([], ["--arm", "kuka-kr6-r700"]):
        expected = printed(program, index_path, CAMERA, *options, *arm)
        if expected["strategy"] is None:
            with pytest.raises(grasp.GraspError) as raised:
                grasp.strategy(answer, **files, arm=(arm or [None])[-1])
            assert str(raised.value) == expected["error"]["message"]
        else:
            assert grasp.strategy(answer, **files, arm=(arm or [None])[-1]) == expected["strategy"]
    with pytest.raises(grasp.GraspError, match="there is no robot hand `claw`: use allegro, barrett, "):
        grasp.strategy(answer, "claw", **files)
    with pytest.raises(grasp.GraspError, match="cannot read "):
        grasp.strategy(answer, object="none.toml", camera=files["camera"])


def test_what_is_unknown_is_not_imitated(recogniser):
    record = recogniser.recognise(CAMERA).to_dict() | {"reason": "too far", "grasp": "unknown"}
    with pytest.raises(grasp.GraspError, match="what is unknown is not imitated"):
        grasp.strategy(grasp.Answer(json.dumps(record)), object="a.toml", camera="b.toml")
