"""Try the findings of a check in worlds: how often what they describe happens while the library's behaviors run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from understudy.addons.checks.verification.check_library import CheckReport
from understudy.addons.checks.verification.finding import (
    Finding,
    FindingKind,
    FindingTrial,
    Severity,
    sort_findings,
)
from understudy.errors import UnderstudyError, UnknownName
from understudy.judging.behavior_run import BehaviorRun, ProgramRun
from understudy.judging.criteria import Criteria
from understudy.judging.evaluate import find_runners
from understudy.judging.evaluation_task import EvaluationTask
from understudy.judging.rollout import Instant, Monitor, roll_out
from understudy.model.features import (
    AnyFeature,
    BoundFeature,
    CounterFeature,
    Feature,
    FlagFeature,
    TimerFeature,
)
from understudy.model.library import Library
from understudy.model.tree_regions import ValueSet
from understudy.model.value_kinds import Column
from understudy.runtime.engine.compiler import StateSlot
from understudy.runtime.engine.engine import Engine
from understudy.runtime.feature_columns import FeatureColumns
from understudy.runtime.team.members import AgentLayer
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries
from understudy.sim.world import World

FIRST_SEED, LIMIT_S = 8_000_000, 300.0
"""The seed of the first world, and the longest run in one, s."""
CYCLES = (FindingKind.CHATTER, FindingKind.CYCLE, FindingKind.REPEATED_ORDER)
UNTRIED = (FindingKind.OUTLIER, FindingKind.NEVER_ENTERED, FindingKind.MISSING_BEHAVIOR)
"""The kinds of findings that are not tried: those about examples, and those about states that never run."""


def try_findings(
    report: CheckReport, libraries: Library | Libraries, scenario: Scenario, *, worlds: int
) -> CheckReport:
    """Try the errors and warnings of a report in new worlds, and sort them by how often they happen there.

    Automata without parameters that no other one runs are run in turn by all robots, those of coordinators first, until
    the scenario's goal is reached, all stand in a dead end for good, or `LIMIT_S` have passed. A finding is tried in
    the first that runs its automaton. A cycle happens where its states follow each other once around in its cell, a
    dead end where an agent has stayed there for more than a tick, and anything else where an agent is in the state and
    the cell.

    Parameters
    ----------
    report
        The report of a check of the libraries.
    libraries
        The library, whose behaviors all robots run; or for a team the library of each sort of agents.
    scenario
        The scenario.
    worlds
        The number of worlds.

    Returns
    -------
    CheckReport
        The report with trials. What cannot be run is one of `unchecked`.
    """
    findings, unchecked = list(report.findings), list(report.unchecked)
    seeds = range(FIRST_SEED, FIRST_SEED + worlds)
    for root in _list_roots(libraries):
        waiting = [at for at, each in enumerate(findings) if _is_tried(each) and each.trial is None]
        if not waiting or not worlds:
            break
        try:
            run = _make_run(libraries, root, scenario, seeds)
            watches = {at: watch for at in waiting for watch in _watch_finding(findings[at], run, worlds)}
            _run_watched(run, [*watches.values()])
        except UnderstudyError as error:
            unchecked.append(f"what happens while {root} runs: {error}")
            continue
        for at, watch in watches.items():
            findings[at] = replace(findings[at], trial=watch.result)
    return replace(report, findings=sort_findings(findings), unchecked=tuple(unchecked))


def _is_tried(finding: Finding) -> bool:
    return finding.severity is not Severity.NOTE and finding.kind not in UNTRIED


def _list_roots(libraries: Library | Libraries) -> Iterator[str]:
    """Yield the automata without parameters that no other runs, those of coordinators first."""
    by_sort = {"": libraries} if isinstance(libraries, Library) else libraries
    listed: set[int] = set()
    for sort, library in reversed([*by_sort.items()]):  # squads come after their members
        if id(library) not in listed:
            listed.add(id(library))
            tops = [name for name in library.taught if not library.find_users(name)]
            usable = [name for name in tops if not library.automaton(name).parameters]
            yield from (f"{sort}/{name}" if sort else name for name in usable)


def _make_run(
    libraries: Library | Libraries, root: str, scenario: Scenario, seeds: Sequence[int]
) -> BehaviorRun:
    runners, sort, behavior, _ = find_runners(libraries, root, scenario)
    criteria = Criteria(None, frozenset(), {}, {})
    return EvaluationTask(runners, sort, behavior, scenario, {}, criteria, None).make_run(scenario, seeds)


def _list_layers(run: BehaviorRun, sort: str) -> Iterator[tuple[Engine, AgentLayer | None]]:
    """Yield the engine of the agents of a sort ("": of all robots), and their layer in a team, if the run has them."""
    if isinstance(run, ProgramRun):
        if not sort or (isinstance(run.body, World) and sort in run.body.scenario.types):
            yield run.engine, None
    elif run.team is not None:
        try:
            layer = run.team.layer(sort) if sort else run.team.layers[0]
        except UnknownName:  # no agents of this sort take part
            return
        if isinstance(layer.runner, Engine):
            yield layer.runner, layer


def _watch_finding(finding: Finding, run: BehaviorRun, worlds: int) -> Iterator[_Watch]:
    """Yield the watch of a finding, if the behavior runs its automaton."""
    sort, _, _ = finding.automaton.rpartition("/")
    for engine, layer in _list_layers(run, sort):
        watch = _Watch(finding, engine, layer, worlds)
        if watch.is_possible:
            yield watch


def _run_watched(run: BehaviorRun, watches: Sequence[_Watch]) -> None:
    if watches:
        limit_s = min(LIMIT_S, run.get_world().scenario.limit_s)
        roll_out(run, [_WatchedTicks(run, watches, limit_s)], limit_s, to_goal=True)


class _WatchedTicks(Monitor):
    """Observer that lets watches look before each tick, and ends worlds in which nothing more can happen."""

    def __init__(self, run: BehaviorRun, watches: Sequence[_Watch], limit_s: float) -> None:
        super().__init__(run.worlds)
        self._run, self._watches = run, watches
        self._last = int(run.count_ticks_left(np.array([limit_s]))[0])
        self._sensing = {
            id(each.engine): FeatureColumns(each.engine.compiled.features, each.engine.body)
            for each in watches
        }

    def look(self, now: Instant) -> None:
        """Let each watch look, if a tick follows."""
        if now.tick >= self._last:
            return
        if self._run.team is not None:
            self._run.team.sense()
        columns = dict[int, NDArray[np.float64]]()
        for watch in self._watches:
            key, engine = id(watch.engine), watch.engine
            if key not in columns:
                percept = engine.body.sense(engine.keys) if watch.layer is None else watch.layer.percept
                columns[key] = self._sensing[key].columns(percept)
            stuck = watch.look(columns[key], now.time_s, now.running)
            if watch.is_for_good:
                self.over |= now.running & stuck


class _Watch:
    """A counter of the worlds in which the agents of an engine meet the condition of one finding."""

    def __init__(self, finding: Finding, engine: Engine, layer: AgentLayer | None, worlds: int) -> None:
        self.finding, self.engine, self.layer = finding, engine, layer
        name, agents = finding.automaton.rpartition("/")[2], engine.body.agents
        self._slots = [
            (number, place, [self._locate(cell.features, cell.box, place) for cell in finding.cells])
            for number, place in enumerate(engine.compiled.places)
            if place.automaton == name and place.state in finding.states
        ]
        self._happened, self._of = np.zeros(worlds, np.bool_), np.arange(agents) // (agents // worlds)
        self._ticks, self._meetings = 0, 0
        self._in = np.full(agents, -1)
        self._since = np.full(agents, np.nan)
        self._looks, self._switches = np.zeros(agents, np.int64), np.zeros(agents, np.int64)

    @property
    def is_possible(self) -> bool:
        """True if the behavior runs the automaton."""
        return bool(self._slots)

    @property
    def result(self) -> FindingTrial:
        """The number of worlds, and the share of ticks, in which the condition of the finding was met."""
        share = self._meetings / max(self._ticks, 1)
        return FindingTrial(len(self._happened), int(self._happened.sum()), share)

    def _locate(
        self, features: Sequence[BoundFeature], box: Sequence[ValueSet], place: StateSlot
    ) -> list[tuple[int | AnyFeature, ValueSet]]:
        """Return the tests of a cell where its automaton has certain targets: columns, or own features, with values."""
        columns = {bound: at for at, bound in enumerate(self.engine.compiled.features)}
        return [
            (
                columns[BoundFeature(bound.feature, bound.binding.substitute(place.binding))]
                if isinstance(bound.feature, Feature)
                else bound.feature,
                region,
            )
            for bound, region in zip(features, box, strict=True)
        ]

    @property
    def is_for_good(self) -> bool:
        """Whether nothing more happens in a world in which it has happened to all agents."""
        return self.finding.kind is FindingKind.DEAD_END and self.finding.severity is Severity.ERROR

    def look(self, columns: NDArray[np.float64], now: float, going: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Count who is there before a tick, in the worlds [B] that have not ended; return where all are [B]."""
        here, since = np.full(len(self._in), -1), np.full(len(self._in), np.nan)
        stacks, children = self.engine.stacks, self.engine.compiled.tables.states["child"]
        runs = stacks.root >= 0
        for level in range(stacks.state.shape[1]):
            states = stacks.state[:, level]
            for number, place, cells in self._slots:
                there = runs & (states == number)
                if there.any():
                    there &= self._is_inside(cells, columns, place, level, now)
                    here[there], since[there] = number, stacks.entered[there, level]
            runs = runs & (children[states] >= 0)
        is_there: NDArray[np.bool_] = np.greater_equal(here, 0)
        goes_on = is_there & (self._in >= 0)
        moved = (here != self._in) | (since != self._since)
        self._looks = np.where(goes_on, self._looks + 1, is_there)
        self._switches = np.where(goes_on, self._switches + moved, 0)
        self._in, self._since = here, since
        counted, least = self._looks, 1
        if self.finding.kind in CYCLES:
            counted, least = self._switches, len(self.finding.states)
        elif self.finding.kind is FindingKind.DEAD_END:
            least = 2
        met: NDArray[np.bool_] = is_there & going[self._of] & (counted >= least)
        self._ticks += int(going[self._of].sum())
        self._meetings += int(met.sum())
        self._happened[self._of[met]] = True
        return np.asarray(met.reshape(len(going), -1).all(axis=1))

    def _is_inside(
        self,
        cells: Sequence[Sequence[tuple[int | AnyFeature, ValueSet]]],
        columns: NDArray[np.float64],
        place: StateSlot,
        level: int,
        now: float,
    ) -> NDArray[np.bool_]:
        """Return which agents [N] have readings in one of the cells; for a dead end, and a flag raised below them."""
        inside = np.full(len(self._in), not cells)
        for cell in cells:
            both = np.ones(len(self._in), np.bool_)
            for what, region in cell:
                if isinstance(what, int):
                    values = columns[what]
                else:
                    values = read_own_column(self.engine, what, place, level=level, now=now)
                both &= _contains(region, values)
            inside |= both
        is_over = self.finding.kind is FindingKind.DEAD_END
        return inside & (find_flags_below(self.engine, level) >= 0) if is_over else inside


def find_flags_below(engine: Engine, level: int) -> NDArray[np.int64]:
    """Return the number of the flag that the automaton below a level has raised [N]; less than 0 for none."""
    tables, states = engine.compiled.tables.states, engine.stacks.state
    if level + 1 == states.shape[1]:
        return np.full(len(states), -1)
    return np.where(tables["child"][states[:, level]] >= 0, tables["flag"][states[:, level + 1]], -1)


def read_own_column(
    engine: Engine, feature: AnyFeature, place: StateSlot, *, level: int, now: float
) -> Column:
    """Read an own feature of the automaton at a level, as its tree does [N]."""
    stacks, compiled = engine.stacks, engine.compiled
    if isinstance(feature, FlagFeature):
        return np.asarray(find_flags_below(engine, level) == compiled.flags.get(feature.name, -2), np.float64)
    if isinstance(feature, CounterFeature):
        return np.nan_to_num(stacks.memory[:, place.memory["counter", feature.name]])
    is_timer = isinstance(feature, TimerFeature)
    since = stacks.memory[:, place.memory["timer", feature.name]] if is_timer else stacks.entered[:, level]
    elapsed: Column = np.round(now - since, 9)
    return elapsed


def _contains(region: ValueSet, values: Column) -> NDArray[np.bool_]:
    """Return which values [N] are in a region."""
    inside: NDArray[np.bool_] = np.isnan(values) if region.absent else np.zeros(len(values), np.bool_)
    for low, high in region.parts:
        inside = inside | ((low <= values) & (values < high))
    return inside
