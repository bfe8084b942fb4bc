"""The failing worlds that the studio lists, and their runs with what is in training, beside the world on the page."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from understudy.addons.checks.falsification.failing_world import (
    FailingWorld,
    RerunVerdict,
    list_failing_worlds,
)
from understudy.errors import UnderstudyError, UnknownName
from understudy.sim.scenario.schema import Scenario
from understudy.ui.controller.beside import Beside
from understudy.ui.controller.failing_worlds import (
    LibrarySource,
    RerunResults,
    make_draft,
    rerun_all,
)
from understudy.ui.controller.status import StatusMessage
from understudy.ui.controller.trainer import Trainer
from understudy.ui.web.background import BackgroundRun, LessonIdentity
from understudy.ui.web.messages.base import Data

QUICK_S = 1.0
"""Where all runs together take less than this, they are repeated by themselves whenever the lesson changed, s."""
REST_S = 1.0
"""The least time between the end of the runs and their repetition, s."""


class FailingWorldData(Data, frozen=True, kw_only=True):
    """A failing world of the list."""

    name: str
    """The name of its folder."""
    behavior: str
    world: str
    summary: str
    """A short description of the failure as it was found."""
    sentences: list[str]
    """The moment, the decision, and what followed."""
    state: RerunVerdict
    """The result with the automaton in training; "unknown" if the world could not be run."""
    problem: str
    """Why it could not be run; empty if it could."""


class FailuresData(Data, frozen=True, kw_only=True):
    """The failing worlds, the worst and most different first."""

    folder: str
    worlds: list[FailingWorldData]
    problems: list[str]
    """A sentence about each that cannot be read."""
    running: bool
    finished: int
    """The number of worlds that have been run again, while they are run."""
    stale: bool
    """True if the lesson changed after they were run."""
    open: str | None
    """The name of the failing world that is on the page."""
    previous_world: str | None
    """The name of the world that was on the page before the failing one."""


class FailingWorldList:
    """The failing worlds of a folder, and the results of running them again; None as `folder`: there are none."""

    def __init__(self, folder: Path | None, wall: Callable[[], float], beside: Beside) -> None:
        self.folder, self._wall, self._beside = folder, wall, beside
        self.before: tuple[Scenario, int] | None = None  # the world before the failing one, and its seed
        self._opened: tuple[str, Scenario] | None = None  # the failing world that was opened last
        self.result: RerunResults | None = None
        self._running: BackgroundRun[RerunResults] | None = None
        self._lesson = LessonIdentity()
        self._ended_s, self._quick = -REST_S, False
        self.worlds, self._problems = tuple[FailingWorld, ...](), tuple[str, ...]()
        self.read()

    @property
    def is_running(self) -> bool:
        """True from the beginning of runs until `advance` has taken over their results."""
        return self._running is not None

    def read(self) -> None:
        """Read the folder again."""
        if self.folder is None:
            return
        try:
            self.worlds, self._problems = list_failing_worlds(self.folder)
        except UnderstudyError as error:
            self.worlds, self._problems = (), (str(error),)

    def find(self, name: str) -> FailingWorld:
        """Find a failing world by the name of its folder; UnknownName if it is not listed."""
        worlds = {each.folder.name: each for each in self.worlds}
        if name not in worlds:
            raise UnknownName(what="failing world", name=name, where=str(self.folder), known=list(worlds))
        return worlds[name]

    def note_opened(self, name: str, entered: Scenario, former: Scenario, seed: int) -> None:
        """Note that a failing world is entered, from a world of another scenario with this seed."""
        if self.find_open(former) is None:
            self.before = former, seed
        self._opened = name, entered

    def find_open(self, scenario: Scenario) -> str | None:
        """Return the name of the failing world whose scenario this is; None if it is that of none."""
        return self._opened[0] if self._opened is not None and self._opened[1] is scenario else None

    def begin_rerun(self, library: LibrarySource, trainer: Trainer | None) -> None:
        """Begin to run all of them again; runs that have not ended are cancelled."""
        self.cancel()
        self._lesson.note_run(trainer)
        work = partial(rerun_all, self.worlds, library, make_draft(trainer))
        self._running = BackgroundRun(lambda report: work(progress=report), self._beside, self._wall)

    def is_stale(self, trainer: Trainer | None) -> bool:
        """Return whether the lesson changed since the runs began."""
        return self._lesson.has_changed(trainer)

    def cancel(self) -> None:
        """Cancel the runs."""
        if self._running is not None:
            self._running.cancel()
            self._running = None

    def advance(self, library: LibrarySource, trainer: Trainer | None) -> StatusMessage | None:
        """Take over the result of runs that have ended, and repeat quick ones if the lesson changed.

        Return the message about runs that have ended.
        """
        if self._running is not None and not self._running.is_running:
            ended, self._running = self._running, None
            self._ended_s, self._quick = self._wall(), not ended.problem and ended.seconds < QUICK_S
            if ended.problem:
                return StatusMessage(ended.problem, "error")
            before, self.result = self.result, ended.result
            return self._describe_change(before)
        due = self._quick and self._running is None and self._wall() - self._ended_s >= REST_S
        if due and self.is_stale(trainer):
            self.begin_rerun(library, trainer)
        return None

    def _describe_change(self, before: RerunResults | None) -> StatusMessage | None:
        """Describe how many worlds fail; None if as many failed and passed before."""
        counts = [
            None if each is None else [sum(one.has_passed for one in each.worlds), len(each.worlds)]
            for each in (before, self.result)
        ]
        if counts[0] == counts[1] or counts[1] is None:
            return None
        passed, total = counts[1]
        return StatusMessage(f"{passed} of {total} failing world{'s' * (total != 1)} passed")

    def data(self, scenario: Scenario, trainer: Trainer | None) -> FailuresData | None:
        """Return the list as the page shows it; None without a folder."""
        if self.folder is None:
            return None
        result, opened = self.result, self.find_open(scenario)
        results = {} if result is None else {each.folder.name: each for each in result.worlds}
        rows = []
        for each in self.worlds:
            rerun = results.get(each.folder.name, each)
            rows.append(
                FailingWorldData(
                    name=each.folder.name,
                    behavior=each.facts.behavior,
                    world=each.trial.scenario.name,
                    summary=each.summary,
                    sentences=list(each.facts.why),
                    state=rerun.verdict,
                    problem=rerun.problem,
                )
            )
        problems = list(self._problems)
        if result is not None and result.problem:
            problems.append(result.problem)
        return FailuresData(
            folder=str(self.folder),
            worlds=rows,
            problems=problems,
            running=self._running is not None,
            finished=0 if self._running is None else self._running.finished,
            stale=result is not None and self.is_stale(trainer),
            open=opened,
            previous_world=self.before[0].name if self.before is not None and opened is not None else None,
        )
