"""Coordinators as a body: the coordinators of one sort of squads, with everything below them.

A session or a run trains or runs coordinators through this body in the same way as robots.
"""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from understudy.errors import FileError, SessionError
from understudy.model.drawing import format_number_of, format_repr
from understudy.model.features import Percept, ReadingKey
from understudy.model.squad import Order
from understudy.runtime.body import Body, Commands, Resettable, Rewindable, list_reading_keys
from understudy.runtime.body_wrapper import BodyWrapper
from understudy.runtime.interpreter import StackFrame
from understudy.runtime.run_loop import Run
from understudy.runtime.team.members import AgentLayer
from understudy.runtime.team.squad_body import SquadBody, SquadState
from understudy.runtime.team.team import Team
from understudy.storage.json_text import convert_decode_errors

NO_SIMULATION = "its robots are not simulated"


class AgentRunState(msgspec.Struct):
    """The run state of one agent, and when it started its program."""

    levels: list[StackFrame]
    entered: float


class CoordinatorSnapshot(msgspec.Struct):
    """A moment of a coordinator's body: the robots' world, the squads bottom-up, the agents below the trained ones."""

    ground: bytes
    squads: list[SquadState]
    runs: list[list[AgentRunState]]


class CoordinatorBody(BodyWrapper[Body]):
    """A body whose agents are the coordinators of one sort of squads, which have no coordinator above them.

    Parameters
    ----------
    team
        The team.
    name
        The sort of squads.
    """

    def __init__(self, team: Team, name: str) -> None:
        layer = team.layer(name)
        if not isinstance(layer.body, SquadBody):
            raise SessionError(f"{name} is not a sort of squads")
        super().__init__(team.ground)
        self.squads: SquadBody = layer.body
        self.team = team
        self._own, self._below = layer, team.layers[: team.layers.index(layer)]
        self.agents, self.readings = self.squads.agents, self.squads.readings
        self.channels = self.squads.channels

    def __repr__(self) -> str:
        coordinators = format_number_of(self.agents, "coordinator")
        return format_repr(
            self, f"of {self.squads.squad.name!r}", coordinators, f"on a {type(self.ground).__name__}"
        )

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """Compute statistics over the present readings of all members.

        Parameters
        ----------
        keys
            Pairs (statistic, target); the target is None where the statistic needs none.

        Returns
        -------
        Percept
            A column [S] for each key, with a value per squad. NaN where absent.
        """
        for layer in self._below:
            layer.percept = layer.body.sense(list_reading_keys(layer.body))
        return self.squads.sense(keys)

    def index_order(self, order: Order) -> int:
        """Return the number of an order.

        Parameters
        ----------
        order
            An order whose parameters are all bound to targets.

        Returns
        -------
        int
            The value that gives it on the channel ORDER.

        Raises
        ------
        UnknownName
            If members do not have the behavior that it names.
        """
        return self.squads.index_order(order)

    def act(self, commands: Commands) -> None:
        """Give orders, and let all agents below decide and act for one tick.

        Parameters
        ----------
        commands
            The number of the order of each squad [S], and the time at which it was given, s.
        """
        self.squads.act(commands)
        for layer in reversed(self._below):
            layer.body.act(layer.runner.decide(layer.percept))

    def reset(self, seeds: Sequence[int]) -> None:
        """Begin new worlds, without orders and memory.

        Parameters
        ----------
        seeds
            The seed of each world.
        """
        if not isinstance(self.ground, Resettable):
            raise SessionError(f"this squad cannot be reset: {NO_SIMULATION}")
        self.ground.reset(seeds)
        self.team.set_seeds(seeds)
        self.team.clear()

    def snapshot(self) -> bytes:
        """Return the whole state.

        Returns
        -------
        bytes
            The state, to be passed to `restore`.
        """
        if not isinstance(self.ground, Rewindable):
            raise SessionError(f"this squad cannot be rewound: {NO_SIMULATION}")
        squads = [
            layer.body.capture_state()
            for layer in (*self._below, self._own)
            if isinstance(layer.body, SquadBody)
        ]
        runs = [_kept(layer, self.time_s) for layer in self._below]
        return msgspec.msgpack.encode(CoordinatorSnapshot(self.ground.snapshot(), squads, runs))

    def restore(self, snapshot: bytes) -> None:
        """Go back to a snapshot.

        Parameters
        ----------
        snapshot
            What `snapshot` returned.

        Raises
        ------
        FileError
            If it is not a snapshot of such a body.
        """
        try:
            with convert_decode_errors():
                state = msgspec.msgpack.decode(snapshot, type=CoordinatorSnapshot)
        except msgspec.MsgspecError as error:
            raise _refused(f"is not a snapshot of a squad ({error})") from None
        layers = [layer for layer in (*self._below, self._own) if isinstance(layer.body, SquadBody)]
        if len(state.squads) != len(layers) or len(state.runs) != len(self._below):
            raise _refused("is of another team")
        if isinstance(self.ground, Rewindable):
            self.ground.restore(state.ground)
        self.team.clear()
        for layer, squads in zip(layers, state.squads, strict=True):
            if isinstance(layer.body, SquadBody):
                layer.body.restore(squads)
        for layer, agents in zip(self._below, state.runs, strict=True):
            _restore(layer, agents, self.time_s)


def _kept(layer: AgentLayer, now: float) -> list[AgentRunState]:
    if not isinstance(layer.runner, Run):
        raise SessionError("an engine runs this troop: only interpreters can be kept with it")
    return [
        AgentRunState(list(each.snapshot(now)), each.behavior_start_s) for each in layer.runner.interpreters
    ]


def _restore(layer: AgentLayer, agents: list[AgentRunState], now: float) -> None:
    if not isinstance(layer.runner, Run) or len(agents) != len(layer.runner.interpreters):
        raise _refused("is of another team")
    for interpreter, agent in zip(layer.runner.interpreters, agents, strict=True):
        interpreter.restore(agent.levels, now=now, entered=agent.entered)


def _refused(problem: str) -> FileError:
    return FileError(path="snapshot", place="", problem=problem, remedy="take it again")
