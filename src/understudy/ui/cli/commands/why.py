"""Command `understudy why`: explain what a robot of a recorded run did at some moment."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rich.markup import escape

from understudy.errors import SettingError
from understudy.judging.explain_run import (
    AgentExplanation,
    RunExplanation,
    RunNotReproducible,
    explain_recorded_tick,
)
from understudy.judging.explain_run import explain_run as reasons
from understudy.judging.explanation_text import WhyData
from understudy.judging.rerun import Rerun
from understudy.judging.run_header import fingerprint_scenario, read_recorded_tick
from understudy.records.reader import read_recording
from understudy.records.record import BETWEEN
from understudy.records.team_reader import read_team_recording
from understudy.sim.catalog import find_scenario
from understudy.ui.cli.commands.why_team import explain_agents, print_decision, print_levels, round_values
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.named_inputs import find_kit
from understudy.ui.cli.output import make_console
from understudy.ui.cli.recorded_runs import (
    choose_recording_kit,
    is_recording,
    load_recorded_libraries,
    read_recorded_scenario,
)
from understudy.ui.cli.run_options import WhyOptions

if TYPE_CHECKING:
    from rich.console import Console

NEAR_S = 1e-6
"""Tolerance (s) within which two times are equal."""


def show_explanation(options: WhyOptions) -> None:
    """Explain what a robot did at one moment: the decision of each level, its reason, and the examples."""
    if options.time_s is None:
        problem, remedy = "is missing", "give the time of the moment to explain, in seconds"
        raise SettingError(where="why", setting="--time", problem=problem, remedy=remedy)
    if is_recording(options.run):
        team = read_team_recording(options.run)
        if team is not None:
            explain_agents(
                team, options.agent, options.time_s, options.library, kit=options.kit, as_json=options.as_json
            )
            return
    robot = _parse_index(options.agent)
    if is_recording(options.run):
        said, data = _of_recording(options.run, options.time_s, robot, options.library)
    else:
        said, data = _of_trace(
            options.run, options.time_s, robot, options.library, options.world, quiet=options.as_json
        )
    if options.as_json:
        print_json(data)
    else:
        _show(said, data, make_console())


def _parse_index(agent: str) -> int:
    if not agent.isdecimal():
        remedy = "give the index of a robot, from 0; agents of teams have names"
        raise SettingError(where="why", setting="--agent", problem=f"is {agent!r:.60}", remedy=remedy)
    return int(agent)


def _of_trace(
    run: Path, time_s: float, robot: int, library: Path | None, world: str | None, *, quiet: bool
) -> tuple[RunExplanation, WhyData]:
    """Explain a moment of a traced run, by simulating it again."""
    found = read_recorded_tick(run, robot=robot, time_s=time_s)
    ran = found.ran
    where = find_scenario(world or found.scenario)
    if fingerprint_scenario(where) != ran.world:
        remedy = "run it again with --trace, or name the scenario as it was with --world"
        raise RunNotReproducible(problem=f"the scenario {where.name} is another by now", remedy=remedy)
    parts = find_kit(ran.kit, world or found.scenario)
    known, former = load_recorded_libraries(
        where, found.behavior, library or Path(ran.library), parts, ran.automata
    )
    header = found.header
    said = reasons(found, where, known)
    return said, WhyData.from_explanation(
        said, former, header.scenario, header.seed, found.robot, found.format_states()
    )


def _of_recording(
    run: Path, time_s: float, robot: int, library: Path | None
) -> tuple[RunExplanation, WhyData]:
    """Explain a moment of a recording, by deciding again from its readings."""
    recording = read_recording(run)
    ran, names = recording.head.ran, recording.head.names
    if not 0 <= robot < len(names):
        remedy = f"count from 0 to {len(names) - 1}"
        raise SettingError(where=str(run), setting="--agent", problem=f"is {robot}", remedy=remedy)
    if time_s > recording.times[-1] + recording.head.tick_s:
        problem, remedy = f"is {time_s:g}, after the run had ended", f"give at most {recording.times[-1]:g}"
        raise SettingError(where=str(run), setting="--time", problem=problem, remedy=remedy)
    if ran.behavior is None:
        problem, remedy = "ran: a person taught", "give a recording of a run"
        raise SettingError(where=str(run), setting="no automaton", problem=problem, remedy=remedy)
    where = read_recorded_scenario(recording)
    folder, parts = library or Path(ran.library), choose_recording_kit(recording, None, where)
    known, former = load_recorded_libraries(where, ran.behavior, folder, parts, ran.automata)
    sorts = [each for each in ran.sorts if each in known] or list(known)[:1]
    rerun = Rerun(recording, known, sorts, ran.behavior, binding=ran.binding, scenario=where)
    tick = max(0, int(sum(recording.times <= time_s + NEAR_S)) - 1)
    said = explain_recorded_tick(rerun, robot, tick)
    called = (ran.scenario or names[robot]) if where is None else where.name
    doing = BETWEEN.join(recording.records[robot].states[tick])
    return said, WhyData.from_explanation(said, former, called, ran.seed, robot, doing)


def _show(said: RunExplanation, data: WhyData, out: Console) -> None:
    head = f"robot {data.robot} of {data.scenario} {data.seed} at {data.time_s:g} s"
    out.print(f"[bold]{escape(head)}[/]: {escape(data.doing or 'nothing')}", soft_wrap=True)
    for name, version in data.former.items():
        out.print(f"[dim]{escape(name)} is another by now: this is its version {version}[/]", soft_wrap=True)
    for each in said.agents:
        _show_agent(each, out, several=len(said.agents) > 1)
    last = said.last
    if not data.switched and last is not None:
        out.print(
            f"\n[bold]The last switch[/], at {round_values(last.time_s)} s, of {escape(last.automaton)}",
        )
        print_decision(last, out)


def _show_agent(each: AgentExplanation, out: Console, *, several: bool) -> None:
    if several:
        ordered = each.ordered
        under = "" if ordered is None else f", ordered to {ordered}" if ordered else ", without orders"
        out.print(f"\n[bold]{escape(each.sort)} {each.agent}[/]{escape(under)}")
    if not each.levels:
        out.print("  runs no automaton: nothing is decided", soft_wrap=True)
    print_levels(each, out)
