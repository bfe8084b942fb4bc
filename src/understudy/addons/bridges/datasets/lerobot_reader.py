"""Data sets in LeRobot's format read as episodes: our own, and those of others, whose frames are ticks."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.addons.bridges.datasets.demonstrations import NO_LEVEL
from understudy.addons.bridges.datasets.lerobot import ACTION, FORMAT_VERSION, POSE, STATE, TIME
from understudy.errors import FileError
from understudy.judging.episodes.episode import Episode, EpisodePress
from understudy.model.lesson import ExampleKind
from understudy.model.value_kinds import Continuous, Kind, parse_kind
from understudy.storage.parquet import read_parquet_rows

INFO = "meta/info.json"
REMEDY = "name the folder of a LeRobotDataset of format v3.0"


def is_lerobot(folder: Path | str) -> bool:
    """Return whether a folder has a data set in LeRobot's format."""
    return (Path(folder) / INFO).is_file()


def read_lerobot(folder: Path | str) -> list[Episode]:
    """Read the episodes of a data set in LeRobot's format (LeRobotDataset v3.0).

    The columns of `observation.state` are readings and those of `action` commands. Images are left out. Kinds and units
    of readings, states of all levels, presses, and who ran what are in data sets that `write_lerobot` wrote.

    Parameters
    ----------
    folder
        The folder of the data set.

    Returns
    -------
    list of Episode
        The episodes in order.

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
            _make_episode(
                folder,
                features,
                1 / info["fps"],
                sorted(each, key=lambda frame: frame["index"]),
                about.get(number, {}),
            )
            for number, each in sorted(frames.items())
        ]
    except (KeyError, TypeError, ValueError, IndexError) as error:
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


def _make_episode(
    folder: Path,
    features: Mapping[str, Any],
    tick_s: float,
    frames: Sequence[Mapping[str, Any]],
    about: Mapping[str, Any],
) -> Episode:
    readings, commands = (_list_names(features[name], name) for name in (STATE, ACTION))
    states, actions = (_stack(frames, name) for name in (STATE, ACTION))
    info = features[STATE].get("info") or {}
    kinds = info.get("kinds") or [None] * len(readings)
    times = [frame[TIME] if TIME in frame else frame["timestamp"] for frame in frames]
    place = features[POSE]["names"] if POSE in features else ()
    poses = _stack(frames, POSE) if place else np.zeros((len(frames), 0))
    return Episode(
        agent=about.get("agent") or "robot 0",
        tick_s=tick_s,
        times=np.array(times, np.float64),
        states=tuple(_list_states(features, frame) for frame in frames),
        readings={name: states[:, column] for column, name in enumerate(readings)},
        kinds={name: _parse_kind(kind, name) for name, kind in zip(readings, kinds, strict=True)},
        units=dict(zip(readings, info["units"], strict=True)) if "units" in info else {},
        commands={name: actions[:, column] for column, name in enumerate(commands)},
        channel_units=dict(
            zip(
                commands, (features[ACTION].get("info") or {}).get("units", [""] * len(commands)), strict=True
            )
        ),
        pose={name: poses[:, column] for column, name in enumerate(place)},
        presses=tuple(
            EpisodePress(
                each["tick"],
                each["state"],
                each["correction"],
                None if each["kind"] is None else ExampleKind(each["kind"]),
            )
            for each in about.get("presses") or ()
        ),
        source=str(folder),
        seed=about.get("seed"),
        behavior=about.get("behavior") or "",
    )


def _parse_kind(kind: str | None, name: str) -> Kind:
    return Continuous() if kind is None else parse_kind(kind, where=name)


def _list_names(feature: Mapping[str, Any], name: str) -> list[str]:
    """List the names of the columns of a feature; those that have none are numbered."""
    names = feature.get("names")
    if isinstance(names, Mapping):  # as some data sets of others have them, in groups
        names = [each for group in names.values() for each in group]
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
