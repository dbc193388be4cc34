"""What a robot does to make the same grasp."""

from __future__ import annotations

import json
import os
from typing import Any

from . import _native
from .answer import Answer
from .errors import GraspError

__all__ = ["strategy"]


def strategy(
    answer: Answer,
    robot: str = "barrett",
    *,
    object: str | os.PathLike[str],
    camera: str | os.PathLike[str],
    arm: str | None = None,
) -> dict[str, Any]:
    """Plan how a robot imitates a recognised grasp.

    Parameters
    ----------
    answer : Answer
        What was recognised. What is unknown is not imitated.
    robot : str, default "barrett"
        The robot hand: ``allegro``, ``barrett``, ``franka-hand``, ``parallel-gripper``,
        ``robotiq-2f-85``, or a file that describes another (HAND.toml, or HAND.urdf with a
        HAND.toml beside it).
    object : str or os.PathLike
        The object's file: its shape, size and pose (OBJECT.toml).
    camera : str or os.PathLike
        The camera's file: its pose, and where it saw the hand (CAMERA.toml).
    arm : str, optional
        The arm that carries the hand: ``franka-panda``, ``kuka-kr6-r700``, ``ur5e``, or a file
        (ARM.toml).

    Returns
    -------
    dict
        What stands under ``strategy`` in the record of ``grasp-query recognise --robot``;
        metres, radians, newtons, quaternions x, y, z, w. ``feasible`` says whether it can be
        tried, and ``problems`` why not.

    Raises
    ------
    GraspError
        Where the grasp is unknown, a file is no such description, or the hand has no
        counterpart of the grasp.
    """
    record = answer.to_dict()
    if record["reason"] is not None:
        raise GraspError(f"the grasp is unknown ({record['reason']}), and what is unknown is not imitated")
    seen = record["orientation"]
    made = _native.strategy(
        record["grasp"],
        record["hand"],
        seen["quaternion_xyzw"],
        seen["spread_deg"],
        os.fspath(robot),
        object,
        camera,
        None if arm is None else os.fspath(arm),
    )
    return json.loads(made)
