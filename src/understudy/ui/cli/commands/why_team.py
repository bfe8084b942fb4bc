"""Decisions printed as text, and `understudy why` across the recordings of a team's agents."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.markup import escape
from rich.padding import Padding

from understudy.judging.explain_team import AgentMoment, OrderSummary, ReportSummary, explain_team_moment
from understudy.judging.explanation_text import (
    DIGITS,
    DecisionLevelData,
    describe_decision,
    describe_rest,
    describe_source,
    describe_values,
)
from understudy.storage.json_text import select_facts
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.output import make_console
from understudy.ui.cli.recorded_runs import (
    choose_recording_kit,
    load_recorded_libraries,
    read_recorded_scenario,
)

if TYPE_CHECKING:
    from rich.console import Console

    from understudy.judging.explain_run import AgentExplanation, DecisionReason
    from understudy.records.reader import Recording
    from understudy.records.team_reader import TeamRecording
    from understudy.sim.team.libraries import Libraries


def print_levels(each: AgentExplanation, out: Console) -> None:
    """Print the decision of every level of an agent."""
    for level in each.levels:
        since = f"in {level.state} since {round_values(level.since_s)} s"
        out.print(f"\n[cyan]{escape(level.automaton)}[/] {escape(since)}")
        if level.decision is None:
            out.print(f"  stays: {escape(describe_rest(level))}", soft_wrap=True)
        else:
            print_decision(level.decision, out)


def print_decision(reason: DecisionReason, out: Console) -> None:
    """Print a decision, the readings behind it, and the examples it comes from."""
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
    return f"{round(time_s, DIGITS):g}"


def explain_agents(
    team: TeamRecording,
    agent: str,
    time_s: float,
    library: Path | None,
    *,
    kit: str | None,
    as_json: bool,
) -> None:
    """Explain what an agent of a team did at a moment of a recording, and why it was ordered to.

    Parameters
    ----------
    team
        The recording.
    agent
        The name of the agent.
    time_s
        The moment, from the beginning of the recording, s.
    library
        The folder of the team's automata. None: where it was when the recording was made.
    kit
        The kit of the automata. None: as the recording says.
    as_json
        Whether to print JSON.
    """
    former: dict[str, int] = {}

    def load(recording: Recording) -> Libraries:
        return _load_libraries(recording, library, kit, former)

    moments = explain_team_moment(team, agent, time_s, load)
    if as_json:
        agents = [_describe_moment(each) for each in moments]
        print_json({"recording": team.path, "reference": team.clock.reference, "agents": agents})
    else:
        _show(team, moments, former, make_console())


def _load_libraries(
    recording: Recording, library: Path | None, kit: str | None, former: dict[str, int]
) -> Libraries:
    ran, where = recording.head.ran, read_recorded_scenario(recording)
    parts = choose_recording_kit(recording, kit, where)
    known, versions = load_recorded_libraries(
        where, ran.behavior, library or Path(ran.library), parts, ran.automata
    )
    former.update(versions)
    return known


def _describe_moment(moment: AgentMoment) -> dict[str, Any]:
    """Describe an agent at a moment for `--json`: what it did, its order, and what it had heard of its members."""
    names = ("agent", "host", "time_s", "error_s", "doing", "order", "levels", "reports", "missing")
    levels = [DecisionLevelData.from_level(level) for level in moment.explanation.levels]
    return select_facts(moment, *names, levels=levels)


def _show(team: TeamRecording, moments: Sequence[AgentMoment], former: dict[str, int], out: Console) -> None:
    for name, version in former.items():
        out.print(f"[dim]{escape(name)} is another by now: this is its version {version}[/]", soft_wrap=True)
    for number, each in enumerate(moments):
        if number:
            out.print()
        _show_moment(each, out, has_decided=number > 0)
    out.print(f"\n[dim]Times are by the clock of {escape(team.clock.reference)}.[/]", soft_wrap=True)


def _show_moment(each: AgentMoment, out: Console, *, has_decided: bool) -> None:
    name = each.agent if each.host == each.agent else f"{each.agent} (led by {each.host})"
    what = "decided at" if has_decided else "at"
    error = f" ± {each.error_s * 1e3:.2g} ms" if each.error_s else ""
    doing = " > ".join(each.doing) or "nothing"
    out.print(f"[bold]{escape(name)} {what} {each.time_s:.3f} s[/]{error}: {escape(doing)}", soft_wrap=True)
    if each.order is not None:
        out.print(escape(_describe_order(each.order)), soft_wrap=True)
    elif not each.reports:  # a robot
        out.print("without an order: it does what it runs alone")
    if not each.explanation.levels:
        out.print("  runs no automaton: nothing is decided", soft_wrap=True)
    print_levels(each.explanation, out)
    if each.reports:
        out.print(f"\n  reports: {escape('; '.join(map(_describe_report, each.reports)))}", soft_wrap=True)
    if each.missing:
        out.print(f"\nWhy it was ordered is not known: {escape(each.missing)}.", soft_wrap=True)


def _describe_order(order: OrderSummary) -> str:
    term, number = order.order
    duty = f"to {order.duty}" if order.duty else "to do nothing"
    return f"ordered {duty} by {order.leader}: order {term}.{number} of {order.squad}, begun at {order.heard_s:.3f} s"


def _describe_report(report: ReportSummary) -> str:
    if report.unfit:
        return f"{report.member} not counted ({report.unfit})"
    flag = f" {report.flag}" if report.flag else ""
    order = " without an order" if report.order is None else f" on {report.order[0]}.{report.order[1]}"
    read = "".join(f", {name} {value:g}" for name, value in report.readings.items())
    return f"{report.member}{flag}{order}{read} ({(report.age_s or 0.0) * 1e3:.0f} ms old)"
