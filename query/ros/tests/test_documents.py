"""What the guide and the help show starts, and the launch file and RViz's say what the node is."""

from __future__ import annotations

import importlib.util
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest
import yaml
from conftest import ROOT, Node, program

GUIDE = ROOT / "docs" / "ros.md"
HERE = ROOT / "query" / "ros"


def helped() -> str:
    wide = os.environ | {"COLUMNS": "200"}
    told = subprocess.run(
        [program(), "--help"], capture_output=True, text=True, timeout=20, check=True, env=wide
    )
    return told.stdout


def commands() -> Iterator[str]:
    guide = "\n".join(line for line in GUIDE.read_text().splitlines() if line.startswith("    "))
    examples = helped().split("Examples:\n")[1].split("\n\n")[0]
    for line in f"{guide}\n{examples}".replace("\\\n", " ").splitlines():
        if line.strip().startswith("grasp-ros "):
            yield " ".join(line.split())


@pytest.fixture
def place(index: Path, tmp_path: Path) -> Path:
    """A folder as the guide's reader has it."""
    (tmp_path / "query").symlink_to(ROOT / "query")
    shutil.copy(index, tmp_path / "grasp.idx")
    return tmp_path


def test_what_the_guide_and_the_help_show_starts(place: Path) -> None:
    shown = sorted(set(commands()))
    assert len(shown) >= 6
    for command in shown:
        node = Node(*shlex.split(command)[1:], folder=place)
        node.wait_for("pictures from")
        node.stop()


def test_the_guide_names_every_parameter_and_topic() -> None:
    guide, told = GUIDE.read_text(), helped()
    for option in re.findall(r"^      --([a-z-]+)", told, flags=re.MULTILINE):
        if option not in ("help", "version"):
            assert f"`{option.replace('-', '_')}`" in guide, option
    for topic in re.findall(r"^  (\S+),? .*(?:read|published)$", told, flags=re.MULTILINE):
        assert f"`{topic.rstrip(',')}`" in guide, topic


class Told:
    """Stands for whatever a launch file makes, and keeps what it was made with."""

    def __init__(self, *arguments: object, **keywords: object) -> None:
        self.arguments, self.keywords = arguments, keywords


@pytest.fixture
def launched(monkeypatch: pytest.MonkeyPatch) -> list[Told]:
    """What the launch file describes; ROS's own packages for it are on no registry."""
    for name, kinds in {
        "launch": ["LaunchDescription"],
        "launch.actions": ["DeclareLaunchArgument"],
        "launch.conditions": ["IfCondition"],
        "launch.substitutions": ["LaunchConfiguration"],
        "launch_ros": [],
        "launch_ros.actions": ["Node"],
    }.items():
        module = ModuleType(name)
        for kind in kinds:
            setattr(module, kind, type(kind, (Told,), {}))
        monkeypatch.setitem(sys.modules, name, module)
    spec = importlib.util.spec_from_file_location("launched", HERE / "launch" / "grasp.launch.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return list(module.generate_launch_description().arguments[0])


def test_the_launch_file_starts_the_node(launched: list[Told], place: Path) -> None:
    declared = {
        told.arguments[0]: told.keywords["default_value"]
        for told in launched
        if type(told).__name__ == "DeclareLaunchArgument"
    }
    node, rviz = (told for told in launched if type(told).__name__ == "Node")

    def value(told: object) -> str:
        return declared[told.arguments[0]] if isinstance(told, Told) else str(told)

    assert value(node.keywords["executable"]) == "grasp-ros"
    assert Path(rviz.keywords["arguments"][1]).is_file()
    # As ROS starts it: parameters come in a file, everything else behind --ros-args.
    (parameters,) = node.keywords["parameters"]
    told = {name: yaml.safe_load(value(default) or "''") for name, default in parameters.items()}
    file = place / "parameters.yaml"
    file.write_text(yaml.safe_dump({"/**": {"ros__parameters": told}}))
    remaps = [f"{name}:={value(to)}" for name, to in node.keywords["remappings"]]
    words = ["--ros-args", "-r", f"__node:={node.keywords['name']}", "--params-file", str(file)]
    started = Node(*words, *(word for remap in remaps for word in ("-r", remap)), folder=place)
    line = started.wait_for("pictures from")
    assert declared["image"] in line and "/grasp/detections" in line
    assert not started.said("ignored")
    started.stop()


def test_rviz_shows_the_nodes_topics() -> None:
    described = yaml.safe_load((HERE / "rviz" / "grasp.rviz").read_text())
    shown = described["Visualization Manager"]["Displays"]
    topics = {
        display["Class"].split("/")[1]: (display["Topic"]["Value"], display["Topic"]["Reliability Policy"])
        for display in shown
        if "Topic" in display
    }
    assert topics == {
        "Image": ("/camera/image_raw", "Best Effort"),
        "MarkerArray": ("/grasp/markers", "Reliable"),
        "Pose": ("/grasp/pose", "Reliable"),
    }
