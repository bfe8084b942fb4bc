"""Frames: the world at one moment as bytes that a page reads without parsing; all little-endian.

header, N robots, K objects, F feature values (f32, absent is NaN), the number of sonar readings (u16), those (f32),
and the food that all robots brought home (u32)

A body that draws itself has pictures as well: one byte, PICTURE, and a JPEG.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.sim.view import WorldView
from understudy.viz.picture_files import encode_jpeg

KIND, PICTURE = 1, 2
PAUSED, TESTING, OPEN = 1, 2, 4
NONE = 65535
"""No state."""

HEADER = np.dtype(
    [
        ("kind", "u1"),
        ("bits", "u1"),
        ("robots", "<u2"),
        ("objects", "<u2"),
        ("features", "<u2"),
        ("time_s", "<f8"),
        ("state", "<u2"),
        ("agent", "<u2"),
        ("tick", "<u4"),
    ]
)
ROBOT = np.dtype([("x", "<f4"), ("y", "<f4"), ("heading", "<f4"), ("stored", "<u2"), ("doing", "<u2")])
OBJECT = np.dtype(
    [("slot", "<u2"), ("kind", "<u2"), ("x", "<f4"), ("y", "<f4"), ("amount", "<u2"), ("at_first", "<u2")]
)


def encode_frame(
    view: WorldView,
    *,
    tick: int,
    agent: int,
    bits: int = 0,
    state: int = NONE,
    features: Sequence[float] = (),
    sonar: Sequence[float] = (),
    doing: Sequence[int] = (),
) -> bytes:
    """Encode the world at one moment as bytes; `state` is the index of the state of robot `agent`.

    `doing` holds one activity number per robot; it may be empty.
    """
    header = np.zeros((), HEADER)
    counts = len(view.robots), len(view.objects), len(features)
    header[()] = (KIND, bits, *counts, view.time_s, state, agent, tick & 0xFFFFFFFF)
    robots = np.zeros(len(view.robots), ROBOT)
    for name in ("x", "y", "heading"):
        robots[name] = getattr(view.robots, name)
    robots["stored"] = _small(view.robots.stored)
    robots["doing"] = NONE
    if agent < len(robots):
        robots["doing"][agent] = state
    if doing:
        robots["doing"] = doing
    objects = np.zeros(len(view.objects), OBJECT)
    for name in ("x", "y"):
        objects[name] = getattr(view.objects, name)
    for name in ("slot", "kind", "amount", "at_first"):
        objects[name] = _small(getattr(view.objects, name))
    parts = (header, robots, objects, _floats(features))
    sonars, home = len(sonar).to_bytes(2, "little"), int(view.robots.delivered.sum()).to_bytes(4, "little")
    return b"".join([*(part.tobytes() for part in parts), sonars, _floats(sonar).tobytes(), home])


def encode_picture(picture: NDArray[np.uint8]) -> bytes:
    """Encode a picture [height, width, 3] as bytes."""
    return bytes([PICTURE]) + encode_jpeg(picture)


def _small(numbers: NDArray[np.integer[Any]]) -> NDArray[np.uint16]:
    small: NDArray[np.uint16] = np.clip(numbers, 0, NONE).astype(np.uint16)
    return small


def _floats(numbers: Sequence[float]) -> NDArray[np.float32]:
    return np.asarray(numbers, "<f4")
