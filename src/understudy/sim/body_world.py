"""A body of the user's own as a world to teach in: it has readings and channels, and pictures if it can draw itself."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError
from understudy.model.features import Percept, ReadingKey
from understudy.runtime.body import Body, Channel, Commands, Reading, Resettable, close_body
from understudy.sim.params import ScenarioNames
from understudy.sim.scenario.schema import RobotGroup, RobotType, Scenario
from understudy.sim.state import WorldParams, WorldState
from understudy.sim.view import WorldView
from understudy.sim.world import World

PIXELS_PER_M = 100.0
"""How many pixels of a picture are 1 m of the empty arena behind it."""
EMPTY_SIZE = (6.0, 4.0)
"""The size of the arena behind a body without pictures, m."""
AGENT = "agent"


class BodyWorld:
    """A body of the user's own, in one world.

    Where its agents are is unknown: it is shown by its readings, and by the pictures that its method `render` returns,
    if it has one. It can be reset, but neither rewound nor changed by hand. A body without a method `reset` is made
    anew instead.

    Parameters
    ----------
    make
        A function that makes the body, given a seed.
    seed
        The seed of the world.
    name
        What the world is called.

    Raises
    ------
    DefinitionError
        If its `render` fails or returns no picture.
    """

    worlds = 1

    def __init__(self, make: Callable[[int], Body], seed: int = 0, *, name: str) -> None:
        self._make = make
        self.name = name
        self.body = make(seed)
        self._seed = seed
        self.agents = self.robots = self.body.agents
        picture = self.render()
        self.has_picture = picture is not None
        height, width = (1, 1) if picture is None else picture.shape[:2]
        size = EMPTY_SIZE if picture is None else (width / PIXELS_PER_M, height / PIXELS_PER_M)
        empty = _make_empty_scenario(size, self.body.tick_s, self.agents)
        self._drawn = World(empty, [seed])
        self.scenario = msgspec.structs.replace(empty, name=name)  # which may be no name of a scenario

    @property
    def readings(self) -> Sequence[Reading]:
        """The readings of the body."""
        return self.body.readings

    @property
    def targets(self) -> Sequence[str]:
        """The targets of the body."""
        return self.body.targets

    @property
    def channels(self) -> Sequence[Channel]:
        """The channels of the body."""
        return self.body.channels

    @property
    def tick_s(self) -> float:
        """The length of a tick, s."""
        return self.body.tick_s

    @property
    def time_s(self) -> float:
        """The body's time, s."""
        return self.body.time_s

    @property
    def is_over(self) -> bool:
        """Whether the body says, by `is_over`, that the episodes of all agents have ended."""
        return bool(np.all(getattr(self.body, "is_over", False)))

    @property
    def display_world(self) -> World:
        """The empty arena behind the pictures."""
        return self._drawn

    @property
    def names(self) -> ScenarioNames:
        """The names of the empty arena."""
        return self._drawn.names

    @property
    def rules(self) -> WorldParams:
        """The parameters of the empty arena."""
        return self._drawn.rules

    @property
    def state(self) -> WorldState:
        """The state of the empty arena, of which only the tick goes on."""
        return self._drawn.state

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seed of the world."""
        return (self._seed,)

    def view(self, world: int = 0) -> WorldView:
        """Return the empty arena at the body's time."""
        return replace(self._drawn.view(world), time_s=self.time_s)

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """Return a column [N] for each key."""
        return self.body.sense(keys)

    def act(self, commands: Commands) -> None:
        """Let the body act for one tick."""
        self.body.act(commands)
        self.state.tick[0] += 1

    def reset(self, seeds: Sequence[int]) -> None:
        """Begin the world of another seed."""
        (seed,) = seeds
        if isinstance(self.body, Resettable):
            self.body.reset([seed])
        else:
            self.close()
            self.body = self._make(seed)
        self._seed = seed
        self._drawn.reset([seed])

    def render(self) -> NDArray[np.uint8] | None:
        """Draw the body.

        Returns
        -------
        NDArray[np.uint8] or None
            The picture [height, width, 3] that the body's `render` returned. None: it has none.
        """
        draw: Any = getattr(self.body, "render", None)
        if draw is None:
            return None
        try:
            picture = draw()
        except DefinitionError:
            raise
        except Exception as error:  # whatever a body of the user's own does
            raise self._wrong_picture(f"failed: {type(error).__name__}: {error}") from error
        if picture is None:
            return None
        picture = np.asarray(picture)
        if picture.ndim != 3 or picture.shape[2] != 3 or picture.dtype != np.uint8 or not picture.size:
            raise self._wrong_picture(f"returned an array of {picture.dtype} of shape {picture.shape}")
        return picture

    def _wrong_picture(self, problem: str) -> DefinitionError:
        remedy = "return an array of uint8 of shape (height, width, 3), or None if there is no picture"
        return DefinitionError(what=f"render of {self.name}", problem=f"it {problem}", remedy=remedy)

    def close(self) -> None:
        """Close the body if it has a method `close`."""
        close_body(self.body)


def _make_empty_scenario(size: tuple[float, float], tick_s: float, agents: int) -> Scenario:
    """Make an empty arena with one robot per agent, by which the user interface lists agents."""
    width, height = size
    places = tuple((width * (agent + 1) / (agents + 1), height / 2) for agent in range(agents))
    kind = RobotType(radius=min(0.1, min(size) / 10, width / (agents + 1) / 4), collides=False)
    return Scenario(
        size=size, tick_s=tick_s, types={AGENT: kind}, robots=(RobotGroup(type=AGENT, at=places),)
    )
