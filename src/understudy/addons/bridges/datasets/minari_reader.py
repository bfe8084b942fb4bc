"""Data sets in Minari's format read as records: our own, and those of others with vectors of numbers."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.addons.bridges.datasets.demonstrations import NO_LEVEL, parse_kinds, parse_presses
from understudy.errors import FileError
from understudy.extras import ExtraMissing
from understudy.records.record import POSE, Episode, Record, describe_labels
from understudy.runtime.body import Channel

DATA, METADATA = "data/main_data.hdf5", "data/metadata.json"
REMEDY = "name the folder of a Minari data set whose observations and actions are vectors"


def is_minari(folder: Path | str) -> bool:
    """Return whether a folder has a data set in Minari's format."""
    return (Path(folder) / DATA).is_file()


def read_minari(folder: Path | str) -> list[Record]:
    """Read a record of each episode of a data set in Minari's format.

    Observations are readings and actions commands. Kinds and units of readings, states of all levels, presses, and who
    ran what are in data sets that `write_minari` wrote. The last observation of an episode has no action, and so no
    command.

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
        If a file is missing or damaged, or observations or actions are no vectors of numbers.
    ExtraMissing
        If h5py is not installed.
    """
    folder = Path(folder)
    try:
        h5py = import_module("h5py")
    except ImportError:
        raise ExtraMissing(what="a Minari data set", extra="minari") from None
    try:
        about = json.loads((folder / METADATA).read_text("utf-8")) if (folder / METADATA).is_file() else {}
        with h5py.File(folder / DATA, "r") as file:
            names = sorted(file, key=lambda each: int(each.rpartition("_")[2]))
            records = [_make_record(folder, about, file[name]) for name in names]
    except (OSError, LookupError, TypeError, ValueError, AttributeError) as error:
        problem = f"it cannot be read ({type(error).__name__}: {error})"
        raise FileError(path=folder, place=DATA, problem=problem, remedy=REMEDY) from None
    if not records:
        raise FileError(path=folder, place=DATA, problem="it has no episode", remedy=REMEDY)
    return records


def _make_record(folder: Path, about: Mapping[str, Any], group: Any) -> Record:
    observations, actions = _read_matrix(group, "observations"), _read_matrix(group, "actions")
    count = len(observations)
    labels = about.get("readings") or [f"observation_{column}" for column in range(observations.shape[1])]
    kinds = about.get("kinds")
    keys, described, targets = describe_labels(
        labels, parse_kinds(kinds, labels), about.get("units") or [""] * len(labels)
    )
    channels = about.get("channels", [f"action_{column}" for column in range(actions.shape[1])])
    channel_units = about.get("channel_units") or [""] * len(channels)
    commands = np.full((count, len(channels)), np.nan)
    commands[: len(actions)] = actions[:, : len(channels)]
    tick_s, are_known = about.get("tick_s"), None not in (kinds or [None])
    infos = group.get("infos", {})
    unknown = [
        *(["units and kinds of readings; numbers were taken as distances, not as angles"] * (not are_known)),
        *(["how long a tick is; it was taken as 1 s"] * (tick_s is None)),
    ]
    place = about.get("pose") or ()
    return Record(
        times=infos["time"][:] if "time" in infos else np.arange(count) * (tick_s or 1.0),
        values={key: observations[:, column] for column, key in enumerate(keys)},
        commands=commands,
        channels=tuple(Channel(name, unit=unit) for name, unit in zip(channels, channel_units, strict=True)),
        readings=described,
        targets=targets,
        tick_s=tick_s or 1.0,
        episodes=(Episode(folder.name, 0, count),),
        omissions=tuple(f"{folder}: it does not say {each}" for each in unknown),
        states=_list_states(infos, about.get("state_labels") or (), count),
        presses=parse_presses(json.loads(group.attrs.get("presses", "[]"))),
        pose={name: infos["pose"][:, column] for column, name in enumerate(place) if name in POSE},
        agent=str(group.attrs.get("agent", "robot 0")),
        source=str(folder),
        seed=int(group.attrs["seed"]) if "seed" in group.attrs else None,
        behavior=str(group.attrs.get("behavior", "")),
        kinds_known=are_known,
    )


def _read_matrix(group: Any, name: str) -> NDArray[np.float64]:
    """Read observations or actions; those that are single numbers become a column, others than vectors are refused."""
    values = group[name]
    if not hasattr(values, "shape") or len(values.shape) > 2:
        raise TypeError(f"{name} are no vectors")
    matrix = np.asarray(values[:], np.float64)
    return matrix[:, np.newaxis] if matrix.ndim == 1 else matrix


def _list_states(infos: Any, labels: Sequence[Sequence[str]], count: int) -> tuple[tuple[str, ...], ...]:
    columns = [infos[f"state_{level}"][:].tolist() for level in range(len(labels))]
    if not columns:
        return ()
    return tuple(
        tuple(labels[level][column[tick]] for level, column in enumerate(columns) if column[tick] != NO_LEVEL)
        for tick in range(count)
    )
