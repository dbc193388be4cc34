"""The node beside ROS 2 itself: rclpy over Fast DDS."""

from __future__ import annotations

import array
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import rclpy
from conftest import PICTURES, Node, told
from geometry_msgs.msg import PoseStamped
from PIL import Image as Pictures
from rcl_interfaces.msg import Log, Parameter, ParameterValue
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import Image
from visualization_msgs.msg import Marker, MarkerArray

FILES = sorted(PICTURES.glob("*.jpg"))


class Ros:
    """A node of ROS in a domain, spinning in a thread."""

    def __init__(self, domain: int) -> None:
        self.context = Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = rclpy.create_node("user", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.thread = threading.Thread(target=self._spin, daemon=True)
        self.thread.start()

    def _spin(self) -> None:
        try:
            while self.context.ok():
                self.executor.spin_once(timeout_sec=0.1)
        except ExternalShutdownException:
            return

    def close(self) -> None:
        rclpy.shutdown(context=self.context)
        self.thread.join(timeout=5)
        self.node.destroy_node()

    def heard(self, topic: str, kind: type, qos: object = 50) -> list[tuple[float, object]]:
        found: list[tuple[float, object]] = []
        self.node.create_subscription(
            kind, topic, lambda message: found.append((time.perf_counter(), message)), qos
        )
        return found

    def call(self, kind: type, service: str, request: object) -> object:
        client = self.node.create_client(kind, service)
        assert client.wait_for_service(timeout_sec=20), service
        future = client.call_async(request)
        wait(future.done, service)
        return future.result()


def wait(done: Callable[[], object], what: str, timeout: float = 20.0) -> None:
    end = time.monotonic() + timeout
    while not done():
        assert time.monotonic() < end, what
        time.sleep(0.02)


@pytest.fixture
def ros() -> Iterator[Callable[[int], Ros]]:
    opened: list[Ros] = []

    def enter(domain: int) -> Ros:
        opened.append(Ros(domain))
        return opened[-1]

    yield enter
    for one in opened:
        one.close()


def picture(number: int, pixels: bytes, size: tuple[int, int]) -> Image:
    message = Image(width=size[0], height=size[1], encoding="rgb8", step=3 * size[0])
    message.header.frame_id = "camera_optical"
    message.header.stamp.sec = 1000 + number
    message.data = array.array("B", pixels)
    return message


@pytest.fixture(scope="session")
def pngs(tmp_path_factory: pytest.TempPathFactory) -> list[tuple[Path, bytes, tuple[int, int]]]:
    """The sample pictures as files without loss, and their pixels."""
    folder = tmp_path_factory.mktemp("pngs")
    found = []
    for file in FILES:
        pixels = Pictures.open(file).convert("RGB")
        path = folder / f"{file.stem}.png"
        pixels.save(path)
        found.append((path, pixels.tobytes(), pixels.size))
    return found


def test_raw_pictures_are_answered_in_time(
    node: Callable[..., Node],
    ros: Callable[[int], Ros],
    index: Path,
    answers: Callable[..., dict[str, dict]],
    pngs: list[tuple[Path, bytes, tuple[int, int]]],
    seconds: float,
    capsys: pytest.CaptureFixture[str],
) -> None:
    expected = answers([path for path, _, _ in pngs])
    started = node("--index", index, "--ros-args", "-r", "image:=/camera/image_raw")
    other = ros(started.domain)
    poses = other.heard("/grasp/pose", PoseStamped)
    markers = other.heard("/grasp/markers", MarkerArray)
    writer = other.node.create_publisher(Image, "/camera/image_raw", qos_profile_sensor_data)
    wait(lambda: writer.get_subscription_count() == 1, "the node reads pictures")
    wait(lambda: other.node.count_publishers("/grasp/pose") == 1, "the node publishes poses")
    time.sleep(0.5)

    sent: list[float] = []
    begun = time.perf_counter()
    for number in range(round(30 * seconds)):
        _, pixels, size = pngs[number % len(pngs)]
        message = picture(number, pixels, size)
        time.sleep(max(0.0, begun + number / 30 - time.perf_counter()))
        sent.append(time.perf_counter())
        writer.publish(message)
    time.sleep(0.5)

    def number_of(message: PoseStamped) -> int:
        return message.header.stamp.sec - 1000

    ages = []
    for came, message in poses:
        number = number_of(message)
        ages.append(came - sent[number])
        record = expected[str(pngs[number % len(pngs)][0])]
        turned = message.pose.orientation
        assert [turned.x, turned.y, turned.z, turned.w] == record["orientation"]["quaternion_xyzw"]
        assert message.header.frame_id == "camera_optical"
    counted = started.stop()
    with capsys.disabled():
        print(f"\nraw pictures of 0.9 MB by rclpy: {told(len(sent), ages, counted)}")
    assert counted["recognised"] == len(ages) > 0
    assert len(markers) == counted["answered"]
    assert max(ages) < 0.2, "an answer is older than 200 ms"
    assert counted["answered"] > 0.2 * len(sent)

    shown = next(message for _, message in markers if len(message.markers) == 4)
    assert [marker.ns for marker in shown.markers] == ["hand", "name", "gripper", "approach"]
    assert shown.markers[0].type == Marker.LINE_LIST and shown.markers[3].type == Marker.ARROW
    assert "hand)" in shown.markers[1].text


def test_the_graph_shows_the_node_and_its_parameters(
    node: Callable[..., Node], ros: Callable[[int], Ros], index: Path
) -> None:
    started = node("--index", index, "--ros-args", "-r", "__ns:=/arm", "-r", "__node:=eye", "-p", "hand:=left")
    other = ros(started.domain)
    wait(lambda: ("eye", "/arm") in other.node.get_node_names_and_namespaces(), "the node is in the graph")
    topics = dict(other.node.get_topic_names_and_types())
    for topic, kind in {
        "/arm/image": "sensor_msgs/msg/Image",
        "/arm/camera_info": "sensor_msgs/msg/CameraInfo",
        "/arm/object_pose": "geometry_msgs/msg/PoseStamped",
        "/arm/eye/detections": "vision_msgs/msg/Detection2DArray",
        "/arm/eye/pose": "geometry_msgs/msg/PoseStamped",
        "/arm/eye/markers": "visualization_msgs/msg/MarkerArray",
        "/arm/eye/grasp": "moveit_msgs/msg/Grasp",
    }.items():
        assert topics.get(topic) == [kind], (topic, topics)

    listed = other.call(ListParameters, "/arm/eye/list_parameters", ListParameters.Request())
    assert {"hand", "index", "image_transport", "use_sim_time"} <= set(listed.result.names)
    asked = GetParameters.Request(names=["hand", "recall", "exact"])
    hand, recall, exact = other.call(GetParameters, "/arm/eye/get_parameters", asked).values
    assert (hand.string_value, recall.double_value, exact.bool_value) == ("left", 0.95, False)
    wanted = Parameter(name="hand", value=ParameterValue(type=4, string_value="right"))
    request = SetParameters.Request(parameters=[wanted])
    (result,) = other.call(SetParameters, "/arm/eye/set_parameters", request).results
    assert not result.successful and "-p hand:=VALUE" in result.reason
    started.stop()


def test_what_the_node_says_is_in_rosout(
    node: Callable[..., Node], ros: Callable[[int], Ros], index: Path
) -> None:
    started = node("--index", index)
    other = ros(started.domain)
    said = other.heard("/rosout", Log)
    writer = other.node.create_publisher(Image, "/image", qos_profile_sensor_data)
    wait(lambda: writer.get_subscription_count() == 1, "the node reads pictures")
    for _ in range(3):
        time.sleep(0.5)
        writer.publish(Image(width=1, height=1, encoding="16UC1", step=2, data=array.array("B", [0, 0])))
    wait(lambda: any("16UC1" in message.msg for _, message in said), "the warning")
    assert len(started.said("16UC1")) == 1
    started.stop()
