"""Data sets of demonstrations for Minari, in HDF5, written without Minari's own package."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from importlib import import_module
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from understudy.addons.bridges.datasets.demonstrations import (
    Demonstrations,
    gather_demonstrations,
    list_presses,
    refuse_episode,
)
from understudy.addons.bridges.datasets.new_folder import create_folder
from understudy.errors import SettingError
from understudy.extras import ExtraMissing
from understudy.model.value_kinds import Categorical, Kind, Toroidal
from understudy.records.record import Record

FORMAT_VERSION = "0.5.0"
"""A version of Minari that reads these files; later ones do, too, and refuse newer versions than their own."""
DATASET_ID = re.compile(r"(?:[-_\w]+/)*[-_\w]+-v\d+")
HDF5_VERSION = "v110"
"""The version of HDF5 of 2016, the first in which an attribute, here the presses, may be larger than 64 kB."""


def write_minari(episodes: Sequence[Record], folder: Path | str, *, dataset_id: str = "") -> None:
    """Write episodes as a data set that Minari loads.

    Parameters
    ----------
    episodes
        Records with the same readings, channels and length of ticks, of at least two ticks each. If commands were not
        recorded, the actions are the states of the outermost automaton.
    folder
        A new folder. Its name ends in a version, such as `forage-v0`. Minari finds it by name in the folder of its
        environment variable MINARI_DATASETS_PATH.
    dataset_id
        Minari's name of the data set; by default the name of the folder. A name with namespaces, such as
        "warehouse/forage-v0", must be the end of the folder's path.

    Raises
    ------
    DefinitionError
        If the episodes do not fit into one data set, or one has a single tick.
    FileError
        If the folder exists or cannot be written.
    SettingError
        If the name of the data set is not one that Minari accepts.
    ExtraMissing
        If h5py is not installed.
    """
    folder = Path(folder)
    dataset_id = _check_dataset_id(folder, dataset_id)
    demonstrations = gather_demonstrations(episodes)
    for number, episode in enumerate(demonstrations.episodes):
        if episode.ticks < 2:
            problem = "it has one tick, and a step of Minari goes from one to the next"
            raise refuse_episode(number, episode, problem, "leave it out")
    try:
        h5py = import_module("h5py")
    except ImportError:
        raise ExtraMissing(what="a Minari data set", extra="minari") from None
    with create_folder(folder) as output:
        data = output / "data"
        data.mkdir()
        path = data / "main_data.hdf5"
        with h5py.File(path, "w", libver=HDF5_VERSION) as file:
            for number, episode in enumerate(demonstrations.episodes):
                _write_episode(file.create_group(f"episode_{number}"), demonstrations, number, episode)
        metadata = _describe(demonstrations, dataset_id, path.stat().st_size)
        (data / "metadata.json").write_text(json.dumps(metadata) + "\n", encoding="utf-8")


def _check_dataset_id(folder: Path, dataset_id: str) -> str:
    """Return the name of the data set; refuse one that Minari does not accept, or would not find in the folder."""
    dataset_id = dataset_id or folder.name
    if not DATASET_ID.fullmatch(dataset_id):
        raise SettingError(
            where="a Minari data set",
            setting="its name",
            problem=f"is {dataset_id!r}",
            remedy="use letters, digits, - and _, with a version at the end, such as forage-v0",
        )
    parts = tuple(dataset_id.split("/"))
    if folder.absolute().parts[-len(parts) :] != parts:
        raise SettingError(
            where="a Minari data set",
            setting="its name",
            problem=f"is {dataset_id!r}, and its folder {str(folder)!r}",
            remedy=f"name a folder that ends in {dataset_id}",
        )
    return dataset_id


def _write_episode(group: Any, data: Demonstrations, number: int, episode: Record) -> None:
    """Write T observations and the T - 1 steps between them."""
    steps = episode.ticks - 1
    group.attrs["id"] = number
    group.attrs["total_steps"] = steps
    if episode.seed is not None:
        group.attrs["seed"] = episode.seed
    group.attrs["agent"] = episode.agent
    group.attrs["behavior"] = episode.behavior
    group.attrs["source"] = episode.source
    group.attrs["presses"] = json.dumps(list_presses(episode))
    actions = data.stack_commands(episode) if data.channels else data.index_states(episode, 0)
    _write_array(group, "observations", data.stack_readings(episode))
    _write_array(group, "actions", actions[:steps])
    _write_array(group, "rewards", np.zeros(steps))
    _write_array(group, "terminations", np.zeros(steps, dtype=np.bool_))
    _write_array(group, "truncations", np.arange(steps) == steps - 1)
    infos = group.create_group("infos")
    _write_array(infos, "time", np.asarray(episode.times, dtype=np.float64))
    for level in range(len(data.levels)):
        _write_array(infos, f"state_{level}", data.index_states(episode, level))
    _write_array(infos, "subtask", data.index_subtasks(episode))
    _write_array(infos, "press", data.mark_presses(episode))
    if data.pose:
        _write_array(infos, "pose", data.stack_pose(episode))


def _write_array(group: Any, name: str, values: np.ndarray) -> None:
    group.create_dataset(
        name, data=values, compression="gzip", shuffle=True, maxshape=(None, *values.shape[1:])
    )


def _describe(data: Demonstrations, dataset_id: str, size: int) -> dict[str, Any]:
    """Return Minari's metadata of the data set, then the names and labels of its columns."""
    actions = _describe_box([(-inf, inf)] * len(data.channels))
    if not data.channels:
        actions = {"type": "Discrete", "dtype": "int64", "start": 0, "n": len(data.levels[0])}
    return {
        "total_episodes": len(data.episodes),
        "total_steps": sum(episode.ticks - 1 for episode in data.episodes),
        "data_format": "hdf5",
        "observation_space": json.dumps(_describe_box([_bound_kind(kind) for kind in data.kinds])),
        "action_space": json.dumps(actions),
        "dataset_id": dataset_id,
        "minari_version": FORMAT_VERSION,
        "dataset_size": round(size / 1e6, 1),
        "tick_s": data.tick_s,
        "readings": list(data.readings),
        "kinds": data.list_kind_texts(),
        "units": [data.episodes[0].find_unit(key) for key in data.episodes[0].values],
        "channels": list(data.channels),
        "channel_units": [each.unit for each in data.episodes[0].channels],
        "pose": list(data.pose),
        "state_labels": [list(names) for names in data.levels],
        "subtask_labels": list(data.subtasks),
    }


def _bound_kind(kind: Kind) -> tuple[float, float]:
    """Return the lowest and the highest value of a kind."""
    if isinstance(kind, Toroidal):
        return 0.0, kind.period
    return (0.0, len(kind.labels) - 1.0) if isinstance(kind, Categorical) else (-inf, inf)


def _describe_box(bounds: Sequence[tuple[float, float]]) -> Mapping[str, Any]:
    """Describe a space of vectors, as Gymnasium's Box, in Minari's JSON."""
    low, high = [low for low, _ in bounds], [high for _, high in bounds]
    return {"type": "Box", "dtype": "float64", "shape": [len(bounds)], "low": low, "high": high}
