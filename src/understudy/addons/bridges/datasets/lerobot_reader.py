"""Data sets in LeRobot's format read as records: our own, and those of others, whose frames are ticks."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.addons.bridges.datasets.demonstrations import NO_LEVEL, parse_kinds, parse_presses
from understudy.addons.bridges.datasets.lerobot import ACTION, FORMAT_VERSION, POSE, STATE, TIME
from understudy.errors import FileError
from understudy.records.record import Episode, Record, describe_labels
from understudy.runtime.body import Channel
from understudy.storage.parquet import read_parquet_rows

INFO = "meta/info.json"
REMEDY = "name the folder of a LeRobotDataset of format v3.0"


def is_lerobot(folder: Path | str) -> bool:
    """Return whether a folder has a data set in LeRobot's format."""
    return (Path(folder) / INFO).is_file()


def read_lerobot(folder: Path | str) -> list[Record]:
    """Read a record of each episode of a data set in LeRobot's format (LeRobotDataset v3.0).

    The columns of `observation.state` are readings and those of `action` commands. Images are left out. Kinds and units
    of readings, states of all levels, presses, and who ran what are in data sets that `write_lerobot` wrote.

    Parameters
    ----------
    folder
        The folder of the data set.

    Returns
    -------
    list of Record
        The records in order.

    Raises
    ------
    FileError
        If a file is missing or damaged, or the data set is of another format.
    """
    folder = Path(folder)
    info = _read_info(folder)
    features = info["features"]
    frames: dict[int, list[dict[str, Any]]] = {}
    for path in sorted(folder.glob("data/chunk-*/file-*.parquet")):
        rows, titles, _ = read_parquet_rows(path)
        for row in rows:
            frame = dict(zip(titles, row, strict=True))
            frames.setdefault(frame["episode_index"], []).append(frame)
    if not frames:
        raise FileError(path=folder, place="data", problem="there are no frames", remedy=REMEDY)
    about = _read_episode_table(folder)
    try:
        return [
            _make_record(
                folder,
                features,
                1 / info["fps"],
                sorted(each, key=lambda frame: frame["index"]),
                about.get(number, {}),
            )
            for number, each in sorted(frames.items())
        ]
    except (KeyError, TypeError, ValueError, IndexError, ZeroDivisionError) as error:
        problem = f"a frame is not as {INFO} says ({type(error).__name__}: {error})"
        raise FileError(path=folder, place="data", problem=problem, remedy="restore it") from None


def _read_info(folder: Path) -> dict[str, Any]:
    try:
        info: dict[str, Any] = json.loads((folder / INFO).read_text("utf-8"))
        version = info["codebase_version"]
        missing = [name for name in (STATE, ACTION) if name not in info["features"]]
    except (OSError, ValueError, KeyError, TypeError) as error:
        problem = f"it cannot be read ({type(error).__name__}: {error})"
        raise FileError(path=folder / INFO, place="", problem=problem, remedy=REMEDY) from None
    if version != FORMAT_VERSION:
        remedy = f"convert it to {FORMAT_VERSION} with LeRobot"
        raise FileError(
            path=folder / INFO, place="codebase_version", problem=f"is {version!r}", remedy=remedy
        )
    if missing:
        raise FileError(
            path=folder / INFO, place="features", problem=f"have no {missing[0]!r}", remedy=REMEDY
        )
    return info


def _read_episode_table(folder: Path) -> dict[int, dict[str, Any]]:
    """Read what the data set says about each episode, by its number."""
    about = {}
    for path in sorted(folder.glob("meta/episodes/chunk-*/file-*.parquet")):
        rows, titles, _ = read_parquet_rows(path)
        for row in rows:
            entry = dict(zip(titles, row, strict=True))
            about[entry["episode_index"]] = entry
    return about


def _make_record(
    folder: Path,
    features: Mapping[str, Any],
    tick_s: float,
    frames: Sequence[Mapping[str, Any]],
    about: Mapping[str, Any],
) -> Record:
    readings, commands = (_list_names(features[name], name) for name in (STATE, ACTION))
    states, actions = (_stack(frames, name) for name in (STATE, ACTION))
    info = features[STATE].get("info") or {}
    keys, described, targets = describe_labels(
        readings, parse_kinds(info.get("kinds"), readings), info.get("units") or [""] * len(readings)
    )
    times = [frame[TIME] if TIME in frame else frame["timestamp"] for frame in frames]
    place = features[POSE]["names"] if POSE in features else ()
    poses = _stack(frames, POSE) if place else np.zeros((len(frames), 0))
    are_states = features[ACTION].get("info") is None and "state_0" in features
    if are_states and commands == features["state_0"]["info"]["labels"]:
        commands, actions = [], np.zeros((len(frames), 0))  # a run without commands, whose actions are states
    channel_units = (features[ACTION].get("info") or {}).get("units", [""] * len(commands))
    are_known = None not in (info.get("kinds") or [None])
    unknown = f"{folder}: it does not say units and kinds of readings; numbers were taken as distances, not as angles"
    return Record(
        times=np.array(times, np.float64),
        values={key: states[:, column] for column, key in enumerate(keys)},
        commands=actions,
        channels=tuple(Channel(name, unit=unit) for name, unit in zip(commands, channel_units, strict=True)),
        readings=described,
        targets=targets,
        tick_s=tick_s,
        episodes=(Episode(folder.name, 0, len(frames)),),
        omissions=() if are_known else (unknown,),
        states=tuple(_list_states(features, frame) for frame in frames),
        presses=parse_presses(about.get("presses") or ()),
        pose={name: poses[:, column] for column, name in enumerate(place)},
        agent=about.get("agent") or "robot 0",
        source=str(folder),
        seed=about.get("seed"),
        behavior=about.get("behavior") or "",
        kinds_known=are_known,
    )


def _list_names(feature: Mapping[str, Any], name: str) -> list[str]:
    """List the names of the columns of a feature; those that have none are numbered."""
    names = feature.get("names")
    if isinstance(names, Mapping):  # as some data sets of others have them, in groups
        columns = [(group, each) for group, members in names.items() for each in members]
        members = [each for _, each in columns]
        names = [each if members.count(each) == 1 else f"{group}.{each}" for group, each in columns]
    count = feature["shape"][0]
    return (
        list(names)
        if names is not None and len(names) == count
        else [f"{name}.{row}" for row in range(count)]
    )


def _stack(frames: Sequence[Mapping[str, Any]], name: str) -> NDArray[np.float64]:
    return np.array([np.atleast_1d(frame[name]) for frame in frames], np.float64)


def _list_states(features: Mapping[str, Any], frame: Mapping[str, Any]) -> tuple[str, ...]:
    """List the states of all levels of a frame."""
    path: list[str] = []
    while (name := f"state_{len(path)}") in features and frame[name] != NO_LEVEL:
        path.append(features[name]["info"]["labels"][frame[name]])
    return tuple(path)
