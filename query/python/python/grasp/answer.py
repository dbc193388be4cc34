"""What was recognised in a picture."""

from __future__ import annotations

import html
import json
from typing import TYPE_CHECKING, Any

from .errors import GraspError

if TYPE_CHECKING:
    import numpy
    from numpy.typing import NDArray
    from scipy.spatial.transform import Rotation

    from ._native import Found

__all__ = ["Answer"]


class Answer:
    """The answer for one picture, as `Recogniser` returns it; it cannot be changed.

    It is the record that ``grasp-query recognise --json`` prints, key by key, with the most
    used ones as attributes. It keeps its picture (one to two megabytes) for `explain`;
    `to_dict` has no picture, and neither has a pickled answer.
    """

    __slots__ = ("_found", "_json", "_record")

    def __init__(self, record: str, found: Found | None = None) -> None:
        self._json = record
        self._record: dict[str, Any] = json.loads(record)
        self._found = found

    @property
    def grasp(self) -> str:
        """str: The most probable class, such as ``pinch``; or ``unknown``, see `reason`."""
        return self._record["grasp"]

    @property
    def cutkosky(self) -> int | None:
        """int or None: Its number in Cutkosky's taxonomy; None where it is unknown."""
        return self._record["cutkosky"]

    @property
    def reason(self) -> str | None:
        """str or None: Why the grasp is unknown; None where it is not."""
        return self._record["reason"]

    @property
    def probability(self) -> float:
        """float: The probability of the most probable class, 0 to 1."""
        return self._record["probability"]

    @property
    def classes(self) -> dict[str, float]:
        """dict of str to float: The probability of each class, most probable first; sums to 1."""
        return {entry["grasp"]: entry["probability"] for entry in self._record["classes"]}

    @property
    def hand(self) -> str:
        """str: The hand that was recognised, ``left`` or ``right``."""
        return self._record["hand"]

    @property
    def orientation(self) -> tuple[float, float, float, float]:
        """tuple of 4 floats: The rotation ``camera_from_hand`` as a unit quaternion x, y, z, w.

        It turns the axes of the hand (x from the wrist to the middle finger's knuckle, z out of
        its back, y = z cross x) into those of the camera (z forward, x right, y down).
        """
        x, y, z, w = self._record["orientation"]["quaternion_xyzw"]
        return x, y, z, w

    @property
    def spread_deg(self) -> float:
        """float: How far the neighbours disagree about the orientation, in degrees; 180: unknown."""
        return self._record["orientation"]["spread_deg"]

    @property
    def neighbours(self) -> list[dict[str, Any]]:
        """list of dict: The nearest entries, nearest first.

        Each has ``id``, ``file``, ``grasp``, ``cutkosky``, ``hand_shape``, ``stage``, ``object``,
        ``distance`` (between descriptors) and ``quaternion_xyzw``, turned and flipped to the
        picture; None where the index keeps none.
        """
        return self.to_dict()["neighbours"]

    @property
    def warnings(self) -> list[dict[str, str]]:
        """list of dict: What to doubt, each with ``kind``, a stable name, and ``message``."""
        return self.to_dict()["warnings"]

    def rotation(self) -> Rotation:
        """Return the orientation as SciPy's rotation.

        Returns
        -------
        scipy.spatial.transform.Rotation
            ``camera_from_hand``, see `orientation`.

        Raises
        ------
        GraspError
            Where SciPy is not installed.
        """
        try:
            from scipy.spatial.transform import Rotation
        except ImportError as cause:
            message = "rotation() needs SciPy: `pip install scipy`, or take orientation"
            raise GraspError(message) from cause
        return Rotation.from_quat(self.orientation)

    def to_dict(self) -> dict[str, Any]:
        """Return the whole record, as ``grasp-query recognise --json`` prints it.

        Returns
        -------
        dict
            A copy of its own. ``file`` is the path as it was given, or ``array``.
        """
        return json.loads(self._json)

    def explain(self) -> NDArray[numpy.uint8]:
        """Draw how the answer came about: picture, hand, vote, descriptor and neighbours.

        Returns
        -------
        numpy.ndarray of uint8, shape (h, w, 3)
            RGB, what ``grasp-query recognise --explain`` writes.

        Raises
        ------
        GraspError
            Where the answer was pickled: it has no picture any more.
        IndexFileError
            Where the index was changed since.
        """
        if self._found is None:
            raise GraspError("an answer that was pickled has no picture to explain it by: recognise it again")
        return self._found.explain()

    def __reduce__(self) -> tuple[type[Answer], tuple[str]]:
        return Answer, (self._json,)

    def __repr__(self) -> str:
        return f"<grasp.Answer: {self.grasp}, {self.probability:.2f}, {self.hand} hand>"

    def _repr_html_(self) -> str:
        """Return the answer as a table, for notebooks."""
        rows = "".join(
            f"<tr><td>{html.escape(name)}</td><td>{share:.1%}</td>"
            f'<td><div style="background:#48c;height:0.8em;width:{max(share, 0.0) * 12:.2f}em"></div></td></tr>'
            for name, share in self.classes.items()
        )
        seen = self._record["orientation"]
        lines = [f"{self.hand} hand; the camera sees {seen['camera_sees']}, the fingers point {seen['fingers_point']}"]
        lines += [f"Unknown: {self.reason}."] if self.reason else []
        lines += [f"Beware: {warning['message']}." for warning in self.warnings]
        notes = "<br>".join(html.escape(line) for line in lines)
        title = html.escape(f"{self.grasp}: {self._record['file']}")
        return f"<table><caption>{title}</caption>{rows}</table><p>{notes}</p>"
