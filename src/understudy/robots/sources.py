"""Sources: the topics of a robot's file that become readings - numbers of messages, colors in images, places."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from understudy.errors import UnderstudyError
from understudy.model.features import ReadingKey
from understudy.robots.camera.config import CAMERA, CameraOf
from understudy.robots.camera.live_camera import Eye
from understudy.robots.robot_file import RobotFile
from understudy.robots.ros.fields import Extract, extraction, place
from understudy.robots.ros.transport import ExtraMissing
from understudy.runtime.body import Reading
from understudy.sim.kit import CAMERA as BLOBS
from understudy.sim.scenario.toml_decode import Mismatch

Values: TypeAlias = Callable[[Any], Mapping[ReadingKey, float]]
PLACE = ("x", "y")
"""What a source says of a target that is in some place; what robots read of it is worked out from that."""


@dataclass(frozen=True, slots=True)
class Source:
    """What of a topic becomes readings. Where `always`, each of its messages that is right holds all of them."""

    name: str
    topic: str
    type: str
    stale_s: float
    rate_hz: float | None
    required: bool
    always: bool
    keys: Sequence[ReadingKey]
    readings: Sequence[Reading]
    extract: Values


def sources(file: RobotFile, eye: Eye | None, targets: Sequence[str]) -> Sequence[Source] | Mismatch:
    """All of a file, in its order, with what its eye sees of these targets; or what in it cannot be."""
    found: list[Source] = []
    for made in (*_numbers(file), *_places(file)):
        if isinstance(made, Mismatch):
            return made
        found.append(made)
    if eye is not None and file.camera is not None:
        found.append(_images(file.camera, eye, targets))
    return tuple(found)


def eye_of(file: RobotFile) -> Eye | Mismatch | None:
    """What looks at the images of a file's camera, if there is one; or what of it cannot be."""
    if file.camera is None:
        return None
    try:
        return Eye(file.camera)
    except ExtraMissing:  # it is not the file that is wrong
        raise
    except UnderstudyError as error:
        return Mismatch(CAMERA, f"cannot be: {error}", "correct it there")


def _numbers(file: RobotFile) -> Iterator[Source | Mismatch]:
    for name, reading in file.readings.items():
        taken = extraction(reading)
        if isinstance(taken, Mismatch):
            yield Mismatch(f"readings.{name}.{taken.key}", taken.problem, taken.remedy)
            return
        kind, unit, extract = taken
        yield Source(
            name, reading.topic, reading.type, reading.stale_s, reading.rate_hz, reading.required, True,
            ((name, None),), (Reading(name, kind, unit, doc=reading.doc),), _of_number(name, extract),
        )  # fmt: skip


def _of_number(name: str, extract: Extract) -> Values:
    return lambda message: {(name, None): extract(message)}


def _images(of: CameraOf, eye: Eye, targets: Sequence[str]) -> Source:
    """What is seen of colors, and of targets that may get one while it runs."""
    keys = tuple((blob.name, name) for name in dict.fromkeys((*of.colors, *targets)) for blob in BLOBS)
    return Source(
        CAMERA, of.topic, of.type, of.stale_s, of.rate_hz, of.required, False, keys, BLOBS, eye.see
    )  # fmt: skip


def _places(file: RobotFile) -> Iterator[Source | Mismatch]:
    """Targets that a topic tells of."""
    for name, target in file.targets.items():
        if target.topic is None:
            continue
        taken = place(target)
        if isinstance(taken, Mismatch):
            yield Mismatch(f"targets.{name}.{taken.key}", taken.problem, taken.remedy)
            return
        keys: Sequence[ReadingKey] = tuple((axis, name) for axis in PLACE)
        yield Source(
            f"targets.{name}", target.topic, target.type, target.stale_s, target.rate_hz, target.required, True,
            keys, (), _of_place(keys, taken),
        )  # fmt: skip


def _of_place(keys: Sequence[ReadingKey], taken: Callable[[Any], tuple[float, float]]) -> Values:
    return lambda message: dict(zip(keys, taken(message), strict=True))
