"""The experiment: teachers who press wrong buttons and press late, corrected with and without unlearning."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from math import inf
from types import MappingProxyType
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from understudy.learning.mislabels import find_mislabels
from understudy.model.learner_options import LearnerOptions
from understudy.model.library import Library, TrainedAutomaton
from understudy.training.feature_values import list_steady_readings
from understudy.training.reaction_time import estimate_reaction_time
from understudy.training.session import Session
from understudy_lab.coaching_benefit.tasks import EXERCISES
from understudy_lab.declaration import Conclusion, Goal, LinePerGroup
from understudy_lab.figures import COLORS, Panels
from understudy_lab.forage.teach import make_practice
from understudy_lab.novices.novice import ALIKE, RANGES
from understudy_lab.rows import Median, Rows
from understudy_lab.servoing.trials import search_side
from understudy_lab.study import Row, Study, StudyPlan, Task
from understudy_lab.tasks.forage_teacher import GOTO
from understudy_lab.tasks.servo_teacher import topics
from understudy_lab.tasks.soccer import Soccer
from understudy_lab.teachers.person import ReactionTime, SlippingPerson
from understudy_lab.teachers.teacher import LessonPlan, MakesBody, Patience, ScriptedTeacher, TeachingCost

if TYPE_CHECKING:
    from matplotlib.axes import Axes


CLEAN, PLAIN, BY_ITSELF, ASKED, UNHURRIED = (
    "no faults",
    "corrected",
    "unlearns by itself",
    "asked",
    "asked, answers without slips",
)
WAYS = (PLAIN, BY_ITSELF, ASKED, UNHURRIED)
MOST = 24
"""The number of corrections after which a teacher gives up."""
IN_A_ROW = 8
"""The number of tries in a row without a correction after which a teacher is content."""


TASKS: Mapping[str, tuple[Callable[[int], LessonPlan], MakesBody]] = MappingProxyType(
    {
        "goto": (lambda seed: GOTO, make_practice),
        "servoing": (
            lambda seed: topics(search_side(seed))["four states"],
            lambda practice, world: Soccer([world]),
        ),
    }
)
"""The lesson plan of each task for a seed, and what makes its practice worlds."""


@dataclass
class NoisyTeaching:
    """The result of one teaching: the automaton after each number of corrections, and counts."""

    taught: list[TrainedAutomaton] = field(default_factory=list)
    corrections: int = 0
    asked: int = 0
    slipped: int = 0
    held: int = 0


def teach(name: str, way: str, seed: int, chance: float) -> NoisyTeaching:
    """Teach until enough tries in a row need no correction, or the teacher gives up."""
    (make_topic, make), course = TASKS[name], NoisyTeaching()
    topic = replace(make_topic(seed), tries=IN_A_ROW)
    draws = np.random.default_rng([seed, 5])
    people: list[SlippingPerson] = []

    def person(others: np.random.Generator, reaction: ReactionTime) -> SlippingPerson:
        slips = 0.0 if way == CLEAN else chance
        people.append(SlippingPerson(others, reaction, slips, 0.0 if way == UNHURRIED else slips))
        return people[0]

    def looks_back(session: Session) -> None:
        if way in (ASKED, UNHURRIED):
            _ask(session, people[0], topic)
        if way in (ASKED, UNHURRIED, BY_ITSELF):
            _press_earlier(session)
        course.taught[course.corrections :] = [session.make_trained_automaton()]

    def progress(automaton: str, what: str, account: TeachingCost) -> None:
        course.corrections += what in ("corrected", "lost")

    ScriptedTeacher(
        Library(EXERCISES[name].kit),
        make,
        seed,
        options={topic.name: LearnerOptions(unlearning=way == BY_ITSELF)},
        reaction=ReactionTime(ALIKE.least_s, 0.0, ALIKE.least_s) if way == CLEAN else _late(draws),
        progress=progress,
        patience=Patience(corrections=MOST, lessons=1),
        person=person,
        looks_back=looks_back,
    ).teach(topic)
    course.asked, course.slipped = people[0].asked, people[0].slipped
    lesson = course.taught[-1].lesson
    course.held = sum(bool(example.quarantined) for example in lesson.examples) if lesson else 0
    return course


def _late(draws: np.random.Generator) -> ReactionTime:
    """Draw a reaction time as slow as a novice's."""
    least, most, _ = RANGES["reaction_s"]
    mean_s = float(draws.uniform(least, most))
    return ReactionTime(mean_s, ALIKE.spread * mean_s, ALIKE.least_s)


def _ask(session: Session, person: SlippingPerson, topic: LessonPlan) -> None:
    """Ask about each suspected slip, the most doubtful first, and correct the example or record that it is right."""
    while odd := find_mislabels(session.lesson, meant=person.meant, most=1):
        example = odd[0].example
        answer = person.answer(odd[0], session.automaton, topic.show)
        if answer != example.next:
            session.correct_slip(example.number, answer)


def _press_earlier(session: Session) -> None:
    """Set the lesson's reaction time to the one estimated from its own examples."""
    estimate = estimate_reaction_time(session.lesson, steady=list_steady_readings(session.body))
    options = session.lesson.options
    if estimate is not None and estimate.least_s > options.reaction_s:
        session.change_design(options=replace(options, reaction_s=estimate.reaction_s))


Kind: TypeAlias = tuple[str, str, float]
"""A task, a way of correcting, and the chance of a slip."""

SEEDS = range(63_000, 63_080)
CHANCES = (0.05, 0.1, 0.2)
SHORT = 0.05
"""The largest gap to a teacher without faults that counts as equally good."""
WANTED = 0.5
COUNTS = (0, 2, 4, 8, 16, MOST)
"""The numbers of corrections after which success is listed."""
KINDS: list[Kind] = [
    (name, way, chance)
    for name in TASKS
    for way, chance in ((CLEAN, 0.0), *((way, chance) for chance in CHANCES for way in WAYS))
]
"""The kinds of teachings; teachers without faults have no chance of a slip."""


def tasks(plan: StudyPlan) -> list[Task]:
    """Return the work to do: one teaching for each behavior, share of wrong presses, way of correcting, and seed."""
    return [
        {"task": name, "way": way, "chance": chance, "seed": seed}
        for name, way, chance in KINDS
        for seed in plan.seeds
    ]


def work(task: Task) -> Row:
    """Run one teaching and return the share of successful trials after each correction."""
    name, seed = task["task"], task["seed"]
    course = teach(name, task["way"], seed, task["chance"])
    shares = [EXERCISES[name].judge(taught, seed)[0] for taught in course.taught]
    return {
        "shares": [round(share, 4) for share in shares],
        "corrections": course.corrections,
        "slipped": course.slipped,
        "asked": course.asked,
        "held": course.held,
    }


def means(rows: Sequence[Row]) -> list[float]:
    """Return the mean share of successful trials after 0, 1, ... corrections."""
    padded = [row["shares"] + [row["shares"][-1]] * (MOST + 1 - len(row["shares"])) for row in rows]
    return [float(np.mean(shares)) for shares in zip(*(each[: MOST + 1] for each in padded), strict=True)]


def count_corrections_needed(rows: Sequence[Row], clean: Sequence[Row]) -> int | None:
    """Return the corrections after which robots are, and stay, as good as those of teachers without faults."""
    good = [mean >= means(clean)[-1] - SHORT for mean in means(rows)]
    return next((count for count in range(len(good)) if all(good[count:])), None)


Found: TypeAlias = Mapping[Kind, Rows]


def _group(rows: Rows) -> Found:
    return {(name, way, chance): rows.where(task=name, way=way, chance=chance) for name, way, chance in KINDS}


def _count(groups: Found, kind: Kind) -> int | None:
    return count_corrections_needed(groups[kind], groups[kind[0], CLEAN, 0.0])


def _group_with_clean(groups: Found) -> Found:
    return {
        kind: Rows({**row, "clean": groups[kind[0], CLEAN, 0.0]} for row in rows)
        for kind, rows in groups.items()
    }


def _format_needed(count: int | None) -> str:
    return "never" if count is None else str(count)


def _said(count: int | None) -> str:
    if count is None:
        return f"not within {MOST} corrections"
    return f"after {count} correction{'s' * (count != 1)}"


def _headline(groups: Found) -> str:
    return " ".join(
        f"Teachers of goto who press late, and press a wrong button in {chance:.0%} of presses, come within "
        f"{100 * SHORT:.0f} points of a teacher without faults {_said(_count(groups, ('goto', ASKED, chance)))} if "
        f"they are asked about odd presses, and {_said(_count(groups, ('goto', PLAIN, chance)))} if not."
        for chance in CHANCES[:2]
    )


def _goal(chance: float, way: str) -> Goal:
    def compare(groups: Found) -> float:
        """Return by how many the corrections exceed the wanted share of those without unlearning."""
        asked, plain = (_count(groups, ("goto", each, chance)) for each in (way, PLAIN))
        if asked is None:
            return inf
        return asked - WANTED * (MOST + 1 if plain is None else plain)

    return Goal(
        f"goto, {chance:.0%} slips, {way}: corrections until robots are as good as those of a teacher without faults",
        compare,
        most=0,
        wanted=f"at most {WANTED:.0%} of those without unlearning",
        measured=lambda groups: (
            f"{_said(_count(groups, ('goto', way, chance)))}; "
            f"without {_said(_count(groups, ('goto', PLAIN, chance)))}"
        ),
    )


def _notes(groups: Found) -> tuple[str, ...]:
    ends = [means(groups["servoing", way, chance])[0] for way in (PLAIN, ASKED) for chance in CHANCES]
    return (
        "Servoing needs hardly any corrections: before the first correction, robots succeed in "
        f"{100 * min(ends):.0f} to {100 * max(ends):.0f} % of trials, with any of these faults.",
        "Unlearning without questions saves few corrections here, if any: where presses of one kind are rare, it "
        "quarantines good ones, too. It is meant for demonstrators who cannot be asked.",
    )


def _draw(axes: Axes, groups: Found, chance: float) -> None:
    """Draw the success of GoTo over the number of corrections."""
    for way, color in zip((CLEAN, *WAYS), ("#6b7280", *COLORS), strict=False):
        mean = means(groups["goto", way, 0.0 if way == CLEAN else chance])
        axes.plot(range(MOST + 1), mean, "-", color=color, linewidth=1.4, label=way)
    axes.set_ylim(0.0, 1.03)
    axes.set_xlabel("corrections")
    axes.set_ylabel("trials that succeed")
    axes.set_title(f"goto, {chance:.0%} slips")
    axes.legend(fontsize=7)


EXPERIMENT = Study(
    name="slips",
    seeds=SEEDS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=Conclusion(
        prepare=_group,
        headline=_headline,
        tables=(
            LinePerGroup(
                "Share of successful trials by number of corrections; corrections until a robot is as good as without "
                f"faults; and totals until {IN_A_ROW} tries in a row needed no correction, medians (smallest–largest)",
                ["task", "slips", "way"],
                _group_with_clean,
                {
                    **{str(count): lambda rows, count=count: f"{means(rows)[count]:.0%}" for count in COUNTS},
                    "as good after": lambda rows: _format_needed(
                        count_corrections_needed(rows, rows[0]["clean"])
                    ),
                    "corrections": Median("corrections"),
                    "questions": Median("asked"),
                    "quarantined": Median("held"),
                },
                lambda kind: [kind[0], f"{kind[2]:.0%}", kind[1]],
            ),
        ),
        goals=[_goal(chance, way) for way in (ASKED, UNHURRIED) for chance in CHANCES],
        notes=_notes,
        numbers=lambda groups: {
            f"{name}, {chance:.0%}, {way}": {
                "needed": _count(groups, kind),
                "end": round(means(groups[kind])[-1], 3),
            }
            for name, chance, way in product(TASKS, CHANCES, (CLEAN, *WAYS))
            for kind in [(name, way, 0.0 if way == CLEAN else chance)]
        },
    ),
    draw=Panels([partial(_draw, chance=chance) for chance in CHANCES], wide=3.2, prepare=_group),
    worlds=("forage", "soccer"),
)
