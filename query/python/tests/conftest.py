"""What all tests stand on: the built programs, and small indexes that they made."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy
import pytest

import grasp

ROOT = Path(__file__).resolve().parents[3]
PICTURES = ROOT / "tests" / "pictures"
CAMERA = PICTURES / "camera" / "02-small-diameter.jpg"
SEGMENTED = PICTURES / "segmented" / "09-pinch.png"

Run = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture(scope="session")
def program() -> Run:
    """Run one of the programs, as ``program("grasp-query", "search", ...)``."""
    folder = Path(os.environ.get("GRASP_PROGRAMS", ROOT / "target" / "debug"))
    environment = {name: value for name, value in os.environ.items() if name != "GRASP_INDEX"}

    def run(name: str, *arguments: object, cwd: Path = ROOT) -> subprocess.CompletedProcess[str]:
        command = [str(folder / name), *map(str, arguments)]
        return subprocess.run(
            command, cwd=cwd, env=environment, capture_output=True, text=True, check=False, timeout=600
        )

    return run


@pytest.fixture(scope="session")
def index_path(program: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An index of pictures of one hand, seen from few sides, described as the default index is."""
    path = tmp_path_factory.mktemp("index") / "small.idx"
    built = program("grasp-builder", "build", "--hands", 1, "--views", 6, "--out", path)
    assert built.returncode == 0, built.stderr
    return path


@pytest.fixture(scope="session")
def recogniser(index_path: Path) -> grasp.Recogniser:
    return grasp.Recogniser(index_path)


@pytest.fixture(scope="session")
def vectors() -> numpy.ndarray:
    """3,000 vectors of 24 values around 40 places."""
    random = numpy.random.default_rng(1)
    places = random.normal(size=(40, 24))
    near = places[random.integers(40, size=3000)] + 0.3 * random.normal(size=(3000, 24))
    return near.astype(numpy.float32)


@pytest.fixture(scope="session")
def queries(vectors: numpy.ndarray) -> numpy.ndarray:
    random = numpy.random.default_rng(2)
    moved = vectors[::15] + 0.05 * random.normal(size=(200, 24))
    return moved.astype(numpy.float32)


@pytest.fixture(scope="session")
def vector_index_path(vectors: numpy.ndarray, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("vectors") / "vectors.idx"
    labels = [("pinch", "power-sphere", "mine")[number % 3] for number in range(len(vectors))]
    grasp.build(vectors, path, labels, cutkosky={"pinch": 9, "power-sphere": 10}).close()
    return path


@pytest.fixture
def index(vector_index_path: Path) -> grasp.Index:
    return grasp.Index(vector_index_path)


def nearest(vectors: numpy.ndarray, queries: numpy.ndarray, k: int) -> tuple[numpy.ndarray, numpy.ndarray]:
    """The true nearest neighbours, by arithmetic in double precision."""
    apart = queries[:, None, :].astype(float) - vectors[None, :, :].astype(float)
    distances = numpy.sqrt((apart**2).sum(axis=2))
    ids = numpy.argsort(distances, axis=1, kind="stable")[:, :k]
    return ids, numpy.take_along_axis(distances, ids, axis=1)


def record_of(outcome: subprocess.CompletedProcess[str]) -> dict:
    """The only record that a program printed."""
    (line,) = outcome.stdout.splitlines()
    return json.loads(line)
