"""What all tests stand on: the built programs, a small index, the program's answers, the node."""

from __future__ import annotations

import itertools
import json
import os
import re
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

# Nothing that these tests say leaves this machine: neither the node's words, nor rclpy's, nor
# CycloneDDS'.
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
os.environ["CYCLONEDDS_URI"] = """<CycloneDDS><Domain>
  <General>
    <Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces>
    <AllowMulticast>false</AllowMulticast>
  </General>
  <Discovery>
    <ParticipantIndex>auto</ParticipantIndex>
    <Peers><Peer address="127.0.0.1"/></Peers>
  </Discovery>
</Domain></CycloneDDS>"""

ROOT = Path(__file__).resolve().parents[3]
PICTURES = ROOT / "tests" / "pictures" / "camera"


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--seconds", type=float, default=10.0, help="how long pictures are published at 30 a second")


@pytest.fixture(scope="session")
def seconds(pytestconfig: pytest.Config) -> float:
    return pytestconfig.getoption("seconds")


def programs() -> Path:
    return Path(os.environ.get("GRASP_PROGRAMS", ROOT / "target" / "debug"))


def program() -> Path:
    """The node's program."""
    named = os.environ.get("GRASP_ROS")
    return Path(named) if named else ROOT / "target" / "ros" / "cargo" / "debug" / "grasp-ros"


@pytest.fixture(scope="session")
def index(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An index of one hand, seen from few sides, described as the default index is."""
    path = tmp_path_factory.mktemp("index") / "small.idx"
    command = [programs() / "grasp-builder", "build", "--hands", "1", "--views", "6", "--out", path]
    subprocess.run(command, check=True, capture_output=True, timeout=600)
    return path


@pytest.fixture(scope="session")
def answers(index: Path) -> Callable[..., dict[str, dict]]:
    """The program's records for pictures, by their files."""

    def ask(pictures: list[Path], *options: str) -> dict[str, dict]:
        command = [programs() / "grasp-query", "recognise", "--json", "--index", index, *options, *pictures]
        told = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
        assert told.returncode < 2, told.stderr
        records = [json.loads(line) for line in told.stdout.splitlines()]
        return {record["file"]: record for record in records}

    return ask


#: Each node has a domain of its own: nothing of one test is heard in another. From 102 on their ports
#: are those that Linux gives to others.
DOMAINS = itertools.cycle(range(20, 100))


class Node:
    """The node as a process, with what it has said so far."""

    def __init__(self, *arguments: object, folder: Path = ROOT) -> None:
        self.domain = next(DOMAINS)
        own = {name: value for name, value in os.environ.items() if name != "GRASP_INDEX"}
        own |= {"ROS_DOMAIN_ID": str(self.domain)}
        command = [str(program()), *map(str, arguments)]
        self.process = subprocess.Popen(command, env=own, stderr=subprocess.PIPE, text=True, cwd=folder)
        self.lines: list[str] = []
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self.lines.append(line.rstrip("\n"))

    def said(self, words: str) -> list[str]:
        return [line for line in self.lines if words in line]

    def wait_for(self, words: str, timeout: float = 30.0) -> str:
        """The first line that has these words."""
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            if found := self.said(words):
                return found[0]
            assert self.process.poll() is None, self.lines
            time.sleep(0.02)
        raise AssertionError(f"{words!r} was not said: {self.lines}")

    def stop(self, by: signal.Signals = signal.SIGINT) -> dict[str, int]:
        """Ends it as Ctrl-C does, and returns what it has counted."""
        self.process.send_signal(by)
        assert self.process.wait(timeout=20) == 0, self.lines
        self.reader.join(timeout=5)
        line = self.said("answered:")[-1]
        found = re.search(
            r"(\d[\d,]*) pictures? answered: (\d+) recognised, (\d+) unknown, (\d+) without a hand; "
            r"(\d+) dropped for newer ones, (\d+) not to be read",
            line,
        )
        assert found, line
        names = ["answered", "recognised", "unknown", "empty", "dropped", "unreadable"]
        return dict(zip(names, (int(number.replace(",", "")) for number in found.groups()), strict=True))


@pytest.fixture
def node() -> Iterator[Callable[..., Node]]:
    """Starts a node and waits until it reads pictures; ends it after the test."""
    started: list[Node] = []

    def start(*arguments: object) -> Node:
        started.append(Node(*arguments))
        started[-1].wait_for("pictures from")
        return started[-1]

    yield start
    for one in started:
        if one.process.poll() is None:
            one.process.kill()
            one.process.wait()


def checked(detection: object, pose: object, record: dict) -> None:
    """That messages say of a hand exactly what the program's record says."""
    told = [(result.hypothesis.class_id, result.hypothesis.score) for result in detection.results]
    assert told == [(kind["grasp"], kind["probability"]) for kind in record["classes"]]
    turned = pose.pose.orientation
    assert [turned.x, turned.y, turned.z, turned.w] == record["orientation"]["quaternion_xyzw"]


def told(sent: int, ages: list[float], counted: dict[str, int]) -> str:
    """How many of the pictures that were sent were answered, and how soon, in a line."""
    ages = sorted(ages)
    p50, p99, most = (1e3 * ages[min(len(ages) - 1, int(share * len(ages)))] for share in (0.5, 0.99, 1.0))
    lost = sent - counted["answered"] - counted["dropped"]
    return (
        f"{sent} sent, {counted['answered']} answered, {counted['dropped']} dropped for newer ones, {lost} lost; "
        f"from writing to reading p50 {p50:.1f} ms, p99 {p99:.1f} ms, at most {most:.1f} ms"
    )
