"""The node beside CycloneDDS: what it answers, how soon, and what it says."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable
from pathlib import Path

import messages
import pytest
from conftest import PICTURES, ROOT, Node, checked, told
from peer import Peer, header, number_of
from PIL import Image

FILES = sorted(PICTURES.glob("*.jpg"))


def compressed(number: int, file: Path) -> messages.CompressedImage:
    return messages.CompressedImage(header=header(number), format="jpeg", data=file.read_bytes())


def raw(number: int, picture: Image.Image, encoding: str = "rgb8", padding: int = 0) -> messages.Image:
    """A picture with rows that are padded by some bytes."""
    width, height = picture.size
    order = {"rgb8": ("RGB", "RGB"), "bgr8": ("RGB", "BGR"), "mono8": ("L", "L")}[encoding]
    data = picture.convert(order[0]).tobytes("raw", order[1])
    step = len(data) // height
    rows = [data[step * row : step * (row + 1)] + bytes(padding) for row in range(height)]
    return messages.Image(
        header=header(number),
        width=width,
        height=height,
        encoding=encoding,
        step=step + padding,
        data=b"".join(rows),
    )


@pytest.mark.parametrize("options", [[], ["--sequence"], ["--hand", "left", "--recall", "0.5"]])
def test_answers_are_the_programs(
    node: Callable[..., Node], index: Path, answers: Callable[..., dict[str, dict]], options: list[str]
) -> None:
    expected = answers(FILES, *options)
    ros = "--ros-args", "-p", "image_transport:=compressed", "-r", "image:=/camera/image_raw"
    started = node("--index", index, *options, *ros)
    peer = Peer(started.domain)
    detections = peer.reader("/grasp/detections", messages.Detection2DArray)
    poses = peer.reader("/grasp/pose", messages.PoseStamped)
    markers = peer.reader("/grasp/markers", messages.MarkerArray)
    writer = peer.writer("/camera/image_raw/compressed", messages.CompressedImage)
    for number, file in enumerate(FILES):
        writer.write(compressed(number, file))
        detections.wait(lambda found, wanted=number: len(found) == wanted + 1)
    time.sleep(0.3)

    detected = {number_of(message): message for _, message in detections.messages}
    turned = {number_of(message): message for _, message in poses.messages}
    recognised = 0
    for number, file in enumerate(FILES):
        record, message = expected[str(file)], detected[number]
        assert message.header == header(number)
        if record.get("grasp", "unknown") == "unknown":
            assert message.detections == [] and number not in turned
            continue
        recognised += 1
        (detection,) = message.detections
        checked(detection, turned[number], record)
        assert turned[number].header == header(number)
        # Nobody has said what the camera is: on its axis.
        place = turned[number].pose.position
        assert [place.x, place.y, place.z] == [0.0, 0.0, 1.0]
        box = detection.bbox
        assert 0 < box.size_x <= 640 and 0 < box.size_y <= 480
        assert 0 < box.center.position.x < 640 and 0 < box.center.position.y < 480
    assert recognised > 0
    assert len(markers.messages) == len(FILES)
    counted = started.stop()
    assert (counted["answered"], counted["recognised"], counted["dropped"]) == (len(FILES), recognised, 0)


@pytest.mark.parametrize(("encoding", "padding"), [("rgb8", 0), ("bgr8", 12), ("mono8", 3)])
def test_pixels_are_those_of_the_same_picture_as_a_file(
    node: Callable[..., Node],
    index: Path,
    answers: Callable[..., dict[str, dict]],
    tmp_path: Path,
    encoding: str,
    padding: int,
) -> None:
    picture = Image.open(PICTURES / "02-small-diameter.jpg").resize((320, 240))
    picture = picture.convert("L" if encoding == "mono8" else "RGB")
    file = tmp_path / "picture.png"
    picture.save(file)
    (record,) = answers([file], "--accept", "always").values()
    started = node("--index", index, "--accept", "always")
    peer = Peer(started.domain)
    detections = peer.reader("/grasp/detections", messages.Detection2DArray)
    poses = peer.reader("/grasp/pose", messages.PoseStamped)
    writer = peer.writer("/image", messages.Image)
    writer.write(raw(7, picture, encoding, padding))
    (message,) = detections.wait(lambda found: len(found) == 1)
    if "error" in record and record["error"]:
        assert message.detections == []
        return
    (pose,) = poses.wait(lambda found: len(found) == 1)
    checked(message.detections[0], pose, record)


def test_thirty_pictures_a_second_are_answered_in_time(
    node: Callable[..., Node],
    index: Path,
    answers: Callable[..., dict[str, dict]],
    seconds: float,
    capsys: pytest.CaptureFixture[str],
) -> None:
    expected = answers(FILES)
    started = node("--index", index, "--image-transport", "compressed")
    peer = Peer(started.domain)
    detections = peer.reader("/grasp/detections", messages.Detection2DArray)
    poses = peer.reader("/grasp/pose", messages.PoseStamped)
    writer = peer.writer("/image/compressed", messages.CompressedImage)
    pictures = [file.read_bytes() for file in FILES]
    sent: list[float] = []
    begun = time.perf_counter()
    for number in range(round(30 * seconds)):
        time.sleep(max(0.0, begun + number / 30 - time.perf_counter()))
        picture = messages.CompressedImage(
            header=header(number), format="jpeg", data=pictures[number % len(pictures)]
        )
        sent.append(time.perf_counter())
        writer.write(picture)
    time.sleep(0.5)

    turned = {number_of(message): message for _, message in poses.messages}
    ages = []
    for came, message in detections.messages:
        number = number_of(message)
        ages.append(came - sent[number])
        record = expected[str(FILES[number % len(FILES)])]
        if record.get("grasp", "unknown") == "unknown":
            assert message.detections == []
        else:
            checked(message.detections[0], turned[number], record)
    numbers = [number_of(message) for _, message in detections.messages]
    assert numbers == sorted(set(numbers)), "answers keep the pictures' order, one each"
    counted = started.stop()
    own = started.said("answered:")[-1].split("picture in to answer out ")[1]
    with capsys.disabled():
        print(f"\nJPEGs by CycloneDDS: {told(len(sent), ages, counted)}; in the node {own}")
    assert counted["answered"] == len(ages)
    assert max(ages) < 0.2, "an answer is older than 200 ms"
    # What was dropped was older than what was answered instead.
    assert len(ages) > 0.2 * len(sent)
    assert counted["answered"] + counted["dropped"] > 0.95 * len(sent), "pictures are lost on their way"


def test_only_the_newest_of_a_burst_is_answered(node: Callable[..., Node], index: Path) -> None:
    started = node("--index", index, "--image-transport", "compressed", "--rolls", "12", "--exact")
    peer = Peer(started.domain)
    detections = peer.reader("/grasp/detections", messages.Detection2DArray)
    writer = peer.writer("/image/compressed", messages.CompressedImage)
    for number in range(20):
        writer.write(compressed(number, FILES[0]))
        time.sleep(0.002)
    detections.wait(lambda found: any(number_of(message) == 19 for message in found))
    time.sleep(0.5)
    numbers = [number_of(message) for _, message in detections.messages]
    assert numbers[-1] == 19 and len(numbers) < 15, numbers
    counted = started.stop()
    assert counted["dropped"] > 0 and counted["dropped"] + counted["answered"] <= 20


def test_a_calibrated_camera_puts_the_hand_on_its_ray(node: Callable[..., Node], index: Path) -> None:
    started = node(
        "--index", index, "--accept", "always", "--depth", "0.5", "--ros-args", "-r", "image:=/camera/image", "-r",
        "__ns:=/arm", "-p", "image_transport:=compressed",
    )
    peer = Peer(started.domain)
    detections = peer.reader("/arm/grasp/detections", messages.Detection2DArray)
    poses = peer.reader("/arm/grasp/pose", messages.PoseStamped)
    cameras = peer.writer("/camera/camera_info", messages.CameraInfo)
    objects = peer.writer("/arm/object_pose", messages.PoseStamped)
    writer = peer.writer("/camera/image/compressed", messages.CompressedImage)

    def pose_of(number: int) -> tuple[messages.Pose, messages.BoundingBox2D]:
        time.sleep(0.2)
        writer.write(compressed(number, FILES[1]))
        poses.wait(lambda found: any(number_of(message) == number for message in found))
        message = next(m for _, m in poses.messages if number_of(m) == number)
        box = next(m for _, m in detections.messages if number_of(m) == number).detections[0].bbox
        return message.pose, box

    focal = [500.0, 0.0, 320.0, 0.0, 510.0, 240.0, 0.0, 0.0, 1.0]
    cameras.write(messages.CameraInfo(header=header(0), width=640, height=480, k=focal))
    pose, box = pose_of(0)
    assert pose.position.z == 0.5
    assert pose.position.x == pytest.approx((box.center.position.x - 320) / 500 * 0.5)
    assert pose.position.y == pytest.approx((box.center.position.y - 240) / 510 * 0.5)
    # The object is where it is said to be, and so is the hand.
    held = messages.Pose(position=messages.Point(x=0.1, y=0.0, z=0.8))
    objects.write(messages.PoseStamped(header=header(0), pose=held))
    assert pose_of(1)[0].position.z == 0.8
    # In another frame it says nothing of how far that is.
    objects.write(messages.PoseStamped(header=header(0, "map"), pose=held))
    assert pose_of(2)[0].position.z == 0.5
    assert started.stop()["answered"] == 3


def test_a_robots_grasp_is_the_programs(
    node: Callable[..., Node], index: Path, answers: Callable[..., dict[str, dict]]
) -> None:
    things = ROOT / "query" / "data" / "objects"
    files = {"--object": things / "bottle.toml", "--camera": things / "camera.toml"}
    scene = ["--robot", "barrett", *(str(word) for pair in files.items() for word in pair)]
    sure = ["--accept", "always", "--hand", "right"]
    expected = answers(FILES, *scene, *sure)
    started = node("--index", index, "--image-transport", "compressed", *scene, *sure)
    peer = Peer(started.domain)
    grasps = peer.reader("/grasp/grasp", messages.Grasp)
    detections = peer.reader("/grasp/detections", messages.Detection2DArray)
    writer = peer.writer("/image/compressed", messages.CompressedImage)
    for number, file in enumerate(FILES):
        writer.write(compressed(number, file))
        detections.wait(lambda found, wanted=number: len(found) == wanted + 1)
    time.sleep(0.5)
    made = {message.grasp_pose.header.stamp.sec - 1000: message for _, message in grasps.messages}
    feasible = 0
    for number, file in enumerate(FILES):
        strategy = expected[str(file)].get("strategy")
        assert (number in made) == bool(strategy and strategy["feasible"]), file
        if number not in made:
            continue
        feasible += 1
        grasp, wanted = made[number], strategy["wrist_in_world"]
        assert grasp.grasp_pose.header.frame_id == "world"
        place, turned = grasp.grasp_pose.pose.position, grasp.grasp_pose.pose.orientation
        assert [place.x, place.y, place.z] == pytest.approx(wanted["position"], abs=1e-6)
        assert [turned.x, turned.y, turned.z, turned.w] == pytest.approx(wanted["quaternion_xyzw"], abs=1e-6)
        closed = dict(zip(grasp.grasp_posture.joint_names, grasp.grasp_posture.points[0].positions, strict=True))
        assert closed == pytest.approx(strategy["closed"], abs=1e-6)
    refused = sum(1 for record in expected.values() if record.get("strategy") and not record["strategy"]["feasible"])
    assert feasible + refused > 0
    assert not refused or started.said("not feasible")


def test_what_cannot_be_read_is_said_once(node: Callable[..., Node], index: Path) -> None:
    started = node("--index", index)
    peer = Peer(started.domain)
    detections = peer.reader("/grasp/detections", messages.Detection2DArray)
    writer = peer.writer("/image", messages.Image)
    odd = messages.Image(header=header(0), width=2, height=2, encoding="yuv422_yuy2", step=4, data=bytes(8))
    for _ in range(5):
        writer.write(odd)
        time.sleep(0.05)
    started.wait_for("yuv422_yuy2")
    writer.write(messages.Image(header=header(1), width=9, height=9, encoding="rgb8", step=27, data=bytes(8)))
    started.wait_for("9 rows of 27 bytes are announced, but 8 bytes came")
    # It goes on.
    writer.write(raw(2, Image.new("RGB", (64, 48))))
    (message,) = detections.wait(lambda found: len(found) == 1)
    assert message.detections == [] and number_of(message) == 2
    assert len(started.said("yuv422_yuy2")) == 1
    counted = started.stop(signal.SIGTERM)
    assert counted["unreadable"] >= 2 and counted["empty"] == 1


def test_mistakes_end_it_with_a_word(tmp_path: Path) -> None:
    def error(*arguments: str) -> str:
        started = Node(*arguments)
        assert started.process.wait(timeout=20) == 2
        started.reader.join(timeout=5)
        return "\n".join(started.lines)

    missing = tmp_path / "missing.idx"
    assert "no index at" in error("--index", str(missing))
    assert "grasp-builder build" in error("--ros-args", "-p", f"index:={missing}")
    assert "no parameter hnad" in error("--ros-args", "-p", "hnad:=left")
    assert "--object and --camera" in error("--robot", "barrett")

