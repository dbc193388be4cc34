"""The other side of the node's topics, over CycloneDDS."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import messages
from cyclonedds.core import Listener, Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

#: As ROS has sensor data: what is lost is lost, the newest counts.
SENSOR = Qos(
    Policy.Reliability.BestEffort,
    Policy.History.KeepLast(1),
    Policy.DataRepresentation(use_cdrv0_representation=True),
)
#: As answers are published.
RELIABLE = Qos(
    Policy.Reliability.Reliable(duration(seconds=1)),
    Policy.History.KeepLast(50),
    Policy.DataRepresentation(use_cdrv0_representation=True),
)


class Heard:
    """What a topic has brought, each message with the time of its coming."""

    def __init__(self) -> None:
        self.messages: list[tuple[float, object]] = []
        self.changed = threading.Condition()

    def add(self, message: object) -> None:
        with self.changed:
            self.messages.append((time.perf_counter(), message))
            self.changed.notify_all()

    def wait(self, enough: Callable[[list], bool], timeout: float = 20.0) -> list:
        """The messages so far, once there are enough of them."""
        with self.changed:
            done = self.changed.wait_for(lambda: enough([m for _, m in self.messages]), timeout)
            found = [message for _, message in self.messages]
        assert done, f"{len(found)} messages came in {timeout} s"
        return found


class _OnData(Listener):
    def __init__(self, heard: Heard) -> None:
        super().__init__()
        self.heard = heard

    def on_data_available(self, reader: DataReader) -> None:
        for message in reader.take(N=50):
            if hasattr(message, "__dataclass_fields__") and type(message).__module__ == "messages":
                self.heard.add(message)


class Peer:
    """A participant in a domain."""

    def __init__(self, domain: int) -> None:
        self.participant = DomainParticipant(domain)
        self.kept: list[object] = []

    def writer(self, topic: str, kind: type, qos: Qos = SENSOR) -> DataWriter:
        """A writer of a ROS topic by its full name, which somebody reads already."""
        writer = DataWriter(self.participant, Topic(self.participant, f"rt{topic}", kind, qos=qos), qos=qos)
        self._matched(lambda: writer.get_matched_subscriptions(), topic)
        return writer

    def reader(self, topic: str, kind: type, qos: Qos = RELIABLE) -> Heard:
        """What a ROS topic brings from now on; somebody writes it already."""
        heard = Heard()
        listener = _OnData(heard)
        named = Topic(self.participant, f"rt{topic}", kind, qos=qos)
        reader = DataReader(self.participant, named, qos=qos, listener=listener)
        self.kept += [reader, listener]
        self._matched(lambda: reader.get_matched_publications(), topic)
        return heard

    @staticmethod
    def _matched(matches: Callable[[], list], topic: str) -> None:
        end = time.monotonic() + 20
        while not matches():
            assert time.monotonic() < end, f"nobody else is on {topic}"
            time.sleep(0.02)
        # The other side hears of this one as soon, but not at the same time.
        time.sleep(0.5)


def header(number: int, frame: str = "camera_optical") -> messages.Header:
    """The header of a picture by its number, which comes back in the stamps of its answers."""
    return messages.Header(stamp=messages.Time(sec=1000 + number, nanosec=number), frame_id=frame)


def number_of(message: object) -> int:
    """The number of the picture that a message answers."""
    return message.header.stamp.sec - 1000
