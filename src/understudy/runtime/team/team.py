"""Teams: robots at the leaves and coordinators above, all pulsed in one tick (docs/semantics.md, paper section 5).

A tick is: all sense, bottom-up; all decide, top-down; the members of a coordinator begin its new orders at once.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.errors import UnknownName
from understudy.model.drawing import format_number_of, format_repr
from understudy.model.features import ReadingKey
from understudy.model.library import Library
from understudy.model.squad import Squad
from understudy.runtime.body import Body, Fused
from understudy.runtime.engine.engine import Engine
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import IDLE_PROGRAM, Program
from understudy.runtime.run_loop import Run
from understudy.runtime.team.comms import CommsChannel, make_member_draw_keys
from understudy.runtime.team.compiled_squads import SquadCompiler
from understudy.runtime.team.members import (
    AgentLayer,
    Member,
    MemberGroup,
    Membership,
    Runner,
    check_members,
)
from understudy.runtime.team.squad_body import SquadBody
from understudy.runtime.team.team_programs import NO_OTHERS, TeamPrograms


@dataclass(frozen=True)
class TeamTree:
    """The team of one world: the types of robots, the type of each robot, and the squads, bottom-up.

    A member's band is an index into the types of robots followed by the sorts of squads before its own.
    """

    types: tuple[str, ...]
    type_of: tuple[int, ...]
    squads: tuple[tuple[Squad, tuple[tuple[Member, ...], ...]], ...]

    def __post_init__(self) -> None:
        check_members(self.types, self.type_of, self.squads)

    @property
    def names(self) -> tuple[str, ...]:
        """The sorts of agents, in the order of their bands."""
        return (*self.types, *(squad.name for squad, _ in self.squads))

    def close_downwards(self, names: Iterable[str]) -> frozenset[str]:
        """Return these sorts of agents, and those of their members."""
        sorts = frozenset(names)
        for squad, _ in reversed(self.squads):
            if squad.name in sorts:
                sorts |= {role.of for role in squad.roles}
        return sorts

    def mark_robots_below(self, name: str, number: int) -> NDArray[np.bool_]:
        """Return which robots [N] follow a squad of a sort, by its number, themselves or through squads below it."""
        marked, types = np.zeros(len(self.type_of), np.bool_), len(self.types)
        for member in next(squads for squad, squads in self.squads if squad.name == name)[number]:
            if member.band < types:
                marked[member.row] = True
            else:
                marked |= self.mark_robots_below(self.names[member.band], member.row)
        return marked


Makes: TypeAlias = Callable[[Body, Sequence[Program], Sequence[Program]], Runner]
"""A function that makes the runner of a body's agents: from their programs, and others that they may be ordered to
run."""


def make_interpreter_runner(body: Body, programs: Sequence[Program], others: Sequence[Program]) -> Runner:
    """Make a run with interpreters, the reference for all other runners."""
    return Run(body, [Interpreter(program, now=body.time_s) for program in programs], others)


class Team:
    """A team in B worlds side by side.

    Squads have a coordinator if `roots` gives them a behavior, if a squad above them does, or if their sort is
    `trained`.

    Parameters
    ----------
    ground
        The body of all robots.
    tree
        The team of one world.
    libraries
        The library of each sort of agents, by its name.
    roots
        For each sort, the behavior and the binding that agents outside of any squad run; agents of other sorts idle
        until they get an order.
    worlds
        The number B of worlds.
    makes
        The function that makes the runner of a body: interpreters, or an engine.
    trained
        The sort of squads whose coordinator is trained; it exists even without a root.
    delay_s
        Time that messages between coordinators and members take, s.
    loss
        Share of these messages that gets lost, 0 to 1.
    seeds
        The seed of each world, from which lost messages are drawn.
    programs
        For sorts of squads, the program of each coordinator of a world, in place of the root.
    """

    def __init__(
        self,
        ground: Body,
        tree: TeamTree,
        libraries: Mapping[str, Library],
        roots: Mapping[str, tuple[str, Mapping[str, str]]],
        *,
        worlds: int = 1,
        makes: Makes = make_interpreter_runner,
        trained: str | None = None,
        delay_s: float = 0.0,
        loss: float = 0.0,
        seeds: Sequence[int] = (),
        programs: Mapping[str, Sequence[Program]] = NO_OTHERS,
    ) -> None:
        self._radio = round(delay_s / ground.tick_s), loss, np.array(seeds or range(worlds), np.int64)
        self._channels = list[tuple[int, CommsChannel]]()
        self.ground, self.tree = ground, tree
        self._libraries, self._roots, self._trained = libraries, roots, trained
        squads = [squad for squad, _ in tree.squads]
        self._programs = TeamPrograms(tree.names, squads, libraries, roots, programs)
        self._given = programs
        self._led = tree.close_downwards({*roots, *([] if trained is None else [trained])})
        self._began: dict[int, list[tuple[Program, NDArray[np.intp]]]] = {}
        self.layers = self._built(worlds, makes)
        self._worlds, self._others = worlds, dict[int, dict[ReadingKey, None]]()
        self._plan_sensing()

    def _plan_sensing(self) -> None:
        self._keys = self._needed()
        fused = isinstance(self.ground, Fused) and SquadCompiler.is_possible(self.layers)
        self._leading = SquadCompiler(self.layers, self._keys, self._worlds) if fused else None

    def __repr__(self) -> str:
        robots, squads = len(self.tree.type_of), len(self.tree.squads)
        facts = [format_number_of(squads, "squad"), f"on a {type(self.ground).__name__}"]
        return format_repr(self, f"of {format_number_of(robots, 'robot')}", *facts)

    def _built(self, worlds: int, makes: Makes) -> tuple[AgentLayer, ...]:
        types, root, finds = self.tree.types, self._programs.roots, self._programs.finds
        alone = [root[types[kind]] for kind in self.tree.type_of] * worlds
        robots = self._layer(self.ground, alone, types, makes)
        self._layers_of = dict.fromkeys(types, robots)
        layers = [robots]
        bands = [MemberGroup(name, robots, finds[name]) for name in types]
        rows = [len(self.tree.type_of)] * len(types)
        for level, (squad, members) in enumerate(self.tree.squads):
            rows.append(len(members))
            if squad.name not in self._led:
                bands.append(
                    MemberGroup(squad.name, robots, finds[squad.name])
                )  # no agent of this team has it as a member
                continue
            roster = Membership.from_squads(members, worlds, rows)
            body = SquadBody(squad, roster, bands, self.ground, self._radio_of(level, len(roster) // worlds))
            each = self._given.get(squad.name, [root[squad.name]] * len(members))
            layer = self._layer(body, [*each] * worlds, (squad.name,), makes)
            layers.append(layer)
            bands.append(MemberGroup(squad.name, layer, finds[squad.name]))
            self._layers_of[squad.name] = layer
        return tuple(layers)

    def _radio_of(self, level: int, members: int) -> CommsChannel | None:
        ticks, loss, seeds = self._radio
        radio = CommsChannel(ticks, loss, make_member_draw_keys(seeds, members, level))
        self._channels.append((level, radio))
        return None if radio.is_perfect else radio

    def set_seeds(self, seeds: Sequence[int]) -> None:
        """Draw lost messages from now on as in worlds of these seeds.

        Parameters
        ----------
        seeds
            The seed of each world.
        """
        for level, radio in self._channels:
            members = len(radio.keys) // len(seeds)
            radio.keys[:] = make_member_draw_keys(np.array(seeds, np.int64), members, level)

    def with_ground(
        self, ground: Body, seeds: Sequence[int], programs: Mapping[str, Sequence[Program]]
    ) -> Team:
        """Make the same team in other worlds, run by the compiled engine.

        Parameters
        ----------
        ground
            The body of all robots in these worlds.
        seeds
            The seed of each world.
        programs
            For sorts of squads, the program of each coordinator of a world.

        Returns
        -------
        Team
            The team at time 0; this one does not change.
        """
        ticks, loss, _ = self._radio
        return Team(
            ground,
            self.tree,
            self._libraries,
            self._roots,
            worlds=len(seeds),
            makes=Engine,
            trained=self._trained,
            delay_s=ticks * ground.tick_s,
            loss=loss,
            seeds=seeds,
            programs=programs,
        )

    def _layer(
        self, body: Body, programs: Sequence[Program], names: Sequence[str], makes: Makes
    ) -> AgentLayer:
        others = [IDLE_PROGRAM, *(each for name in names for each in self._programs.orderable[name])]
        layer = AgentLayer(body, makes(body, programs, others))
        together: dict[int, list[int]] = {}
        for agent, program in enumerate(programs):
            together.setdefault(id(program), []).append(agent)
        self._began[id(layer)] = [(programs[mine[0]], np.array(mine)) for mine in together.values()]
        return layer

    def _needed(self) -> list[tuple[ReadingKey, ...]]:
        """List the readings of each layer: those of its own agents, and those of the statistics above."""
        needed: list[dict[ReadingKey, None]] = [
            dict.fromkeys((*layer.runner.keys, *self._others.get(number, ())))
            for number, layer in enumerate(self.layers)
        ]
        for number in reversed(range(len(self.layers))):
            body = self.layers[number].body
            if isinstance(body, SquadBody):
                below = {id(body.bands[band].layer) for band in np.unique(body.roster.band).tolist()}
                for key in body.list_needed_readings(list(needed[number])):
                    for lower, layer in enumerate(self.layers[:number]):
                        if id(layer) in below and key[0] in {reading.name for reading in layer.body.readings}:
                            needed[lower][key] = None
        return [tuple(keys) for keys in needed]

    def sense_also(self, name: str, keys: Sequence[ReadingKey]) -> None:
        """Let agents of a sort sense further readings from now on, besides those that their programs use.

        Parameters
        ----------
        name
            The sort of agents.
        keys
            The readings, each with its target if it needs one.
        """
        layer = self.layers.index(self.layer(name))
        self._others.setdefault(layer, {}).update(dict.fromkeys(keys))
        self._plan_sensing()

    def sense(self) -> None:
        """Let all agents sense, bottom-up; the layers have the readings then, the same for each call in one tick."""
        for layer, keys in zip(self.layers, self._keys, strict=True):
            layer.percept = layer.body.sense(keys)

    def tick(self) -> None:
        """Let all agents sense, decide and act once."""
        self.sense()
        for layer in reversed(self.layers):
            layer.commands = layer.runner.decide(layer.percept)
            layer.body.act(layer.commands)

    def run(self, ticks: int) -> None:
        """Run ticks: all at once if the robots' body can and the programs are data, otherwise one by one.

        Parameters
        ----------
        ticks
            The number of ticks.
        """
        robots, ground = self.layers[0].runner, self.ground
        if self._leading is None or not isinstance(ground, Fused) or not isinstance(robots, Engine):
            for _ in range(ticks):
                self.tick()
            return
        plan, lead = robots.plan(), self._leading.make_tables()
        if plan is not None:
            ground.advance(replace(plan, keys=lead.keys, lead=(lead.bands, lead.leads)), ticks, None)
            self._leading.write_back()

    def clear(self) -> None:
        """Restart all agents: no orders, no memory; agents outside of squads begin their programs."""
        for layer in self.layers:
            if isinstance(layer.body, SquadBody):
                layer.body.clear()
            for program, agents in self._began[id(layer)]:
                layer.runner.begin(agents, program)

    @property
    def paths(self) -> list[tuple[str, ...]]:
        """Return each robot's states, outermost first, beginning with the behavior it was ordered; () if it idles."""
        return self.list_paths(self.layers[0])

    def list_paths(self, layer: AgentLayer) -> list[tuple[str, ...]]:
        """List the states of the agents of a layer, robots or coordinators, as `paths` does for robots.

        Parameters
        ----------
        layer
            One of the team's layers.

        Returns
        -------
        list
            The states of each agent, outermost first.
        """
        paths = [layer.runner.path(row) for row in range(layer.body.agents)]
        for above in self.layers[1:]:
            if isinstance(above.body, SquadBody):
                roster = above.body.roster
                for duty, band, row in zip(above.body.ordering.duty, roster.band, roster.row, strict=True):
                    if duty is not None and above.body.bands[band].layer is layer:
                        paths[row] = (str(duty), *paths[row])
        return paths

    def find_raised(self, name: str, flags: Collection[str]) -> NDArray[np.bool_]:
        """Find the agents of a sort that have raised one of some flags.

        Parameters
        ----------
        name
            The sort of agents.
        flags
            Names of the flags.

        Returns
        -------
        array
            True for each such agent [N].
        """
        runner = self.layer(name).runner
        raised: NDArray[np.bool_] = np.logical_or.reduce([runner.find_raised(flag) for flag in flags])
        return raised

    @property
    def programs(self) -> Mapping[str, Sequence[Program]]:
        """The programs that agents of each sort run or may be ordered to run."""
        return self._programs.orderable

    def layer(self, name: str) -> AgentLayer:
        """Get the layer of a sort of agents.

        Parameters
        ----------
        name
            The sort of agents.

        Returns
        -------
        AgentLayer
            Its body and its runner.
        """
        if name not in self._layers_of:
            raise UnknownName(what="sort of agents", name=name, where="the team", known=list(self._layers_of))
        return self._layers_of[name]
