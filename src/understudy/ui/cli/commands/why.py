"""Command `understudy why`: explain what a robot of a recorded run did at some moment."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from understudy.ui.cli.options import LIBRARY, Json, KitName

if TYPE_CHECKING:
    from rich.console import Console

    from understudy.analysis.explain_run import AgentExplanation, DecisionReason, RunExplanation
    from understudy.analysis.explanation_text import WhyData

NEAR_S = 1e-6
"""Tolerance (s) within which two times are equal."""


def show_explanation(
    run: Annotated[
        Path,
        typer.Argument(help="Trace or recording written by `understudy run`, or trace of exported code."),
    ],
    time_s: Annotated[
        float | None,
        typer.Option("--time", "-t", min=0, help="Time of the moment, in seconds.", show_default=False),
    ] = None,
    agent: Annotated[
        str,
        typer.Option(
            "--agent", "-a", help="Index of the robot, from 0; or name of an agent of a team, or of a squad."
        ),
    ] = "0",
    library: Annotated[
        Path | None,
        typer.Option(
            "--library",
            "-l",
            help="Folder of the library, if it was moved since the run.",
            show_default=False,
        ),
    ] = None,
    world: Annotated[
        str | None,
        typer.Option(
            "--world", "-w", metavar="SCENARIO", help="Scenario, if its file was moved since the run."
        ),
    ] = None,
    exported: Annotated[
        bool, typer.Option("--exported", help="The file is a trace that exported code wrote.")
    ] = False,
    kit: KitName = None,
    as_json: Json = False,
) -> None:
    """Explain what a robot did at one moment: the decision of each level, its reason, and the examples.

    For a trace, the run is simulated again up to that moment. For a recording (.mcap), of simulated or real robots,
    decisions are made again from the recorded readings. If the library has changed since, stored former versions are
    used. If none of them matches the run, the command says so and exits with code 1.

    [dim]understudy run --library demo/library --seed 7 --trace run.jsonl[/]

    [dim]understudy why run.jsonl --time 12.5[/]

    With --exported it explains every switch in a trace of exported code, or the tick at --time, in the unit of the
    trace.

    [dim]understudy why --exported trace.csv --library demo/library[/]

    For recordings of agents (`understudy team merge`), it also explains who ordered that, when and why, from the
    recordings of their computers. Times count from the beginning of the file.

    [dim]understudy why team.mcap --agent scout_2 --time 12.5[/]
    """
    from understudy.errors import SettingError
    from understudy.ui.cli.output import make_console, print_json
    from understudy.ui.cli.recordings import is_recording

    if exported:
        from understudy.ui.cli.commands.why_exported import explain_exported

        explain_exported(run, library or LIBRARY, time=time_s, world=world, kit=kit, as_json=as_json)
        return
    if time_s is None:
        problem, remedy = "is missing", "give the time of the moment to explain, in seconds"
        raise SettingError(where="why", setting="--time", problem=problem, remedy=remedy)
    if is_recording(run):
        from understudy.robots.recording.team_reader import read_team_recording
        from understudy.ui.cli.commands.why_team import explain_agents

        team = read_team_recording(run)
        if team is not None:
            explain_agents(team, agent, time_s, library, kit=kit, as_json=as_json)
            return
    robot = _parse_index(agent)
    if is_recording(run):
        said, data = _of_recording(run, time_s, robot, library)
    else:
        said, data = _of_trace(run, time_s, robot, library, world, quiet=as_json)
    if as_json:
        print_json(data)
    else:
        _show(said, data, make_console())


def _parse_index(agent: str) -> int:
    from understudy.errors import SettingError

    if not agent.isdecimal():
        remedy = "give the index of a robot, from 0; agents of teams have names"
        raise SettingError(where="why", setting="--agent", problem=f"is {agent!r:.60}", remedy=remedy)
    return int(agent)


def _of_trace(
    run: Path, time_s: float, robot: int, library: Path | None, world: str | None, *, quiet: bool
) -> tuple[RunExplanation, WhyData]:
    """Explain a moment of a traced run, by simulating it again."""
    from understudy.analysis.explain_run import RunNotReproducible
    from understudy.analysis.explain_run import explain_run as reasons
    from understudy.analysis.explanation_text import WhyData
    from understudy.analysis.run_header import fingerprint_scenario, read_recorded_tick
    from understudy.ui.cli.library_data import load_recorded_libraries
    from understudy.ui.cli.options import find_kit, open_scenario

    found = read_recorded_tick(run, robot=robot, time_s=time_s)
    ran = found.ran
    where = open_scenario(world or found.scenario)
    if fingerprint_scenario(where) != ran.world:
        remedy = "run it again with --trace, or name the scenario as it was with --world"
        raise RunNotReproducible(problem=f"the scenario {where.name} is another by now", remedy=remedy)
    parts = find_kit(ran.kit, world or found.scenario)
    known, former = load_recorded_libraries(
        where, found.behavior, library or Path(ran.library), parts, ran.automata
    )
    header, row = found.header, found.row
    said = reasons(found, where, known)
    return said, WhyData.from_explanation(said, former, header.scenario, header.seed, row.robot, row.doing)


def _of_recording(
    run: Path, time_s: float, robot: int, library: Path | None
) -> tuple[RunExplanation, WhyData]:
    """Explain a moment of a recording, by deciding again from its readings."""
    from understudy.analysis.explain_run import explain_recorded_tick
    from understudy.analysis.explanation_text import WhyData
    from understudy.analysis.rerun import Rerun
    from understudy.analysis.run_trace import BETWEEN
    from understudy.errors import SettingError
    from understudy.robots.recording.reader import read_recording
    from understudy.ui.cli.library_data import load_recorded_libraries
    from understudy.ui.cli.recordings import choose_recording_kit, read_recorded_scenario

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
    doing = BETWEEN.join(recording.paths[robot][tick])
    return said, WhyData.from_explanation(said, former, called, ran.seed, robot, doing)


def _show(said: RunExplanation, data: WhyData, out: Console) -> None:
    from rich.markup import escape

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
    from rich.markup import escape

    if several:
        ordered = each.ordered
        under = "" if ordered is None else f", ordered to {ordered}" if ordered else ", without orders"
        out.print(f"\n[bold]{escape(each.sort)} {each.agent}[/]{escape(under)}")
    if not each.levels:
        out.print("  runs no automaton: nothing is decided", soft_wrap=True)
    print_levels(each, out)


def print_levels(each: AgentExplanation, out: Console) -> None:
    """Print the decision of every level of an agent."""
    from rich.markup import escape

    from understudy.analysis.explanation_text import describe_rest

    for level in each.levels:
        since = f"in {level.state} since {round_values(level.since_s)} s"
        out.print(f"\n[cyan]{escape(level.automaton)}[/] {escape(since)}")
        if level.decision is None:
            out.print(f"  stays: {escape(describe_rest(level))}", soft_wrap=True)
        else:
            print_decision(level.decision, out)


def print_decision(reason: DecisionReason, out: Console) -> None:
    """Print a decision, the readings behind it, and the examples it comes from."""
    from rich.markup import escape
    from rich.padding import Padding

    from understudy.analysis.explanation_text import describe_decision, describe_source, describe_values

    read, source = describe_values(reason), describe_source(reason)
    lines = [escape(describe_decision(reason.explanation))]
    if read:
        lines.append(f"[dim]it read {escape(read)}[/]")
    if source:
        lines.append(f"[dim]{source}[/]" if reason.taught.lesson is None else source)
    for line in lines:
        out.print(Padding(line, (0, 0, 0, 2), expand=False))


def round_values(time_s: float) -> str:
    """Format a time (s), rounded as in `--json`."""
    from understudy.analysis.explanation_text import DIGITS

    return f"{round(time_s, DIGITS):g}"
