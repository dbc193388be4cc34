"""The compiled half of the package. What the signatures mean is in the docstrings."""

import os
from collections import abc
from collections.abc import Callable, Iterable, Mapping
from types import TracebackType
from typing import Any, Literal, final, overload

import numpy
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self

from .answer import Answer
from .errors import PictureError

__all__ = ["Found", "Index", "Recogniser", "Sequence", "build", "strategy"]

_Path = str | os.PathLike[str]
_Picture = _Path | NDArray[numpy.uint8]

@final
class Index:
    def __new__(cls, path: _Path, *, mmap: bool = True) -> Self: ...
    def search(
        self,
        queries: ArrayLike,
        k: int = 10,
        recall: float = 0.95,
        exact: bool = False,
        *,
        threads: int | None = None,
    ) -> tuple[NDArray[numpy.int64], NDArray[numpy.float32]]: ...
    def entry(self, id: int) -> dict[str, Any]: ...
    def info(self) -> dict[str, Any]: ...
    @property
    def dim(self) -> int: ...
    @property
    def path(self) -> str: ...
    @property
    def closed(self) -> bool: ...
    def close(self) -> None: ...
    def __len__(self) -> int: ...
    def __getnewargs_ex__(self) -> tuple[tuple[_Path], dict[str, Any]]: ...
    def __enter__(self) -> Self: ...
    def __exit__(
        self,
        kind: type[BaseException] | None = ...,
        error: BaseException | None = ...,
        traceback: TracebackType | None = ...,
        /,
    ) -> None: ...

@final
class Recogniser:
    def __new__(
        cls,
        index: Index | _Path,
        hand: Literal["auto", "left", "right"] = "auto",
        *,
        segment: Literal["scene", "skin"] = "scene",
        recall: float = 0.95,
        exact: bool = False,
        accept: Literal["calibrated", "always"] = "calibrated",
        k: int | None = None,
        rolls: int = 1,
        thorough: bool = False,
    ) -> Self: ...
    @property
    def index(self) -> Index: ...
    def recognise(
        self,
        image: _Picture,
        mask: _Path | NDArray[numpy.bool_] | NDArray[numpy.uint8] | None = None,
        *,
        landmarks: ArrayLike | None = None,
        landmark_unit: Literal["pixel", "share"] = "pixel",
        segmented: bool = False,
        depth: _Path | NDArray[numpy.uint16] | None = None,
        depth_range: tuple[int, int] | None = None,
    ) -> Answer: ...
    @overload
    def recognise_batch(
        self,
        images: Iterable[_Picture],
        *,
        segmented: bool = False,
        errors: Literal["raise"] = "raise",
        threads: int | None = None,
    ) -> list[Answer]: ...
    @overload
    def recognise_batch(
        self,
        images: Iterable[_Picture],
        *,
        segmented: bool = False,
        errors: Literal["return"],
        threads: int | None = None,
    ) -> list[Answer | PictureError]: ...
    def __getnewargs_ex__(self) -> tuple[tuple[Index], dict[str, Any]]: ...

@final
class Sequence:
    def __new__(cls, recogniser: Recogniser, *, switch: float = 0.2, motion_deg: float = 5.0) -> Self: ...
    @property
    def recogniser(self) -> Recogniser: ...
    def recognise(
        self,
        image: _Picture,
        mask: _Path | NDArray[numpy.bool_] | NDArray[numpy.uint8] | None = None,
        *,
        segmented: bool = False,
    ) -> Answer: ...
    def clear(self) -> None: ...

@final
class Found:
    def explain(self) -> NDArray[numpy.uint8]: ...

def build(
    vectors: ArrayLike,
    path: _Path,
    labels: abc.Sequence[str] | NDArray[numpy.str_] | None = None,
    progress: Callable[[str, float], object] | None = None,
    seed: int = 0,
    *,
    cutkosky: Mapping[str, int] | None = None,
    held_out: ArrayLike | None = None,
    hash: Literal["learned", "random"] = "learned",
    originals: Literal["f32", "f16", "none"] = "f32",
    threads: int | None = None,
) -> Index: ...
def strategy(
    grasp: str,
    hand: str,
    quaternion_xyzw: abc.Sequence[float],
    spread_deg: float,
    robot: str,
    object: _Path,
    camera: _Path,
    arm: str | None = None,
) -> str: ...
