"""Demonstrations: episodes with the same readings, channels and ticks, as the arrays that data sets are made of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isclose, isfinite
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from understudy.errors import DefinitionError, join_names
from understudy.judging.episodes.episode import Episode
from understudy.model.value_kinds import Column, Kind

if TYPE_CHECKING:
    from numpy.typing import NDArray

Matrix: TypeAlias = "NDArray[np.float64]"
"""An array of float64 values of shape [T, n]: one row per tick; NaN where absent."""
NO_LEVEL = -1
"""The index of the state of a level that did not exist in a tick."""
BETWEEN = " > "
"""The text between the states of the levels in a subtask, outermost first."""
SUBJECT = "a data set of demonstrations"


@dataclass(frozen=True, slots=True)
class Demonstrations:
    """Episodes that one data set can hold, and the names of its columns.

    Attributes
    ----------
    episodes
        The episodes: at least one, each with at least one tick, all with the same readings, channels and ticks.
    readings
        Labels of the readings, in the order of their columns.
    kinds
        Kind of each reading; None where the file does not say.
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

    episodes: tuple[Episode, ...]
    readings: tuple[str, ...]
    kinds: tuple[Kind | None, ...]
    channels: tuple[str, ...]
    pose: tuple[str, ...]
    levels: tuple[tuple[str, ...], ...]
    subtasks: tuple[str, ...]

    @property
    def tick_s(self) -> float:
        """The nominal length of a tick of all episodes, s."""
        return self.episodes[0].tick_s

    def stack_readings(self, episode: Episode) -> Matrix:
        """Return the readings of an episode, shape [T, number of readings]; NaN where absent."""
        return _stack(episode.readings, self.readings)

    def stack_commands(self, episode: Episode) -> Matrix:
        """Return the commands of an episode, shape [T, number of channels]."""
        return _stack(episode.commands, self.channels)

    def stack_pose(self, episode: Episode) -> Matrix:
        """Return the place of the robot in an episode, shape [T, number of columns of the pose]."""
        return _stack(episode.pose, self.pose)

    def index_states(self, episode: Episode, level: int) -> NDArray[np.int64]:
        """Return the index in `levels[level]` of the state in each tick, shape [T]; -1 where there is no such level."""
        index = {name: number for number, name in enumerate(self.levels[level])}
        return np.array(
            [index[path[level]] if level < len(path) else NO_LEVEL for path in episode.states], dtype=np.int64
        )

    def index_subtasks(self, episode: Episode) -> NDArray[np.int64]:
        """Return the index in `subtasks` of the states of all levels in each tick, shape [T]."""
        index = {name: number for number, name in enumerate(self.subtasks)}
        return np.array([index[describe_subtask(path)] for path in episode.states], dtype=np.int64)

    def mark_presses(self, episode: Episode) -> NDArray[np.bool_]:
        """Return whether the demonstrator pressed, in each tick, shape [T]."""
        pressed = np.zeros(episode.ticks, dtype=np.bool_)
        pressed[[press.tick for press in episode.presses]] = True
        return pressed


def _stack(columns: Mapping[str, Column], names: Sequence[str]) -> Matrix:
    return np.column_stack([np.asarray(columns[name], dtype=np.float64) for name in names])


def list_presses(episode: Episode) -> list[dict[str, Any]]:
    """Return the presses of an episode as values that JSON can hold."""
    return [
        {
            "tick": press.tick,
            "state": press.state,
            "correction": press.correction,
            "kind": press.kind and str(press.kind),
        }
        for press in episode.presses
    ]


def describe_subtask(path: Sequence[str]) -> str:
    """Describe the states of all levels, outermost first, as one text, such as "fetch > forward"."""
    return BETWEEN.join(path)


def gather_demonstrations(episodes: Sequence[Episode]) -> Demonstrations:
    """Check that one data set can hold all episodes, and name its columns.

    Parameters
    ----------
    episodes
        Episodes of robots or coordinators that have the same readings, channels and length of ticks. Readings and
        channels may be in any order; the first episode's is used.

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
    first = episodes[0]
    for number, episode in enumerate(episodes):
        _check_episode(number, episode)
        _check_same_columns(number, episode, first)
    if not first.commands and not any(path for episode in episodes for path in episode.states):
        problem = "no episode has commands or states"
        raise DefinitionError(what=SUBJECT, problem=problem, remedy="give episodes in which an automaton ran")
    depth = max((len(path) for episode in episodes for path in episode.states), default=0)
    paths = list(dict.fromkeys(path for episode in episodes for path in episode.states))
    return Demonstrations(
        episodes=tuple(episodes),
        readings=tuple(first.readings),
        kinds=tuple(first.kinds.get(label) for label in first.readings),
        channels=tuple(first.commands),
        pose=tuple(first.pose),
        levels=tuple(
            tuple(dict.fromkeys(path[level] for path in paths if level < len(path))) for level in range(depth)
        ),
        subtasks=tuple(dict.fromkeys(describe_subtask(path) for path in paths)),
    )


def _check_episode(number: int, episode: Episode) -> None:
    """Refuse an episode without ticks, without readings, or whose columns have different lengths."""
    if not episode.ticks:
        raise refuse_episode(number, episode, "it has no ticks", "leave it out")
    if not (isfinite(episode.tick_s) and episode.tick_s > 0):
        remedy = "give the length of a tick in seconds"
        raise refuse_episode(number, episode, f"its tick_s is {episode.tick_s}", remedy)
    if not episode.readings:
        raise refuse_episode(number, episode, "its readings were not recorded", "give episodes with readings")
    columns = {"states": episode.states, **episode.readings, **episode.commands, **episode.pose}
    for name, column in columns.items():
        if len(column) != episode.ticks:
            problem = f"{name} has {len(column)} values for {episode.ticks} ticks"
            raise refuse_episode(number, episode, problem, "give one value per tick")
    outside = [press.tick for press in episode.presses if not 0 <= press.tick < episode.ticks]
    if outside:
        remedy = f"its ticks are 0 to {episode.ticks - 1}"
        raise refuse_episode(number, episode, f"a press is at tick {outside[0]}", remedy)


def _check_same_columns(number: int, episode: Episode, first: Episode) -> None:
    """Refuse an episode whose columns differ from those of the first episode."""
    for what, its, others in (
        ("readings", set(episode.readings), set(first.readings)),
        ("channels of commands", set(episode.commands), set(first.commands)),
        ("columns of the pose", set(episode.pose), set(first.pose)),
    ):
        if its != others:
            lacks, adds = sorted(others - its), sorted(its - others)
            differences = [f"it lacks {join_names(lacks)}"] * bool(lacks)
            differences += [f"it adds {join_names(adds)}"] * bool(adds)
            problem = f"its {what} are not those of the first episode: {', and '.join(differences)}"
            raise refuse_episode(number, episode, problem, "write a data set for each")
    for label in first.readings:
        its_kind, kind = (str(each.kinds.get(label, "of no known kind")) for each in (episode, first))
        if its_kind != kind:
            problem = f"{label} is {its_kind}, and {kind} in the first episode"
            raise refuse_episode(number, episode, problem, "write a data set for each")
    if not isclose(episode.tick_s, first.tick_s, rel_tol=1e-9):
        problem = f"its ticks take {episode.tick_s} s, and those of the first episode {first.tick_s} s"
        raise refuse_episode(number, episode, problem, "write a data set for each")


def refuse_episode(number: int, episode: Episode, problem: str, remedy: str) -> DefinitionError:
    """Return the error about an episode that a data set cannot hold; `number` counts from 0, as in the data sets."""
    source = f" of {episode.source}" if episode.source else ""
    what = f"{SUBJECT}: episode {number} ({episode.agent}{source})"
    return DefinitionError(what=what, problem=problem, remedy=remedy)
