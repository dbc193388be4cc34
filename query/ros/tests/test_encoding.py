"""The bytes that the node's own tests hold its messages against."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import SimpleNamespace

import golden
import pytest
import samples

LINES = dict(line.split() for line in (Path(__file__).parent / "golden.txt").read_text().splitlines())
#: Packages that there are as wheels.
OF_ROS = ["builtin_interfaces", "std_msgs", "geometry_msgs", "sensor_msgs", "visualization_msgs"]


def test_golden_bytes_are_what_cyclonedds_writes() -> None:
    assert LINES == dict(line.split() for line in golden.lines())


@pytest.mark.parametrize("name", [name for name in samples.BUILDERS if name.split("/")[0] in OF_ROS])
def test_ros_itself_reads_and_writes_the_golden_bytes(name: str) -> None:
    serialization = importlib.import_module("rclpy.serialization")
    kinds = SimpleNamespace()
    for package in reversed(OF_ROS):
        vars(kinds).update(vars(importlib.import_module(f"{package}.msg")))
    sample = samples.message(kinds, name)
    written = bytes.fromhex(LINES[name])
    assert serialization.deserialize_message(written, type(sample)) == sample
    # What ROS writes between fields, to align them, is anything.
    assert len(serialization.serialize_message(sample)) == len(written)
