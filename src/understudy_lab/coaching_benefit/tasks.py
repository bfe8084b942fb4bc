"""The tasks of the novices: approaching a ball (paper section 4.2), and GoTo (paper section 4.1); and their teaching.

A novice alone puts the robot into one situation after another and drives it. A coached novice does so once. Then two
actions alternate: let the robot try from the next situation and answer its questions, or read the first advice, let the
coach set up its situation, and demonstrate there. The learned automaton is kept after each step.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import atan2, cos, isnan, pi, radians, sin, tau
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.advice import Advice, AdviceKind
from understudy.coaching.give_advice import give_advice
from understudy.coaching.pose_sampling import sample_posed_situations
from understudy.coaching.questions import QueryPolicy, UncertaintyQueries
from understudy.coaching.reasons_to_ask import DoubtReason
from understudy.coaching.situation_setup import set_up_situation
from understudy.errors import SettingError
from understudy.learning.fit import learn
from understudy.learning.mislabels import find_mislabels
from understudy.model.learner_options import LearnerOptions
from understudy.model.lesson import Lesson
from understudy.model.library import Kit, Library, TrainedAutomaton
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import link
from understudy.sim.forage import FORAGE_KIT as forage_kit
from understudy.sim.forage import Forage, make_practice_worlds
from understudy.sim.target_lookup import find_target_place
from understudy.sim.world import World
from understudy.training.session import Session
from understudy.training.trainee import SessionView
from understudy_lab.novices.novice import UNDERSTOOD, Novice
from understudy_lab.novices.study import judge as judge_servoing
from understudy_lab.novices.teach_live import BY_THE_BALL, Placement, draw_seed, teach_live
from understudy_lab.tasks import soccer
from understudy_lab.tasks.forage_teacher import GOTO
from understudy_lab.tasks.servo_teacher import four_states
from understudy_lab.tasks.soccer import Soccer
from understudy_lab.teachers.live_teacher import LIVE
from understudy_lab.teachers.person import rebuild_screen
from understudy_lab.teachers.teacher import FIRST_SEED

THERE_M = 0.3
"""The distance in m that counts as arrived for a novice without misjudgment."""
PLAINLY = 1.5
"""The multiple of that distance at which the robot has clearly not arrived."""
ASTRAY, FACING = 0.6, 0.12
"""The bearings in rad from which the robot has to turn, and at which it has turned enough."""
OFF_RAD = 0.15
"""The largest error of a novice in judging straight ahead, rad."""


class GotoNovice(Novice):
    """A novice who teaches GoTo(A); a misunderstanding concerns the direction of a turn."""

    buttons = ("forward", "rotate_left", "rotate_right", "done")

    def there(self, screen: SessionView) -> bool:
        """Return whether the robot has raised `done` and also looks arrived to this novice."""
        return screen.flag is not None and self.wish(screen) is None

    def wish(self, screen: SessionView) -> str | None:
        """Return the state that the robot should be in, or None where this novice accepts the current one."""
        distance, state = screen.features["distance_to(A)"], screen.state
        if isnan(distance):
            return None
        there_m = THERE_M * (1.0 + self.traits.misjudged)
        if distance < (PLAINLY * there_m if screen.flag is not None else there_m):
            return None if screen.flag is not None else "done"
        off = (screen.features["angle_to(A)"] + OFF_RAD * self.traits.off_middle_px / 20.0 + pi) % tau - pi
        if state in ("start", "forward", "done"):
            return self._turn(off) if abs(off) > ASTRAY else None if state == "forward" else "forward"
        ahead = off if state == "rotate_left" else -off
        return "forward" if -ASTRAY < ahead < FACING else None

    def _turn(self, off: float) -> str:
        """Return the turn that this novice chooses for a target `off` rad to the left."""
        side = "rotate_left" if off > 0 else "rotate_right"
        if self.traits.mistake == UNDERSTOOD:
            return side
        if self.traits.mistake == "one only":
            return "rotate_left"
        return "rotate_left" if self._either == "forwardL" else "rotate_right"


PLACES = 30
"""The number of test worlds for GoTo, equal to the trials of the approach to a ball."""
REACTION_S = 0.3
"""The reaction time in s set in the lesson of GoTo: that of the fastest novices."""
LIMIT_S, REACHED_M = 60.0, 0.6
"""The time limit in s, and the distance in m from the station within which `done` counts."""


@dataclass(frozen=True)
class CoachingTask:
    """A task: its world and empty lesson, the class of its novices, how they place the robot, and how it is tested.

    `judge` returns the share of successful trials, and whether each kind of trial succeeds at least half of the time.
    """

    kit: Kit
    person: type[Novice]
    body: Callable[[int], World | Soccer]
    lesson: Callable[[], Lesson]
    placement: Placement
    judge: Callable[[TrainedAutomaton, int], tuple[float, bool]]
    targets: Mapping[str, str] = field(default_factory=dict)


def _servoed(taught: TrainedAutomaton, seed: int) -> tuple[float, bool]:
    reached = [[each == each for each in times] for times in judge_servoing(taught, seed).values()]
    return float(np.mean(reached)), all(2 * sum(of) >= len(of) for of in reached)


ASIDE_DEG: Mapping[str, tuple[float, float]] = MappingProxyType(
    {"ball left": (20.0, 130.0), "ball right": (-130.0, -20.0), "ball lost": (120.0, 240.0)}
)
"""The range of the station's bearing in degrees where the robot is put down, by situation."""
FARTHEST_M, TRIES = 4.0, 50


def _put_down_by_the_station(novice: Novice, session: Session, situation: str) -> None:
    session.reset(draw_seed(novice))
    body = session.body
    station = find_target_place(body, "station", session.agent) if isinstance(body, World) else None
    if not isinstance(body, World) or station is None:
        return
    for _ in range(TRIES):
        far, side = novice.draws.uniform(0.2 * FARTHEST_M, FARTHEST_M), novice.draws.uniform(0.0, tau)
        bearing = radians(novice.draws.uniform(*ASIDE_DEG[situation]))
        x, y = station[0] + far * cos(side), station[1] + far * sin(side)
        try:
            body.place(session.agent, x, y, atan2(station[1] - y, station[0] - x) - bearing)
        except SettingError:  # no free place: they try another
            continue
        break
    session.note_moved()


def _went(taught: TrainedAutomaton, seed: int) -> tuple[float, bool]:
    body = Forage(range(PLACES * seed, PLACES * (seed + 1)), make_practice_worlds()["an arena"])
    engine = Engine.from_program(
        body, link(Library(forage_kit).with_automaton(taught), "goto", {"A": "station"})
    )
    engine.run(round(LIMIT_S / body.tick_s))
    distance = body.sense([("range", "station")])["range", "station"]
    there = [engine.path(agent)[0] == "done" and distance[agent] < REACHED_M for agent in range(PLACES)]
    return float(np.mean(there)), 2 * sum(there) >= PLACES


EXERCISES: Mapping[str, CoachingTask] = MappingProxyType(
    {
        "servoing": CoachingTask(
            soccer.kit,
            Novice,
            lambda seed: Soccer([seed]),
            lambda: four_states(Library(soccer.kit)),
            BY_THE_BALL,
            _servoed,
        ),
        "goto": CoachingTask(
            forage_kit,
            GotoNovice,
            lambda seed: Forage([seed], make_practice_worlds()["an arena"]),
            lambda: replace(GOTO.choose(Library(forage_kit)), options=LearnerOptions(reaction_s=REACTION_S)),
            Placement(_put_down_by_the_station),
            _went,
            {"A": "station"},
        ),
    }
)


ALONE, COACHED = "alone", "coached"
ASKED, CORRECTED = "asked", "corrected"
GOES_ON_S = 4.0
"""The time in s for which a novice goes on driving the robot after an answer."""
TWICE = 2
"""The largest number of times that a novice follows the same advice."""
ANSWER_S = 1.0
"""The time in s that an answer to a question takes; the world is paused."""
STEPS_IN_S = 1.0
"""The time in s for which a novice tolerates a wrong action before correcting it."""
LOOK_S = 2.0
"""The time in s spent on an example that may be a slip."""
MOST_QUESTIONS = 8
"""The largest number of questions in one try."""
STEPS = (6, 10, 15, 20, 25, 30, 40, 50, 60, 80, 100, 120, 150)
"""The numbers of examples after which the automaton is stored."""


@dataclass
class CoachedTeaching:
    """The result of one novice's teaching: the automaton after each of STEPS examples, and the session."""

    session: Session
    by_step: dict[int, TrainedAutomaton] = field(default_factory=dict)
    followed: Counter[str] = field(default_factory=Counter)
    """The number of times advice was followed, by kind and by sentence."""
    pressed: set[int] = field(default_factory=set)
    meant: dict[int, float] = field(default_factory=dict)
    """The doubt about each suspected slip that was judged, by example number."""

    @property
    def made(self) -> int:
        """The number of press-made examples so far, including deleted ones."""
        return len(self.pressed)

    @property
    def followed_kinds(self) -> dict[str, int]:
        """The number of times advice of each kind was followed, a question answered, or the robot corrected."""
        kinds = {*(kind.value for kind in AdviceKind), ASKED, CORRECTED}
        return {str(each): count for each, count in self.followed.items() if each in kinds}

    def look(self) -> None:
        """Store the present automaton for each step that is not exceeded yet."""
        self.pressed |= {example.number for example in self.session.examples if example.is_from_press}
        for step in STEPS:
            if self.made <= step:
                self.by_step[step] = self.session.make_trained_automaton()


def teach(novice: Novice, exercise: CoachingTask, way: str) -> CoachedTeaching:
    """Let a novice teach for the given time, alone, coached or live, and return the result."""
    session = Session(
        exercise.body(draw_seed(novice)),
        Library(exercise.kit),
        exercise.lesson(),
        targets=exercise.targets,
    )
    course, limit_s = CoachedTeaching(session), novice.habits.given_s
    if way == LIVE:
        teach_live(novice, session, exercise.placement, note=course.look)
        return course
    situations = _situations(exercise, session)
    put, turn = int(novice.draws.integers(len(novice.traits.situations))), 0
    while novice.seconds < limit_s:
        novice.seconds = min(limit_s, novice.seconds + novice.traits.carry_s)
        novice.look_afresh()
        coached, tries = way == COACHED and course.made > 0, turn % 2 > 0
        if coached:
            _mend(novice, course)
        first = _first(course, exercise, situations) if coached and not tries else None
        if first is None or first.kind is AdviceKind.NEVER_ENTERED:
            exercise.placement.put_down(
                novice, session, novice.traits.situations[put % len(novice.traits.situations)]
            )
            put += 1
            left_s = min(novice.traits.patience_s, limit_s - novice.seconds)
            if coached and tries:
                _try_out(novice, course, left_s)
            else:
                novice.show(session, novice.wish, until=novice.there, limit_s=left_s)
        else:
            course.followed[first.kind.value] += 1
            set_up_situation(session, first, draw=int(novice.draws.integers(2**30)))
            _answer(novice, course, first, limit_s - novice.seconds)
        course.look()
        turn += 1
    return course


def _try_out(novice: Novice, course: CoachedTeaching, left_s: float) -> None:
    """Let the robot try for `left_s` seconds; answer its questions while the world is paused, and correct errors."""
    session, until = course.session, novice.seconds + left_s
    session.test()
    asking, questions, repeats = UncertaintyQueries(session, QueryPolicy.PAUSE), 0, ""
    while novice.seconds < until:
        question, screen = asking.find_question(), session.view()
        repeats = repeats if screen.state == repeats else ""
        if question is not None and question.doubt.because is DoubtReason.REPEATING:
            repeats = question.state
            if novice.wish(screen) in (None, screen.state):  # they watch a round, and press later
                novice.seconds += ANSWER_S
                continue
        if question is not None and questions < MOST_QUESTIONS:
            questions += 1
            course.followed[ASKED] += 1
            wished = novice.wish(screen) or screen.state
            novice.say(session, None if wished == screen.state else wished)
            novice.seconds += session.body.tick_s + ANSWER_S
            course.look()
            session.test()
        elif novice.there(screen):
            break
        elif novice.notice(session, 0.0 if repeats else STEPS_IN_S):
            course.followed[CORRECTED] += 1
            novice.show(
                session, novice.wish, until=novice.there, limit_s=min(GOES_ON_S, until - novice.seconds)
            )
            course.look()
            session.test()
        else:
            session.tick()
            novice.seconds += session.body.tick_s
    session.train()


def _situations(exercise: CoachingTask, session: Session) -> NDArray[np.float64]:
    """Return feature vectors that the robot may meet, sampled from a world like the one of the lesson."""
    body = exercise.body(FIRST_SEED)
    return sample_posed_situations(body, session.automaton.features, exercise.targets)


def _mend(novice: Novice, course: CoachedTeaching) -> None:
    """Judge each suspected slip, the most doubtful first, and correct those that were not intended."""
    session = course.session
    while novice.seconds < novice.habits.given_s and (
        odd := find_mislabels(session.lesson, meant=course.meant)
    ):
        example = odd[0].example
        wished = novice.wish(rebuild_screen(example, session.automaton)) or example.state
        course.meant[example.number] = odd[0].doubt
        course.followed[AdviceKind.SLIP.value] += 1
        novice.seconds += LOOK_S
        if wished != example.next:
            session.correct_slip(example.number, wished)


def _first(course: CoachedTeaching, exercise: CoachingTask, situations: NDArray[np.float64]) -> Advice | None:
    """Return the first advice on a situation to show that was not followed twice already, or None."""
    lesson = course.session.lesson
    for each in give_advice(
        lesson, learn(lesson), kit=exercise.kit, situations=situations, meant=course.meant
    ):
        if each.kind is AdviceKind.SLIP:
            continue
        place = each.region is not None or each.kind in (AdviceKind.NEVER_LEFT, AdviceKind.NEVER_ENTERED)
        if place and course.followed[each.sentence] < TWICE:
            course.followed[each.sentence] += 1
            return each
    return None


def _answer(novice: Novice, course: CoachedTeaching, advised: Advice, left_s: float) -> None:
    """Demonstrate in the advised situation: direct the robot or confirm, and delete examples that contradict it."""
    session = course.session
    screen = session.view()
    wished = novice.wish(screen) or screen.state
    if advised.kind in (AdviceKind.CONTRADICTION, AdviceKind.DISAGREEMENT, AdviceKind.SINGLE):
        wrong = [
            example.number
            for example in session.examples
            if example.number in advised.examples and example.next != wished
        ]
        if wrong:
            session.delete(*wrong)
        if len(wrong) < len(advised.examples) and advised.kind is not AdviceKind.SINGLE:
            return  # what remains says it
    novice.say(session, None if wished == screen.state else wished)
    novice.seconds += session.body.tick_s
    novice.show(session, novice.wish, until=novice.there, limit_s=min(GOES_ON_S, left_s))
