"""The variants: each differs from its reference in one thing."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import atan2, pi, tau
from typing import TypeAlias

import numpy as np

from understudy.model.features import ReadingsView, feature
from understudy.model.learner_options import LearnerOptions, TreeOptions
from understudy.model.library import Kit
from understudy.model.value_kinds import NO, YES, Column, Continuous
from understudy.sim.forage import FORAGE_KIT as usual_kit
from understudy.training.session import Session
from understudy.training.trainee import SessionView
from understudy_lab.tasks.forage_teacher import CAPACITY, TOPICS, WATCHED
from understudy_lab.teachers.person import ReactionTime, Seen, SimulatedPerson, TryResult, Wish
from understudy_lab.teachers.teacher import LessonPlan, MakesPerson

Translate: TypeAlias = Callable[[SessionView], Mapping[str, float]]
"""A function that recovers usual features from a view that does not show them."""


@feature(Continuous(), unit="rad")
def signed_angle_to(robot: ReadingsView, A: ReadingsView) -> Column:
    """Where it is, from -pi to pi: 0 ahead, left positive."""
    return np.mod(A.bearing + pi, tau) - pi


@feature(Continuous(), unit="rad")
def round_angle_to(robot: ReadingsView, A: ReadingsView) -> Column:
    """Where it is, from 0 to 2 pi as a plain number."""
    return A.bearing


@feature(Continuous())
def sine_to(robot: ReadingsView, A: ReadingsView) -> Column:
    """The sine of where it is: positive to the left."""
    return np.sin(A.bearing)


@feature(Continuous())
def cosine_to(robot: ReadingsView, A: ReadingsView) -> Column:
    """The cosine of where it is: positive ahead."""
    return np.cos(A.bearing)


kit = usual_kit + Kit.from_parts(signed_angle_to, round_angle_to, sine_to, cosine_to)


def with_angle_as(*features: str) -> tuple[LessonPlan, ...]:
    """Return the usual plans with these features in place of the angle."""

    def angle(screen: SessionView) -> Mapping[str, float]:
        values = [screen.features[name] for name in features]
        return {"angle_to(A)": (values[0] if len(values) == 1 else atan2(*values)) % tau}

    goto, *others = TOPICS
    return (_choosing(_seen_as(goto, angle), ("distance_to(A)", *features)), *others)


def with_all_features() -> tuple[LessonPlan, ...]:
    """Return the usual plans, each with every feature of the kit for every target, in the order of the kit."""
    chosen = []
    for topic in TOPICS:
        targets = [*(["A"] if topic.name == "goto" else []), *usual_kit.targets]
        features = [
            f"{name}({target})" if each.parameters else name
            for name, each in usual_kit.features.items()
            for target in (targets if each.parameters else targets[:1])
        ]
        chosen.append(_choosing(topic, features))
    return tuple(chosen)


def with_features_of_all() -> tuple[LessonPlan, ...]:
    """Return the usual plans, each with every feature that any of the four lessons needs."""
    own = ("done", "food_left", "food_stored", "food_below_me", "at_station")
    goto, *others = TOPICS
    return (
        _choosing(goto, ("distance_to(A)", "angle_to(A)", *own)),
        *(_choosing(topic, own) for topic in others),
    )


def without_flags() -> tuple[LessonPlan, ...]:
    """Return the usual plans without flags of lower automata as features, so that other features must replace them."""
    goto, harvest, deposit, forage = TOPICS

    def at_food(screen: SessionView) -> Mapping[str, float]:
        return {"done": YES if screen.features["food_below_me"] > 0 else NO}

    def at_station(screen: SessionView) -> Mapping[str, float]:
        return {"done": screen.features["at_station"]}

    def half_done(screen: SessionView) -> Mapping[str, float]:
        stored, left = screen.features["food_stored"], screen.features["food_left"]
        harvested = stored >= CAPACITY or left == NO
        return {"done": YES if (harvested if screen.state == "harvest" else stored == 0) else NO}

    return (
        goto,
        _choosing(_seen_as(harvest, at_food), ("food_left", "food_stored", "food_below_me")),
        _choosing(_seen_as(deposit, at_station), ("food_stored", "at_station")),
        _choosing(_seen_as(forage, half_done), ("food_stored", "food_left")),
    )


def _choosing(topic: LessonPlan, features: Sequence[str]) -> LessonPlan:
    """Return the plan with other features for its lesson."""
    return replace(topic, design=replace(topic.design, features=features))


def _seen_as(topic: LessonPlan, translate: Translate) -> LessonPlan:
    """Return the plan with rules that first translate the view."""

    def known(screen: SessionView) -> SessionView:
        return replace(screen, features={**screen.features, **translate(screen)})

    def wish(of: Wish) -> Wish:
        return lambda screen: of(known(screen))

    def seen(of: Seen) -> Seen:
        return lambda screen: of(known(screen))

    cases = tuple(replace(case, suits=seen(case.suits), enough=seen(case.enough)) for case in topic.cases)
    return replace(
        topic,
        show=wish(topic.show),
        complain=wish(topic.complain),
        finished=seen(topic.finished),
        cases=cases,
    )


ATTENTIVE_S, AWAY_S = 8.0, 4.0
"""The mean times in s for which a person looks, and looks away."""
CONTENT_S = 0.6
"""The time in s of right behavior after which a person confirms it."""


class Inattentive(SimulatedPerson):
    """A person who looks away a third of the time, for exponentially drawn spans, and presses only while looking."""

    def __init__(self, draws: np.random.Generator, reaction: ReactionTime = ReactionTime()) -> None:
        super().__init__(draws, reaction)
        self._spans = np.random.default_rng(int(draws.integers(2**63)))
        self._looking = True
        self._left_s = self._spans.exponential(ATTENTIVE_S)

    def _consider(self, session: Session, wished: str | None, now: float) -> None:
        self._left_s -= session.body.tick_s
        if self._left_s <= 0:
            self._looking = not self._looking
            self._left_s = self._spans.exponential(ATTENTIVE_S if self._looking else AWAY_S)
            self._turned(session)
        super()._consider(session, wished if self._looking else None, now)

    def _turned(self, session: Session) -> None:
        """Do nothing when the person looks away or back; subclasses may tell the session."""


class Candid(Inattentive):
    """An inattentive person who switches "watching" off in the session while looking away."""

    def _turned(self, session: Session) -> None:
        session.is_watching = self._looking


class Confirming(SimulatedPerson):
    """A person who confirms each state that they directed the robot to, a moment later.

    A person would have to teach in this way if staying were not recorded automatically.
    """

    def __init__(self, draws: np.random.Generator, reaction: ReactionTime = ReactionTime()) -> None:
        super().__init__(draws, reaction)
        self._confirm_at: float | None = None

    def show(self, session: Session, wish: Wish, *, until: Seen, limit_s: float) -> TryResult:
        """Direct the robot, and confirm where it stays."""
        self._confirm_at = None
        return super().show(session, wish, until=until, limit_s=limit_s)

    def test(
        self, session: Session, complaint: Wish, *, until: Seen, limit_s: float, patience_s: float
    ) -> TryResult:
        """Let the robot try; after a correction observe whether it works, and confirm that."""
        self._confirm_at = None
        verdict = super().test(session, complaint, until=until, limit_s=limit_s, patience_s=patience_s)
        if verdict is TryResult.CORRECTED:
            session.run_for(CONTENT_S)
            self.seconds += CONTENT_S
            screen = session.view()
            if screen.flag is None and complaint(screen) in (None, screen.state):
                self._confirm(session)
                session.tick()
                self.seconds += session.body.tick_s
        return verdict

    def _consider(self, session: Session, wished: str | None, now: float) -> None:
        before = self.presses
        super()._consider(session, wished, now)
        if self.presses > before:
            self._confirm_at = now + CONTENT_S
        elif wished is None and self._confirm_at is not None and now >= self._confirm_at - 1e-9:
            self._confirm_at = None
            if session.view().flag is None:
                self._confirm(session)

    def _confirm(self, session: Session) -> None:
        session.confirm()
        self.presses += 1


BASE = "as the demo teaches"
SILENT = "not watched"


@dataclass(frozen=True)
class Variant:
    """One way to teach foraging: its subject, its reference, and the differences.

    `drawn` selects randomized leaves at the end: by votes, by corrected votes, or none.
    """

    about: str
    against: str = BASE
    options: Mapping[str, LearnerOptions] = field(default_factory=lambda: WATCHED)
    topics: tuple[LessonPlan, ...] = TOPICS
    reaction: ReactionTime = ReactionTime()
    person: MakesPerson = SimulatedPerson
    drawn: str = ""


def _options(
    options: Mapping[str, LearnerOptions] = WATCHED, **changed: object
) -> Mapping[str, LearnerOptions]:
    """Return the options of all lessons with changes."""
    return {name: replace(each, **changed) for name, each in options.items()}  # type: ignore[arg-type]


def _late(seconds: float) -> Mapping[str, LearnerOptions]:
    """Return the usual options with this reaction time in s."""
    return {**WATCHED, "goto": replace(WATCHED["goto"], reaction_s=seconds)}


def _reaction(seconds: float) -> ReactionTime:
    return ReactionTime(seconds, 0.4 * seconds, 0.4 * seconds)


NEXT_TICK = ReactionTime(0.0, 0.0, 0.05)
"""No delay at all: what is seen at one tick is pressed for the next. (Pressing at the very tick would correct a robot
before it has done anything.)"""
SILENTLY = _options(watched=False)
NO_DEFAULTS = TreeOptions(defaults=False)
KNOWN, UNKNOWN = "reaction time known", "reaction time unknown"

VARIANTS: Mapping[str, Variant] = {
    BASE: Variant("the base"),
    SILENT: Variant("watched examples", options=SILENTLY),
    "inattentive": Variant("watched examples", person=Inattentive),
    "inattentive, and says so": Variant("watched examples", person=Candid),
    "inattentive, not watched": Variant(
        "watched examples", against=SILENT, options=SILENTLY, person=Inattentive
    ),
    "no automatic defaults, not watched": Variant(
        "automatic defaults", against=SILENT, options=_options(SILENTLY, learner=NO_DEFAULTS)
    ),
    "defaults by hand, not watched": Variant(
        "automatic defaults",
        against=SILENT,
        options=_options(SILENTLY, learner=NO_DEFAULTS),
        person=Confirming,
    ),
    "cuts at midpoints, not watched": Variant(
        "boundary", against=SILENT, options=_options(SILENTLY, learner=TreeOptions(boundary="midpoint"))
    ),
    "angle from -π to π": Variant("angles", topics=with_angle_as("signed_angle_to(A)")),
    "angle from 0 to 2π": Variant("angles", topics=with_angle_as("round_angle_to(A)")),
    "sine and cosine": Variant("angles", topics=with_angle_as("sine_to(A)", "cosine_to(A)")),
    "no flags to see": Variant("flags", topics=without_flags()),
    "the task's features everywhere": Variant("features", topics=with_features_of_all()),
    "all features, not watched": Variant(
        "features", against=SILENT, topics=with_all_features(), options=SILENTLY
    ),
    "leaves draw by votes": Variant("leaves", drawn="votes"),
    "leaves draw by corrected votes": Variant("leaves", drawn="corrected votes"),
    f"next tick (0.1 s), {UNKNOWN}": Variant("delay", options=_late(0.0), reaction=NEXT_TICK),
    f"next tick (0.1 s), {KNOWN}": Variant("delay", options=_late(0.1), reaction=NEXT_TICK),
    f"0.25 s late, {UNKNOWN}": Variant("delay", options=_late(0.0)),
    f"0.5 s late, {UNKNOWN}": Variant("delay", options=_late(0.0), reaction=_reaction(0.5)),
    f"0.5 s late, {KNOWN}": Variant("delay", options=_late(0.5), reaction=_reaction(0.5)),
    f"1 s late, {UNKNOWN}": Variant("delay", options=_late(0.0), reaction=_reaction(1.0)),
    f"1 s late, {KNOWN}": Variant("delay", options=_late(1.0), reaction=_reaction(1.0)),
}
"""By name, in the order in which they are told. The base presses 0.25 s late, and its lesson says 0.2 s."""
