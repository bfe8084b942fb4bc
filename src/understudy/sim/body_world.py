"""Bodies that are not simulated as worlds to teach in, which a simulated world draws.

`BodyWorld` is a body of the user's own: it has readings and channels, and pictures if it can draw itself.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError
from understudy.runtime.body import Body, Commands, Resettable, close_body
from understudy.runtime.body_wrapper import BodyWrapper, GroundT
from understudy.sim.scenario.schema import RobotGroup, RobotType, Scenario
from understudy.sim.state import WorldState
from understudy.sim.view import WorldView
from understudy.sim.world import World

PIXELS_PER_M = 100.0
"""How many pixels of a picture are 1 m of the empty arena behind it."""
EMPTY_SIZE = (6.0, 4.0)
"""The size of the arena behind a body without pictures, m."""
AGENT = "agent"


class DrawnBody(BodyWrapper[GroundT]):
    """A body in one world, which has what user interfaces draw: names, parameters, state and view of a world behind it.

    Parameters
    ----------
    ground
        The body below.
    drawn
        The world that is drawn in its place.
    """

    worlds = 1
    scenario: Scenario

    def __init__(self, ground: GroundT, drawn: World) -> None:
        super().__init__(ground)
        self._drawn = drawn
        self.names, self.rules = drawn.names, drawn.rules
        self.robots = self.agents

    def _draw(self) -> None:
        """Bring the drawn world up to date; a subclass whose world changes does it here."""

    @property
    def display_world(self) -> World:
        """The world that is drawn, as it is now; of its state, only the tick goes on by itself."""
        self._draw()
        return self._drawn

    @property
    def state(self) -> WorldState:
        """The state of the drawn world."""
        return self.display_world.state

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seed of the drawn world."""
        return self._drawn.seeds

    def view(self, world: int = 0) -> WorldView:
        """Return a view of the drawn world."""
        return self.display_world.view(world)


class BodyWorld(DrawnBody[Body]):
    """A body of the user's own, in one world.

    Where its agents are is unknown: it is shown by its readings, and by the pictures that its method `render` returns,
    if it has one. It can be reset, but neither rewound nor changed by hand. A body without a method `reset` is replaced
    by a new one.

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

    def __init__(self, make: Callable[[int], Body], seed: int = 0, *, name: str) -> None:
        self._make = make
        self.name = name
        body = make(seed)
        picture = draw_body(body, name)
        self.has_picture = picture is not None
        height, width = (1, 1) if picture is None else picture.shape[:2]
        size = EMPTY_SIZE if picture is None else (width / PIXELS_PER_M, height / PIXELS_PER_M)
        empty = _make_empty_scenario(size, body.tick_s, body.agents)
        super().__init__(body, World(empty, [seed]))
        self.scenario = msgspec.structs.replace(empty, name=name)  # which may be no name of a scenario

    @property
    def is_over(self) -> bool:
        """Whether the body says, by `is_over`, that the episodes of all agents have ended."""
        return bool(np.all(getattr(self.ground, "is_over", False)))

    def view(self, world: int = 0) -> WorldView:
        """Return the empty arena at the body's time."""
        return replace(super().view(world), time_s=self.time_s)

    def act(self, commands: Commands) -> None:
        """Let the body act for one tick."""
        super().act(commands)
        self.state.tick[0] += 1

    def reset(self, seeds: Sequence[int]) -> None:
        """Begin the world of another seed."""
        (seed,) = seeds
        if isinstance(self.ground, Resettable):
            self.ground.reset([seed])
            self._stand_on(self.ground)
        else:
            self.close()
            self._stand_on(self._make(seed))
        self._drawn.reset([seed])

    def render(self) -> NDArray[np.uint8] | None:
        """Draw the body.

        Returns
        -------
        NDArray[np.uint8] or None
            The picture [height, width, 3] that the body's `render` returned. None: it has none.
        """
        return draw_body(self.ground, self.name)

    def close(self) -> None:
        """Close the body if it has a method `close`."""
        close_body(self.ground)


def draw_body(body: Body, name: str) -> NDArray[np.uint8] | None:
    """Return the picture that the `render` of a body returns; None if it has none, DefinitionError if it fails."""
    draw: Any = getattr(body, "render", None)
    if draw is None:
        return None
    try:
        picture = draw()
    except DefinitionError:
        raise
    except Exception as error:  # a user's body can raise any error
        raise _wrong_picture(name, f"failed: {type(error).__name__}: {error}") from error
    if picture is None:
        return None
    picture = np.asarray(picture)
    if picture.ndim != 3 or picture.shape[2] != 3 or picture.dtype != np.uint8 or not picture.size:
        raise _wrong_picture(name, f"returned an array of {picture.dtype} of shape {picture.shape}")
    return picture


def _wrong_picture(name: str, problem: str) -> DefinitionError:
    remedy = "return an array of uint8 of shape (height, width, 3), or None if there is no picture"
    return DefinitionError(what=f"render of {name}", problem=f"it {problem}", remedy=remedy)


def _make_empty_scenario(size: tuple[float, float], tick_s: float, agents: int) -> Scenario:
    """Make an empty arena with one robot per agent, by which the user interface lists agents."""
    width, height = size
    places = tuple((width * (agent + 1) / (agents + 1), height / 2) for agent in range(agents))
    kind = RobotType(radius=min(0.1, min(size) / 10, width / (agents + 1) / 4), collides=False)
    return Scenario(
        size=size, tick_s=tick_s, types={AGENT: kind}, robots=(RobotGroup(type=AGENT, at=places),)
    )
