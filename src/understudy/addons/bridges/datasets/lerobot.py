"""Data sets of demonstrations for LeRobot: LeRobotDataset v3.0, written without LeRobot's own package."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.addons.bridges.datasets.demonstrations import (
    Demonstrations,
    gather_demonstrations,
    list_presses,
)
from understudy.addons.bridges.datasets.lerobot_tables import (
    connect_database,
    write_arrays,
    write_names,
    write_rows,
)
from understudy.addons.bridges.datasets.new_folder import create_folder
from understudy.errors import SettingError
from understudy.records.record import Record

Subtasks: TypeAlias = Literal["index", "language"]
"""How a data set spells the subtasks: as LeRobot 0.4 and 0.5 read them, or as LeRobot 0.6 does."""

FORMAT_VERSION = "v3.0"
STATE, ACTION, TIME = "observation.state", "action", "time"
PRESS, POSE, SUBTASK = "press", "pose", "subtask_index"
LANGUAGE = "language_persistent"
LANGUAGE_FIELDS = (
    "role VARCHAR, content VARCHAR, style VARCHAR, timestamp FLOAT, camera VARCHAR, tool_calls VARCHAR[]"
)
INDEXES = ("frame_index", "episode_index", "index", "task_index")
DATA_PATH = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
EPISODES_PATH = "meta/episodes/chunk-000/file-000.parquet"
FILES_PER_CHUNK, MEGABYTES_PER_FILE = 1000, 100
EPISODE_COLUMNS = {
    "episode_index": "BIGINT",
    "tasks": "VARCHAR[]",
    "length": "BIGINT",
    "data/chunk_index": "BIGINT",
    "data/file_index": "BIGINT",
    "dataset_from_index": "BIGINT",
    "dataset_to_index": "BIGINT",
    "meta/episodes/chunk_index": "BIGINT",
    "meta/episodes/file_index": "BIGINT",
    "agent": "VARCHAR",
    "behavior": "VARCHAR",
    "source": "VARCHAR",
    "seed": "BIGINT",
    "presses": "STRUCT(tick BIGINT, state VARCHAR, correction BOOLEAN, kind VARCHAR)[]",
}
"""The columns of the table of episodes, but for statistics: LeRobot's own, then those of an Record."""
QUANTILES = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}


@dataclass(frozen=True, slots=True)
class _Part:
    """The place of one episode in the data set."""

    episode: Record
    number: int
    start: int
    task: int
    file: int


def write_lerobot(
    episodes: Sequence[Record], folder: Path | str, *, task: str = "", subtasks: Subtasks = "index"
) -> None:
    """Write episodes as a data set that LeRobot loads (LeRobotDataset, format v3.0).

    Parameters
    ----------
    episodes
        Records with the same readings, channels and length of ticks. If commands were not recorded, the action has one
        column per state of the outermost automaton, which is 1 while the automaton is in this state, and otherwise 0.
    folder
        A new folder for the data set.
    task
        LeRobot's description of the task in words, for all episodes; by default the name of each episode's automaton.
    subtasks
        How the states of all levels are given as LeRobot's subtasks: "index" writes the column `subtask_index` and
        meta/subtasks.parquet, which LeRobot 0.4 and 0.5 turn into the text `subtask`, and later versions read as any
        column; "language" writes the column `language_persistent`, which only LeRobot 0.6 and later can read.

    Raises
    ------
    DefinitionError
        If the episodes do not fit into one data set.
    FileError
        If the folder exists or cannot be written.
    SettingError
        If `subtasks` is neither "index" nor "language".
    ExtraMissing
        If DuckDB is not installed.
    """
    if subtasks not in ("index", "language"):
        raise SettingError(
            where="a LeRobot data set",
            setting="subtasks",
            problem=f"is {subtasks!r}",
            remedy="choose index or language",
        )
    data = gather_demonstrations(episodes)
    database = connect_database()
    tasks = list(dict.fromkeys(task or _name_task(episode) for episode in data.episodes))
    parts = list(_place_episodes(data, [tasks.index(task or _name_task(each)) for each in data.episodes]))
    tables = [_make_columns(data, part, subtasks) for part in parts]
    with database, create_folder(folder) as output:
        _write_info(output, data, len(tasks), subtasks)
        write_names(database, output / "meta/tasks.parquet", "task", tasks)
        if subtasks == "index":
            write_names(database, output / "meta/subtasks.parquet", "subtask", data.subtasks)
        _write_statistics(output, tables)
        _write_episode_table(database, output, parts, tables, tasks)
        for file in range(parts[-1].file + 1):
            inside = [number for number, part in enumerate(parts) if part.file == file]
            chosen = [parts[number] for number in inside]
            _write_data(database, output, data, chosen, [tables[number] for number in inside], subtasks)


def _name_task(episode: Record) -> str:
    return episode.behavior or "demonstration"


def _place_episodes(data: Demonstrations, tasks: Sequence[int]) -> Iterator[_Part]:
    """Give each episode its first frame and its file, where a file is about as large as LeRobot makes them."""
    per_frame = 8 * (len(data.readings) + len(data.channels) + len(data.levels) + 8)
    start = file = filled = 0
    for number, (episode, task) in enumerate(zip(data.episodes, tasks, strict=True)):
        size = per_frame * episode.ticks
        if filled and filled + size > MEGABYTES_PER_FILE * 2**20:
            file, filled = file + 1, 0
        yield _Part(episode=episode, number=number, start=start, task=task, file=file)
        start, filled = start + episode.ticks, filled + size


def _make_columns(data: Demonstrations, part: _Part, subtasks: Subtasks) -> dict[str, np.ndarray]:
    """Return the columns of an episode: arrays of shape [T] or [T, n]."""
    episode, ticks = part.episode, np.arange(part.episode.ticks)
    columns: dict[str, np.ndarray] = {STATE: data.stack_readings(episode)}
    columns[ACTION] = data.stack_commands(episode) if data.channels else _mark_states(data, episode)
    columns[TIME] = np.asarray(episode.times, dtype=np.float64)
    for level in range(len(data.levels)):
        columns[f"state_{level}"] = data.index_states(episode, level)
    if subtasks == "index":
        columns[SUBTASK] = data.index_subtasks(episode)
    columns[PRESS] = data.mark_presses(episode)
    if data.pose:
        columns[POSE] = data.stack_pose(episode)
    columns["timestamp"] = _make_timestamps(ticks, data)
    columns["frame_index"] = ticks
    columns["episode_index"] = np.full(len(ticks), part.number)
    columns["index"] = part.start + ticks
    columns["task_index"] = np.full(len(ticks), part.task)
    return columns


def _mark_states(data: Demonstrations, episode: Record) -> np.ndarray:
    """Return one column per state of the outermost automaton, shape [T, n]: 1 for the current one, otherwise 0."""
    states = np.arange(len(data.levels[0]))
    return np.equal(data.index_states(episode, 0)[:, np.newaxis], states).astype(np.float64)


def _make_timestamps(ticks: np.ndarray, data: Demonstrations) -> np.ndarray:
    """Return the nominal times that LeRobot expects, float32: ticks divided by frames per second."""
    return (ticks / _frames_per_second(data)).astype(np.float32)


def _frames_per_second(data: Demonstrations) -> int | float:
    """Return the frames per second, a whole number where the tick length allows it, as in LeRobot's own data sets."""
    exact = 1 / data.tick_s
    return round(exact) if round(exact) and abs(exact - round(exact)) < 1e-6 * exact else exact


def _write_info(output: Path, data: Demonstrations, tasks: int, subtasks: Subtasks) -> None:
    frames = sum(episode.ticks for episode in data.episodes)
    info = {
        "codebase_version": FORMAT_VERSION,
        "robot_type": None,
        "total_episodes": len(data.episodes),
        "total_frames": frames,
        "total_tasks": tasks,
        "chunks_size": FILES_PER_CHUNK,
        "data_files_size_in_mb": MEGABYTES_PER_FILE,
        "video_files_size_in_mb": 200,
        "fps": _frames_per_second(data),
        "splits": {"train": f"0:{len(data.episodes)}"},
        "data_path": DATA_PATH,
        "video_path": None,
        "features": _describe_features(data, subtasks),
    }
    _write_json(output / "meta/info.json", info)


def _describe_features(data: Demonstrations, subtasks: Subtasks) -> dict[str, Any]:
    """Describe the columns; `info` is LeRobot's place for what only the writer of a column knows."""
    first = data.episodes[0]
    about: dict[str, Any] = {
        "kinds": data.list_kind_texts(),
        "units": [first.find_unit(key) for key in first.values],
    }
    features: dict[str, Any] = {STATE: _describe("float64", data.readings, about)}
    units = {"units": [each.unit for each in first.channels]} if first.channels else None
    features[ACTION] = _describe("float64", data.channels or data.levels[0], units)
    features[TIME] = _describe("float64")
    for level, names in enumerate(data.levels):
        features[f"state_{level}"] = _describe("int64", info={"labels": list(names)})
    if subtasks == "index":
        features[SUBTASK] = _describe("int64", info={"labels": list(data.subtasks)})
    features[PRESS] = _describe("bool")
    if data.pose:
        features[POSE] = _describe("float64", data.pose)
    features["timestamp"] = _describe("float32")
    features.update({name: _describe("int64") for name in INDEXES})
    if subtasks == "language":
        features[LANGUAGE] = _describe("language")
    return features


def _describe(
    dtype: str, names: Sequence[str] | None = None, info: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    shape = [1 if names is None else len(names)]
    described = {"dtype": dtype, "shape": shape, "names": None if names is None else list(names)}
    return described if info is None else {**described, "info": dict(info)}


def _write_statistics(output: Path, tables: Sequence[Mapping[str, np.ndarray]]) -> None:
    whole = {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}
    _write_json(output / "meta/stats.json", {name: summarize_columns(whole[name]) for name in whole})


def _write_episode_table(
    database: Any,
    output: Path,
    parts: Sequence[_Part],
    tables: Sequence[Mapping[str, np.ndarray]],
    tasks: Sequence[str],
) -> None:
    """Write what LeRobot and an Record say about each episode, and its statistics."""
    columns = dict(EPISODE_COLUMNS)
    rows = []
    for part, table in zip(parts, tables, strict=True):
        statistics = {
            f"stats/{name}/{statistic}": values
            for name in table
            for statistic, values in summarize_columns(table[name]).items()
        }
        columns |= {name: "BIGINT[]" if name.endswith("/count") else "DOUBLE[]" for name in statistics}
        rows.append([*_describe_episode(part, tasks), *statistics.values()])
    write_rows(database, output / EPISODES_PATH, columns, rows)


def _describe_episode(part: _Part, tasks: Sequence[str]) -> list[Any]:
    """Return one row of the table of episodes, in the order of EPISODE_COLUMNS."""
    episode = part.episode
    chunk, file = divmod(part.file, FILES_PER_CHUNK)
    place = [chunk, file, part.start, part.start + episode.ticks, 0, 0]
    about = [episode.agent, episode.behavior, episode.source, episode.seed, list_presses(episode)]
    return [part.number, [tasks[part.task]], episode.ticks, *place, *about]


def _write_data(
    database: Any,
    output: Path,
    data: Demonstrations,
    parts: Sequence[_Part],
    tables: Sequence[Mapping[str, np.ndarray]],
    subtasks: Subtasks,
) -> None:
    """Write the frames of the episodes of one file."""
    chunk, file = divmod(parts[0].file, FILES_PER_CHUNK)
    path = output / DATA_PATH.format(chunk_index=chunk, file_index=file)
    columns = {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}
    if subtasks == "language":
        spoken = {part.number: _list_changes(data, part) for part in parts}
        write_arrays(database, path, columns, LANGUAGE, f"STRUCT({LANGUAGE_FIELDS})", spoken)
    else:
        write_arrays(database, path, columns)


def _list_changes(data: Demonstrations, part: _Part) -> list[dict[str, Any]]:
    """List the changes of subtask in an episode as LeRobot 0.6 has them."""
    labels = data.index_subtasks(part.episode)
    changes = np.append(0, np.flatnonzero(np.diff(labels)) + 1)
    return [
        {
            "role": "assistant",
            "content": data.subtasks[labels[change]],
            "style": "subtask",
            "timestamp": float(time),
            "camera": None,
            "tool_calls": None,
        }
        for change, time in zip(changes, _make_timestamps(changes, data), strict=True)
    ]


def _write_json(path: Path, content: Mapping[str, Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content, indent=2, allow_nan=False) + "\n", encoding="utf-8")


def summarize_columns(values: NDArray[np.generic]) -> Mapping[str, list[float] | list[int]]:
    """Summarize each column of an array.

    Parameters
    ----------
    values
        Numbers or booleans, shape [T] or [T, n]. NaN (absent) and infinite values are left out; a column without
        other values has zeros.

    Returns
    -------
    Mapping
        Lists with one number per column: `min`, `max`, `mean`, `std` and the quantiles `q01`, `q10`, `q50`, `q90` and
        `q99`. `count` is a list of one number, T.
    """
    columns = np.asarray(values, dtype=np.float64).reshape(len(values), -1).T
    present = [column[np.isfinite(column)] for column in columns]
    present = [column if len(column) else np.zeros(1) for column in present]
    with np.errstate(over="ignore", invalid="ignore"):  # sums of the largest numbers; JSON has no infinity
        quantiles = [np.quantile(column, list(QUANTILES.values())) for column in present]
        computed = {
            "min": [column.min() for column in present],
            "max": [column.max() for column in present],
            "mean": [column.mean() for column in present],
            "std": [column.std() for column in present],
            **{name: [each[number] for each in quantiles] for number, name in enumerate(QUANTILES)},
        }
    return {"count": [len(values)]} | {
        name: [float(np.nan_to_num(number)) for number in numbers] for name, numbers in computed.items()
    }
