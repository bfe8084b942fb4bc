"""Demonstrations: episodes with the same readings, channels and ticks, as the arrays that data sets are made of."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import isclose, isfinite
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from understudy.errors import DefinitionError, join_names
from understudy.model.features import format_reading_label
from understudy.model.lesson import ExampleKind
from understudy.model.value_kinds import Categorical, Column, Continuous, Kind, parse_kind
from understudy.records.record import BETWEEN, Record, RecordedPress, split_episodes

if TYPE_CHECKING:
    from numpy.typing import NDArray

Matrix: TypeAlias = "NDArray[np.float64]"
"""An array of float64 values of shape [T, n]: one row per tick; NaN where absent."""
NO_LEVEL = -1
"""The index of the state of a level that did not exist in a tick."""
SUBJECT = "a data set of demonstrations"


@dataclass(frozen=True, slots=True)
class Demonstrations:
    """Records that one data set can hold, and the names of its columns.

    Attributes
    ----------
    episodes
        The episodes: at least one, each with at least one tick, all with the same readings, channels and ticks.
    readings
        Labels of the readings, in the order of their columns.
    kinds
        Kind of each reading.
    channels
        Channels of the commands, in the order of their columns; empty if commands were not recorded.
    pose
        Names of the columns of the robot's place, such as "x"; empty if it was not recorded.
    levels
        Names of the states at each level, outermost first, in the order in which they first occur.
    subtasks
        The different combinations of states of all levels, as text such as "fetch > forward", in the order in which
        they first occur.
    """

    episodes: tuple[Record, ...]
    readings: tuple[str, ...]
    kinds: tuple[Kind, ...]
    channels: tuple[str, ...]
    pose: tuple[str, ...]
    levels: tuple[tuple[str, ...], ...]
    subtasks: tuple[str, ...]

    def list_kind_texts(self) -> list[str | None]:
        """List the kind of each reading as text; None for a number of which no file said what it is."""
        are_known = all(each.kinds_known for each in self.episodes)
        return [str(kind) if are_known or isinstance(kind, Categorical) else None for kind in self.kinds]

    @property
    def tick_s(self) -> float:
        """The nominal length of a tick of all episodes, s."""
        return self.episodes[0].tick_s

    def stack_readings(self, episode: Record) -> Matrix:
        """Return the readings of an episode, shape [T, number of readings]; NaN where absent."""
        return _stack(episode.columns, self.readings)

    def stack_commands(self, episode: Record) -> Matrix:
        """Return the commands of an episode, shape [T, number of channels]."""
        return _stack(list_commands(episode), self.channels)

    def stack_pose(self, episode: Record) -> Matrix:
        """Return the place of the robot in an episode, shape [T, number of columns of the pose]."""
        return _stack(episode.pose, self.pose)

    def index_states(self, episode: Record, level: int) -> NDArray[np.int64]:
        """Return the index in `levels[level]` of the state in each tick, shape [T]; -1 where there is no such level."""
        index = {name: number for number, name in enumerate(self.levels[level])}
        return np.array(
            [index[path[level]] if level < len(path) else NO_LEVEL for path in episode.states], dtype=np.int64
        )

    def index_subtasks(self, episode: Record) -> NDArray[np.int64]:
        """Return the index in `subtasks` of the states of all levels in each tick, shape [T]."""
        index = {name: number for number, name in enumerate(self.subtasks)}
        return np.array([index[describe_subtask(path)] for path in episode.states], dtype=np.int64)

    def mark_presses(self, episode: Record) -> NDArray[np.bool_]:
        """Return whether the demonstrator pressed, in each tick, shape [T]."""
        pressed = np.zeros(episode.ticks, dtype=np.bool_)
        pressed[[press.tick for press in episode.list_presses()]] = True
        return pressed


def list_commands(episode: Record) -> dict[str, Column]:
    """Return the commands of an episode by channel, [T] each."""
    return {each.name: episode.commands[:, column] for column, each in enumerate(episode.channels)}


def _stack(columns: Mapping[str, Column], names: Sequence[str]) -> Matrix:
    return np.column_stack([np.asarray(columns[name], dtype=np.float64) for name in names])


def list_presses(episode: Record) -> list[dict[str, Any]]:
    """Return the presses of an episode as values that JSON can hold."""
    return [
        {
            "tick": press.tick,
            "state": press.state,
            "correction": press.correction,
            "kind": press.kind and str(press.kind),
        }
        for press in episode.list_presses()
    ]


def parse_presses(entries: Iterable[Mapping[str, Any]]) -> tuple[RecordedPress, ...]:
    """Parse presses as `list_presses` lists them."""
    return tuple(
        RecordedPress(
            each["tick"],
            each["state"],
            each["correction"],
            None if each["kind"] is None else ExampleKind(each["kind"]),
        )
        for each in entries
    )


def parse_kinds(kinds: Sequence[str | None] | None, labels: Sequence[str]) -> list[Kind]:
    """Parse the kinds of columns; one that the data set does not say is continuous."""
    return [
        Continuous() if kind is None else parse_kind(kind, where=label)
        for label, kind in zip(labels, kinds or [None] * len(labels), strict=True)
    ]


def describe_subtask(path: Sequence[str]) -> str:
    """Describe the states of all levels, outermost first, as one text, such as "fetch > forward"."""
    return BETWEEN.join(path)


def gather_demonstrations(episodes: Sequence[Record]) -> Demonstrations:
    """Check that one data set can hold all episodes, and name its columns.

    Parameters
    ----------
    episodes
        Records of robots or coordinators, also of several episodes each, that have the same readings, channels and
        length of ticks. Readings and channels may be in any order; the first episode's is used.

    Returns
    -------
    Demonstrations
        The episodes and the names of the columns.

    Raises
    ------
    DefinitionError
        If there is no episode, an episode has no ticks or no readings, no episode has commands or states, or the
        readings, kinds, channels or length of ticks of an episode differ from those of the first.
    """
    if not episodes:
        raise DefinitionError(what=SUBJECT, problem="there is no episode", remedy="give at least one")
    episodes = split_episodes(episodes)
    first = episodes[0]
    for number, episode in enumerate(episodes):
        _check_episode(number, episode)
        _check_same_columns(number, episode, first)
    if not first.channels and not any(path for episode in episodes for path in episode.states):
        problem = "no episode has commands or states"
        raise DefinitionError(what=SUBJECT, problem=problem, remedy="give episodes in which an automaton ran")
    depth = max((len(path) for episode in episodes for path in episode.states), default=0)
    paths = list(dict.fromkeys(path for episode in episodes for path in episode.states))
    return Demonstrations(
        episodes=tuple(episodes),
        readings=tuple(first.columns),
        kinds=tuple(first.find_kind(key) for key in first.values),
        channels=tuple(each.name for each in first.channels),
        pose=tuple(first.pose),
        levels=tuple(
            tuple(dict.fromkeys(path[level] for path in paths if level < len(path))) for level in range(depth)
        ),
        subtasks=tuple(dict.fromkeys(describe_subtask(path) for path in paths)),
    )


def _check_episode(number: int, episode: Record) -> None:
    """Refuse an episode without ticks, without readings, or whose columns have different lengths."""
    if not episode.ticks:
        raise refuse_episode(number, episode, "it has no ticks", "leave it out")
    if not (isfinite(episode.tick_s) and episode.tick_s > 0):
        remedy = "give the length of a tick in seconds"
        raise refuse_episode(number, episode, f"its tick_s is {episode.tick_s}", remedy)
    if not episode.values:
        raise refuse_episode(number, episode, "its readings were not recorded", "give episodes with readings")
    columns = {"states": episode.states, **episode.columns, **list_commands(episode), **episode.pose}
    for name, column in columns.items():
        if len(column) != episode.ticks:
            problem = f"{name} has {len(column)} values for {episode.ticks} ticks"
            raise refuse_episode(number, episode, problem, "give one value per tick")
    outside = [press.tick for press in episode.presses if not 0 <= press.tick < episode.ticks]
    if outside:
        remedy = f"its ticks are 0 to {episode.ticks - 1}"
        raise refuse_episode(number, episode, f"a press is at tick {outside[0]}", remedy)


def _check_same_columns(number: int, episode: Record, first: Record) -> None:
    """Refuse an episode whose columns differ from those of the first episode."""
    for what, its, others in (
        ("readings", set(episode.columns), set(first.columns)),
        ("channels of commands", set(list_commands(episode)), set(list_commands(first))),
        ("columns of the pose", set(episode.pose), set(first.pose)),
    ):
        if its != others:
            lacks, adds = sorted(others - its), sorted(its - others)
            differences = [f"it lacks {join_names(lacks)}"] * bool(lacks)
            differences += [f"it adds {join_names(adds)}"] * bool(adds)
            problem = f"its {what} are not those of the first episode: {', and '.join(differences)}"
            raise refuse_episode(number, episode, problem, "write a data set for each")
    for key in first.values:
        its_kind, kind = (str(each.find_kind(key)) for each in (episode, first))
        if its_kind != kind:
            problem = f"{format_reading_label(key)} is {its_kind}, and {kind} in the first episode"
            raise refuse_episode(number, episode, problem, "write a data set for each")
        its_unit, unit = (each.find_unit(key) or "no unit" for each in (episode, first))
        if its_unit != unit:
            problem = f"{format_reading_label(key)} is in {its_unit}, and in {unit} in the first episode"
            raise refuse_episode(number, episode, problem, "write a data set for each")
    if not isclose(episode.tick_s, first.tick_s, rel_tol=1e-9):
        problem = f"its ticks take {episode.tick_s} s, and those of the first episode {first.tick_s} s"
        raise refuse_episode(number, episode, problem, "write a data set for each")


def refuse_episode(number: int, episode: Record, problem: str, remedy: str) -> DefinitionError:
    """Return the error about an episode that a data set cannot hold; `number` counts from 0, as in the data sets."""
    source = f" of {episode.source}" if episode.source else ""
    what = f"{SUBJECT}: episode {number} ({episode.agent}{source})"
    return DefinitionError(what=what, problem=problem, remedy=remedy)
