"""The experiment: novices correct their robots in failing worlds, or with as many presses at random places.

The same novice does both, for the same robot.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import hypot
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from understudy.addons.checks.falsification.falsify import FIRST_SEED
from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.addons.checks.falsification.open_failure import find_moment
from understudy.addons.checks.falsification.random_search import measure_seeds, search_at_random
from understudy.addons.checks.falsification.trial import LEAST_BADNESS, WORLDS_AT_ONCE, TrialResults
from understudy.judging.behavior_run import ProgramRun
from understudy.judging.intervals import exact_interval_of_share
from understudy.model.library import Library
from understudy.runtime.link import link
from understudy.sim.forage import make_practice_worlds
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World
from understudy.training.session import Session
from understudy_lab.coaching_benefit.tasks import ALONE, EXERCISES, LIMIT_S, REACHED_M, teach
from understudy_lab.declaration import Units
from understudy_lab.figures import COLORS, Panels
from understudy_lab.novices.novice import Novice, draw_traits
from understudy_lab.novices.teach_live import draw_seed
from understudy_lab.statistics import compute_paired_p, format_median
from understudy_lab.study import ResultTable, Row, Study, StudyFindings, StudyGoal, Task

if TYPE_CHECKING:
    from matplotlib.axes import Axes


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


SEEDS = range(71_100, 71_130)
"""The seeds of the novices; the lessons were developed on seeds 70900 to 70959."""
UNSEEN = 2_000
"""The number of unseen worlds in which each robot is tested."""
WANTED = 10.0
BEFORE, FAILURES, RANDOM, WATCHED = "before", "counterexamples", "random", "watched"
NAMES = {
    BEFORE: "before",
    FAILURES: "after counterexamples",
    RANDOM: "after random places",
    WATCHED: "after random places, corrections only",
}
TITLES = {FAILURES: "Counterexamples", RANDOM: "Random places", WATCHED: "Random, corrections only"}
LESSONS_IN = (FAILURES, RANDOM, WATCHED)


def work(task: Task) -> Row:
    """Let a novice teach GoTo alone, then five lessons of each kind, and count failures in the same unseen worlds."""
    seed, exercise = task["seed"], EXERCISES["goto"]
    traits = draw_traits(seed)
    taught = teach(exercise.person(traits, seed), exercise, ALONE).session.make_trained_automaton()
    library = Library(exercise.kit).with_automaton(taught)
    by_failures = teach_by_failures(exercise.person(traits, seed), library, seed)
    at_random = teach_at_random(exercise.person(traits, seed), library, by_failures.presses)
    watched = teach_by_watching(exercise.person(traits, seed), library, by_failures.presses)
    unseen = range(UNSEEN * seed, UNSEEN * (seed + 1))
    lessons = {FAILURES: by_failures, RANDOM: at_random, WATCHED: watched}
    libraries = {BEFORE: library, **{name: each.library for name, each in lessons.items()}}
    return {
        "failures": {name: ArrivalMeasure(each).count_failures(unseen) for name, each in libraries.items()},
        "found": by_failures.found,
        "presses": {name: each.presses for name, each in lessons.items()},
    }


def compute_fall(row: Row, name: str) -> float:
    """Return by which factor failures fell; half a failure is added to both counts, so that it is finite."""
    failures = row["failures"]
    return float((failures[BEFORE] + 0.5) / (failures[name] + 0.5))


def select_failing(rows: Sequence[Row]) -> list[Row]:
    """Return the novices with something to correct: the first search found a world in which their robot fails."""
    return [row for row in rows if row["found"][0] > 0]


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Summarize by which factor failures fell, and list all robots."""
    failing = select_failing(rows)
    falls = {name: [compute_fall(row, name) for row in failing] for name in LESSONS_IN}
    medians = {name: float(np.median(each)) for name, each in falls.items()}
    counts = {name: [row["failures"][name] for row in failing] for name in NAMES}
    presses = {name: [sum(row["presses"][name]) for row in failing] for name in LESSONS_IN}
    tenfold = {name: sum(each >= WANTED for each in found) for name, found in falls.items()}
    ps = {name: compute_paired_p(counts[FAILURES], counts[name]) for name in (RANDOM, WATCHED)}
    return StudyFindings(
        headline=f"Of {len(rows)} robots that novices taught GoTo, {len(failing)} fail in one of {SEARCHED} searched "
        f"worlds. {LESSONS} lessons in failing worlds, with {np.median(presses[FAILURES]):.0f} presses in the median, "
        f"divide their failures in unseen worlds by {medians[FAILURES]:.0f} in the median. As many presses at random "
        f"places divide them by {medians[RANDOM]:.1f}, and at most as many, all of them corrections of what looks "
        f"wrong there, by {medians[WATCHED]:.1f}.",
        tables=(
            ResultTable(
                f"The {len(failing)} robots that fail, by lessons: medians (smallest–largest)",
                (
                    "",
                    "#failures, % of unseen worlds",
                    "#failures divided by",
                    "#robots tenfold better",
                    "#robots without a failure",
                    "#robots worse",
                    "#presses",
                ),
                [_summarize(failing, name) for name in NAMES],
            ),
            ResultTable(
                f"Failures in {UNSEEN} unseen worlds by robot (exact 95 % interval of the share, %)",
                ("novice", *(f"#{name}" for name in NAMES.values()), "#presses in each lesson"),
                [_list_failures(row) for row in rows],
            ),
        ),
        goals=(
            StudyGoal(
                "failures before / after counterexamples, median",
                f"{WANTED:.0f}",
                f"{medians[FAILURES]:.1f} (after random places {medians[RANDOM]:.1f})",
                medians[FAILURES] >= WANTED,
            ),
        ),
        notes=(
            "Half a failure is added to both numbers before one is divided by the other. "
            f"{tenfold[FAILURES]} of {len(failing)} robots are at least ten times better after counterexamples, "
            f"{tenfold[RANDOM]} after random places, and {tenfold[WATCHED]} after random places with corrections only. "
            f"Failures after counterexamples differ from those after random places with p = {ps[RANDOM]:.2g}, and from "
            f"those with corrections only with p = {ps[WATCHED]:.2g} (signed-rank test).",
            "A lesson has no presses if no searched world fails, or if the novice sees nothing wrong in the one that "
            "does.",
        ),
        numbers={
            "falls": {name: round(each, 4) for name, each in medians.items()},
            "tenfold": tenfold,
            "presses": {name: float(np.median(each)) for name, each in presses.items()},
            "p": {name: round(p, 6) for name, p in ps.items()},
        },
    )


def _summarize(rows: Sequence[Row], name: str) -> tuple[str, ...]:
    counts = [row["failures"][name] for row in rows]
    falls = [compute_fall(row, name) for row in rows]
    is_before = name == BEFORE
    return (
        NAMES[name],
        format_median([100 * each / UNSEEN for each in counts], 2),
        "" if is_before else format_median(falls, 1),
        "" if is_before else str(sum(each >= WANTED for each in falls)),
        str(counts.count(0)),
        "" if is_before else str(sum(each < 1.0 for each in falls)),
        "" if is_before else format_median([sum(row["presses"][name]) for row in rows]),
    )


def _list_failures(row: Row) -> tuple[str, ...]:
    return (
        str(row["task"]["seed"]),
        *(_format_count(row["failures"][name]) for name in NAMES),
        " ".join(map(str, row["presses"][FAILURES])),
    )


def _format_count(failed: int) -> str:
    low, high = exact_interval_of_share(failed, UNSEEN)
    return f"{failed} ({100 * low:.2f}–{100 * high:.2f})"


def _draw(panel: Axes, rows: Sequence[Row], name: str) -> None:
    """Draw the failures of each robot before and after the lessons of one kind."""
    counts = np.array([[row["failures"][each] for each in (BEFORE, name)] for row in rows], np.float64)
    panel.plot(
        [0, 1],
        counts.T,
        "-o",
        color=COLORS[LESSONS_IN.index(name)],
        linewidth=0.8,
        markersize=3.5,
        alpha=0.55,
    )
    panel.plot([0, 1], np.median(counts, axis=0), "-", color="#1f2937", linewidth=2.5, label="median")
    panel.set_yscale("symlog", linthresh=1.0)
    panel.set_ylim(-0.15, UNSEEN * 1.2)
    panel.set_yticks([0, 1, 10, 100, 1000], ["0", "1", "10", "100", "1000"])
    panel.set_xticks([0, 1], ["before", f"after {LESSONS} lessons"])
    panel.set_xlim(-0.25, 1.25)
    fall = float(np.median([compute_fall(row, name) for row in rows]))
    panel.set_title(f"{TITLES[name]}:\ndivided by {fall:.{0 if fall >= WANTED else 1}f} (median)")
    if name == FAILURES:
        panel.set_ylabel(f"failures in {UNSEEN} unseen worlds")
        panel.legend(loc="lower left")


EXPERIMENT = Study(
    name="counterexamples",
    seeds=SEEDS,
    quick=2,
    tasks=Units({}),
    work=work,
    conclude=conclude,
    draw=Panels(
        [partial(_draw, name=name) for name in LESSONS_IN], wide=3.2, tall=3.4, prepare=select_failing
    ),
)
