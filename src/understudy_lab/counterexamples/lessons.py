"""Lessons in failing worlds, and as many presses at random places, by the same novice for the same robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import hypot
from types import MappingProxyType

import numpy as np

from understudy.addons.checks.falsification.falsify import FIRST_SEED
from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.addons.checks.falsification.open_failure import find_moment
from understudy.addons.checks.falsification.random_search import measure_seeds, search_at_random
from understudy.addons.checks.falsification.trial import LEAST_BADNESS, WORLDS_AT_ONCE, TrialResults
from understudy.judging.behavior_run import ProgramRun
from understudy.model.library import Library
from understudy.runtime.program import link
from understudy.sim.forage import make_practice_worlds
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World
from understudy.training.session import Session
from understudy_lab.coaching_benefit.tasks import LIMIT_S, REACHED_M
from understudy_lab.novices.novice import Novice
from understudy_lab.novices.teach_live import draw_seed

BEHAVIOR = "goto"
TARGETS: Mapping[str, str] = MappingProxyType({"A": "station"})
SCENARIO: Scenario = make_practice_worlds()["an arena"].scenario()
"""The world in which GoTo is taught and tested in the experiment `coached`."""
RANGE = ("range", "station")
TICKS_AT_ONCE = 5
NEARER_M = 0.01
"""The least decrease of the distance that counts as progress, m."""


@dataclass(frozen=True, slots=True)
class ArrivalMeasure:
    """A measure of GoTo for searches: a run fails unless the robot is done in time and near the station.

    The robustness of a run that succeeds is the share of the limit that was left; otherwise it is minus the distance
    at which the robot said that it is done, or to which it came, as a share of the world's diagonal. A run went wrong
    when the robot said so, or where it came no nearer.
    """

    library: Library

    def __call__(self, trials: Sequence[Trial]) -> TrialResults:
        """Run GoTo in the given worlds of `SCENARIO`."""
        seeds = [trial.seed for trial in trials]
        parts = [
            self._run_together(seeds[first : first + WORLDS_AT_ONCE])
            for first in range(0, len(seeds), WORLDS_AT_ONCE)
        ]
        return TrialResults.concatenate(parts)

    def count_failures(self, seeds: Sequence[int]) -> int:
        """Return in how many worlds of these seeds the robot fails."""
        return int(self([Trial(SCENARIO, seed) for seed in seeds]).failed.sum())

    def _run_together(self, seeds: Sequence[int]) -> TrialResults:
        world = World(SCENARIO, seeds)
        program = link(self.library, BEHAVIOR, TARGETS)
        run = ProgramRun(world, program, self.library, TARGETS)
        least_m, progress_s = np.full(len(seeds), np.inf), np.zeros(len(seeds))
        distance_m = world.sense([RANGE])[RANGE]
        ticks = round(LIMIT_S / world.tick_s)
        for tick in range(0, ticks, TICKS_AT_ONCE):
            run.advance(min(TICKS_AT_ONCE, ticks - tick))
            distance_m = world.sense([RANGE])[RANGE]
            nearer = distance_m < least_m - NEARER_M
            least_m[nearer], progress_s[nearer] = distance_m[nearer], world.time_s
            if run.find_raised("done").all():
                break
        done_s = run.find_raised_s("done")[:, 0]  # a robot that is done stays where it is
        arrived = ~np.isnan(done_s) & (distance_m < REACHED_M)
        missed_m = np.where(np.isnan(done_s), least_m, distance_m)
        share = np.maximum(missed_m / hypot(*SCENARIO.size), LEAST_BADNESS)
        states = np.empty(len(seeds), np.object_)
        states[:] = [frozenset[str]()] * len(seeds)
        return TrialResults(
            robustness=np.where(arrived, (LIMIT_S - np.nan_to_num(done_s)) / LIMIT_S, -share),
            failed_s=np.where(arrived, np.nan, LIMIT_S),
            progress_s=np.where(np.isnan(done_s), progress_s, done_s),
            last_states=states,
        )


LESSONS = 5
SEARCHED = 1_000
"""The number of fresh worlds in which each lesson looks for a failing one."""
BEFORE_S = 3.0
"""The time before a robot went wrong at which a novice takes over, s."""
REPEATS = 3
"""The number of times that one failing world is opened, as long as the robot still fails in it."""
MOST_PRESSES = 8
"""The largest number of presses in one lesson."""
RANDOM_S = 30.0
"""The latest moment at which a lesson at a random place begins, s."""
MOST_PLACES = 20
"""The largest number of random places in one lesson."""


@dataclass(frozen=True, slots=True)
class LessonSeries:
    """The library after five lessons, the presses of each, and the failures among the worlds searched before each."""

    library: Library
    presses: tuple[int, ...]
    found: tuple[int, ...] = ()


def teach_by_failures(novice: Novice, library: Library, seed: int) -> LessonSeries:
    """Teach five lessons, each in the worst failing world that a search at random finds.

    The world is opened again while the robot still fails in it. A lesson before which no world fails has no presses.
    """
    presses, found = [], []
    for number in range(LESSONS):
        first = FIRST_SEED + SEARCHED * (LESSONS * seed + number)
        search = search_at_random(
            partial(measure_seeds, ArrivalMeasure(library), SCENARIO), first_seed=first, most_runs=SEARCHED
        )
        found.append(search.failed)
        before = novice.presses
        if search.failures:
            library = _correct_world(novice, library, search.failures[0][1])
        presses.append(novice.presses - before)
    return LessonSeries(library, tuple(presses), tuple(found))


def _correct_world(novice: Novice, library: Library, world: int) -> Library:
    """Let a novice correct the robot in a failing world, again while it fails there."""
    left = MOST_PRESSES
    for _ in range(REPEATS):
        outcome = ArrivalMeasure(library)([Trial(SCENARIO, world)])
        if not outcome.failed[0] or left <= 0:
            break
        session = _open_moment(library, world, float(outcome.progress_s[0]), before_s=BEFORE_S)
        left -= _watch_robot(novice, session, left)
        library = library.with_automaton(session.make_trained_automaton())
    return library


def teach_at_random(novice: Novice, library: Library, presses: Sequence[int]) -> LessonSeries:
    """Teach lessons with these numbers of presses at random moments of runs in fresh worlds.

    At each moment the novice first presses what is right there, or confirms that the robot is right, and then corrects
    it like in a failing world. Where no more is to be pressed, the lesson goes on at another random moment.
    """
    return _teach_at_places(novice, library, presses, first=_press_what_is_right)


def teach_by_watching(novice: Novice, library: Library, presses: Sequence[int]) -> LessonSeries:
    """Teach lessons with at most these numbers of presses at random moments, like `teach_at_random`.

    The novice presses only where the robot is wrong, so a lesson may end with fewer presses.
    """
    return _teach_at_places(novice, library, presses, first=lambda novice, session: None)


def _teach_at_places(
    novice: Novice, library: Library, presses: Sequence[int], *, first: Callable[[Novice, Session], None]
) -> LessonSeries:
    """Teach lessons at random moments; `first` is called at the beginning of each."""
    made = []
    for wanted in presses:
        before, places = novice.presses, 0
        while novice.presses - before < wanted and places < MOST_PLACES:
            world = draw_seed(novice)
            end_s = float(ArrivalMeasure(library)([Trial(SCENARIO, world)]).progress_s[0])
            moment_s = float(novice.draws.uniform(0.0, min(end_s, RANDOM_S)))
            session = _open_moment(library, world, moment_s, before_s=0.0)
            first(novice, session)
            _watch_robot(novice, session, wanted - (novice.presses - before))
            library = library.with_automaton(session.make_trained_automaton())
            places += 1
        made.append(novice.presses - before)
    return LessonSeries(library, tuple(made))


def _open_moment(library: Library, world: int, wrong_s: float, *, before_s: float) -> Session:
    """Open a live session in a world, some seconds before a moment of the robot's run."""
    trial = Trial(SCENARIO, world)
    moment = find_moment(
        trial, library, BEHAVIOR, binding=TARGETS, wrong_s=wrong_s, before_s=before_s, name=BEHAVIOR
    )
    return moment.open_session()


def _press_what_is_right(novice: Novice, session: Session) -> None:
    """Press the state that the robot should be in now, or confirm the present one."""
    novice.look_afresh()
    screen = session.view()
    wished = novice.wish(screen)
    novice.say(session, None if wished == screen.state else wished)
    novice.cancel_press()
    novice.seconds += session.body.tick_s


def _watch_robot(novice: Novice, session: Session, most_presses: int) -> int:
    """Watch the robot until it has arrived or the novice has no more patience or presses; return the presses."""
    novice.look_afresh()
    novice.cancel_press()
    before, until = novice.presses, novice.seconds + novice.traits.patience_s
    while (
        novice.presses - before < most_presses and novice.seconds < until and not novice.there(session.view())
    ):
        novice.notice(session, 0.0)
        session.tick()
        novice.seconds += session.body.tick_s
    return novice.presses - before
