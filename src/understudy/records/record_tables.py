"""Tables of records: of their episodes, of the ticks and of the presses; and as data frames."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import isnan, nan
from typing import Any, NamedTuple

from understudy.model.data_frames import Cell, make_frame
from understudy.model.features import ReadingKey, format_reading_label
from understudy.model.value_kinds import Categorical, Column
from understudy.records.header import ReadingInfo
from understudy.records.record import BETWEEN, COMMAND, POSE, READING, Record, split_episodes

UNKNOWN = ("", "")
"""The kind and unit of a reading of which the file says neither."""


@dataclass(frozen=True)
class DataTable:
    """The columns of a table by title, None where absent, and the type of each: float, int, str or bool.

    `about` has the kind and unit of columns of readings and commands.
    """

    columns: dict[str, list[Cell]]
    types: dict[str, type]
    about: Mapping[str, ReadingInfo] = field(default_factory=dict)

    @property
    def rows(self) -> int:
        """The number of rows."""
        return len(next(iter(self.columns.values()), []))

    def to_frame(self, backend: str | None = None) -> Any:
        """Make a data frame of the table; see `Lesson.to_frame` for `backend` and errors."""
        return make_frame(self.columns, self.types, backend=backend)


class EpisodeFrames(NamedTuple):
    """Data frames of episodes: one row per episode, per tick, and per press; `episode` joins them."""

    episodes: Any
    ticks: Any
    presses: Any


def make_episode_frames(records: Sequence[Record], backend: str | None = None) -> EpisodeFrames:
    """Make data frames of the episodes of records, their ticks and their presses.

    Parameters
    ----------
    records
        Records, as `read_records` reads them, also of several files.
    backend
        The package that makes the frames: "polars", "pandas" or "pyarrow". None: the first of them, in this order, that
        is installed.

    Returns
    -------
    EpisodeFrames
        The frames `episodes`, `ticks` and `presses`. Their columns are listed in docs/data.md.

    Raises
    ------
    ExtraMissing
        If narwhals is not installed.
    SettingError
        If the package is not installed, or is another one.
    """
    frames = (make_table(records).to_frame(backend) for make_table in TABLES.values())
    return EpisodeFrames(*frames)


def make_episode_table(records: Sequence[Record]) -> DataTable:
    """Make the table of episodes, one row each."""
    episodes = split_episodes(records)
    presses = [each.list_presses() for each in episodes]
    return _make_table(
        {
            "episode": (int, range(len(episodes))),
            "source": (str, [each.source for each in episodes]),
            "agent": (str, [each.agent for each in episodes]),
            "behavior": (str, [each.behavior or None for each in episodes]),
            "seed": (int, [each.seed for each in episodes]),
            "tick_s": (float, [each.tick_s for each in episodes]),
            "ticks": (int, [each.ticks for each in episodes]),
            "start_s": (float, [float(each.times[0]) if each.ticks else None for each in episodes]),
            "end_s": (float, [float(each.times[-1]) if each.ticks else None for each in episodes]),
            "presses": (int, list(map(len, presses))),
            "corrections": (int, [sum(press.correction for press in each) for each in presses]),
        }
    )


def make_tick_table(records: Sequence[Record]) -> DataTable:
    """Make the table of ticks, one row per tick of each episode, with readings and commands as columns."""
    episodes = split_episodes(records)
    states = [each.states or ((),) * each.ticks for each in episodes]
    levels = max((len(path) for each in states for path in each), default=0)
    columns: dict[str, tuple[type, Iterable[Cell]]] = {
        **_make_keys(episodes, lambda each: range(each.ticks)),
        "time_s": (float, [time for each in episodes for time in each.times.tolist()]),
        "states": (str, [BETWEEN.join(path) for each in states for path in each]),
        **{
            f"state_{level + 1}": (
                str,
                [path[level] if level < len(path) else None for each in states for path in each],
            )
            for level in range(levels)
        },
    }
    for name in POSE if any(each.pose for each in episodes) else ():
        columns[name] = float, _join(episodes, [each.pose.get(name) for each in episodes])
    for key in dict.fromkeys(key for each in episodes for key in each.values):
        kinds = [each.find_kind(key) for each in episodes if key in each.values]
        readings = [each.values.get(key) for each in episodes]
        columns[READING + format_reading_label(key)] = (
            (str, _join_labels(episodes, readings, key))
            if all(isinstance(kind, Categorical) for kind in kinds)
            else (float, _join(episodes, readings))
        )
    for channel in dict.fromkeys(channel.name for each in episodes for channel in each.channels):
        commands = [each.find_commands(channel) for each in episodes]
        columns[COMMAND + channel] = float, _join(episodes, commands)
    return replace(_make_table(columns), about=_list_kinds(episodes))


def _list_kinds(episodes: Sequence[Record]) -> dict[str, ReadingInfo]:
    """List the kind and unit of the columns of readings and commands, where all episodes that have them agree."""
    described: dict[str, set[tuple[str, str]]] = {}
    for each in episodes:
        for key in each.values:
            title = READING + format_reading_label(key)
            info = (str(each.find_kind(key)), each.find_unit(key)) if each.kinds_known else UNKNOWN
            described.setdefault(title, set()).add(info)
        for channel in each.channels:
            described.setdefault(COMMAND + channel.name, set()).add(("continuous", channel.unit))
    return {
        title: ReadingInfo(*next(iter(facts)))
        for title, facts in described.items()
        if len(facts) == 1 and UNKNOWN not in facts
    }


def make_press_table(records: Sequence[Record]) -> DataTable:
    """Make the table of presses, one row each."""
    episodes = split_episodes(records)
    presses = [(each, press) for each in episodes for press in each.list_presses()]
    return _make_table(
        {
            **_make_keys(episodes, lambda each: [press.tick for press in each.list_presses()]),
            "time_s": (float, [float(each.times[press.tick]) for each, press in presses]),
            "state": (str, [press.state for _, press in presses]),
            "kind": (str, [None if press.kind is None else press.kind.value for _, press in presses]),
            "correction": (bool, [press.correction for _, press in presses]),
        }
    )


TABLES: dict[str, Callable[[Sequence[Record]], DataTable]] = {
    "episodes": make_episode_table,
    "ticks": make_tick_table,
    "presses": make_press_table,
}
"""The function that makes each table of records."""


def _make_table(columns: dict[str, tuple[type, Iterable[Cell]]]) -> DataTable:
    return DataTable(
        {title: list(cells) for title, (_, cells) in columns.items()},
        {title: kind for title, (kind, _) in columns.items()},
    )


def _make_keys(
    episodes: Sequence[Record], list_ticks: Callable[[Record], Sequence[int]]
) -> dict[str, tuple[type, Iterable[Cell]]]:
    """Make the columns that say of which episode, agent and tick a row is."""
    ticks = [list_ticks(each) for each in episodes]
    return {
        "episode": (int, [number for number, each in enumerate(ticks) for _ in each]),
        "agent": (str, [each.agent for each, rows in zip(episodes, ticks, strict=True) for _ in rows]),
        "tick": (int, [tick for rows in ticks for tick in rows]),
    }


def _join(episodes: Sequence[Record], columns: Sequence[Column | None]) -> list[Cell]:
    """Join the columns of episodes, absent where an episode has none."""
    cells: list[Cell] = []
    for episode, column in zip(episodes, columns, strict=True):
        values = [nan] * episode.ticks if column is None else column.tolist()
        cells += [None if isnan(value) else value for value in values]
    return cells


def _join_labels(episodes: Sequence[Record], columns: Sequence[Column | None], key: ReadingKey) -> list[Cell]:
    """Join the columns of a categorical reading, as texts."""
    kinds = [
        kind
        for each in episodes
        for kind in [each.find_kind(key) if key in each.values else None] * each.ticks
    ]
    return [
        kind.labels[int(value)] if isinstance(kind, Categorical) and value is not None else None
        for kind, value in zip(kinds, _join(episodes, columns), strict=True)
    ]
