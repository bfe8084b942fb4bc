"""What each robot of a patrol is to do: what it was ordered, however far above, or what it does by itself."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError
from understudy.model.squad import Duty
from understudy.runtime.engine.engine import Engine
from understudy.runtime.team.squad_body import Squads
from understudy.runtime.team.team import Team

OTHER, DISPERSE, ATTACK, HOME, RUN_AWAY = range(5)
OWN_HOME = "(own home)"
DOING: Mapping[tuple[str, str | None], int] = MappingProxyType(
    {
        ("disperse", None): DISPERSE,
        ("attack", "intruder"): ATTACK,
        ("attack", OWN_HOME): HOME,
        ("gather", OWN_HOME): HOME,
        ("run_away", None): RUN_AWAY,
    }
)
"""What an order means, by the behavior and its target."""
ALONE: Mapping[str, int] = MappingProxyType(
    {"disperse": DISPERSE, "wander": DISPERSE, "attack": ATTACK, "hunt": ATTACK, "home": HOME}
)
"""What a robot does by itself, by how the name of its state begins."""

Reach: TypeAlias = tuple[Squads, NDArray[np.intp], NDArray[np.intp]]
"""Squads, and whom their orders reach in the end: pairs of one of their members and a robot [K each]."""


class Told:
    """What the robots of so many worlds are to do: the outermost order that means anything, or else what they do by
    themselves. `homes` are those of the squads they are in, one after the other; `squad` [N] is which one that is.
    """

    def __init__(self, team: Team, worlds: int, homes: Sequence[str]) -> None:
        self._team, self._worlds, self._homes = team, worlds, homes
        begins = [place.state.partition("_")[0] for place in _engine(team).compiled.places]
        self._of_states = np.array([ALONE.get(each, OTHER) for each in begins], np.int8)
        self._reaches = list(_reaches(team))
        self._squad = np.zeros(team.ground.agents, np.intp)
        for squads, member, robot in reversed(self._reaches):
            self._squad[robot] = squads.roster.squad[member] % len(homes)
        self.squad = self._squad[: team.ground.agents // worlds]

    def now(self) -> NDArray[np.int8]:
        """Of all robots [W, N]."""
        if self._reaches:
            found = np.full(self._team.ground.agents, OTHER, np.int8)
        else:
            found = self._of_states[_engine(self._team).stacks.state[:, 0]]
        for squads, member, robot in self._reaches:
            ordering = squads.ordering
            meanings = [[_meaning(duty, home) for home in self._homes] for duty in ordering.duties]
            meant = np.array(meanings, np.int8)[ordering.heard[member], self._squad[robot]]
            found[robot] = np.where(meant == OTHER, found[robot], meant)
        return found.reshape(self._worlds, -1)


def _engine(team: Team) -> Engine:
    runner = team.layers[0].runner
    if not isinstance(runner, Engine):
        raise SettingError(where="patrol", setting="team", problem="has no engine", remedy="make it with one")
    return runner


def _reaches(team: Team) -> Iterator[Reach]:
    """Whom orders reach, innermost first."""
    robots = {id(team.layers[0]): [np.array([robot]) for robot in range(team.ground.agents)]}
    for layer in team.layers[1:]:
        squads = layer.body
        if isinstance(squads, Squads):
            roster = squads.roster
            of = [
                robots[id(squads.bands[band].layer)][row]
                for band, row in zip(roster.band, roster.row, strict=True)
            ]
            member, robot = np.repeat(np.arange(len(of)), [len(each) for each in of]), np.concatenate(of)
            yield squads, member, robot
            robots[id(layer)] = [robot[roster.squad[member] == squad] for squad in range(roster.squads)]


def _meaning(duty: Duty | None, home: str) -> int:
    """What an order means to a robot whose home is there."""
    if duty is None:
        return OTHER
    target = next(iter(duty.binding.values()), None)
    return DOING.get((duty.behavior, OWN_HOME if target == home else target), OTHER)
