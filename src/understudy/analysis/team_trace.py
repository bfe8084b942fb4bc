"""Traces of teams: the columns that a team's trace has, and each tick of its robots and coordinators."""

from __future__ import annotations

from understudy.analysis.run_trace import AgentTick, ReadingInfo, TraceColumns, TraceWriter
from understudy.model.kinds import Column
from understudy.robots.recording.message_types import format_reading_label
from understudy.runtime.team.members import AgentLayer
from understudy.runtime.team.squad_body import SquadBody
from understudy.runtime.team.team import Team
from understudy.sim.view import WorldView


def describe_trace_columns(team: Team) -> TraceColumns:
    """Describe the readings that the automata of a team's robots and coordinators use, and the robots' commands."""
    robots, *above = team.layers
    return TraceColumns(
        readings=_describe_readings(robots),
        commands={channel.name: channel.unit for channel in robots.body.channels},
        coordinators={
            layer.body.squad.name: _describe_readings(layer)
            for layer in above
            if isinstance(layer.body, SquadBody)
        },
    )


def _describe_readings(layer: AgentLayer) -> dict[str, ReadingInfo]:
    known = {reading.name: reading for reading in layer.body.readings}
    return {
        format_reading_label(key): ReadingInfo(str(known[key[0]].kind), known[key[0]].unit)
        for key in layer.runner.keys
    }


def add_team_tick(trace: TraceWriter, team: Team, view: WorldView, paths: list[tuple[str, ...]]) -> None:
    """Add the last tick of a team to its trace.

    `view` is the world after it, and `paths` has the states of each robot, outermost first.
    """
    robots, *above = team.layers
    trace.add(
        view,
        paths,
        readings=_list_readings(robots),
        commands=robots.commands,
        coordinators={
            layer.body.squad.name: AgentTick(team.list_paths(layer), _list_readings(layer))
            for layer in above
            if isinstance(layer.body, SquadBody)
        },
    )


def _list_readings(layer: AgentLayer) -> dict[str, Column]:
    return {format_reading_label(key): layer.percept[key] for key in layer.runner.keys}
