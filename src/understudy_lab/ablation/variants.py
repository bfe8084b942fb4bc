"""What is taken away or changed: each variant differs from the one it is set against in one thing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from understudy.model.lesson import LearnerOptions, TreeOptions
from understudy_lab.ablation.feature_variants import (
    with_all_features,
    with_angle_as,
    with_features_of_all,
    without_flags,
)
from understudy_lab.ablation.simulated_people import Candid, Confirming, Inattentive
from understudy_lab.tasks.forage_teacher import TOPICS, WATCHED
from understudy_lab.teachers.person import ReactionTime, SimulatedPerson
from understudy_lab.teachers.teacher import LessonPlan, MakesPerson

BASE = "as the demo teaches"
SILENT = "not watched"


@dataclass(frozen=True)
class Variant:
    """One way to teach foraging: what it is about, what it is set against, and what is different.

    `drawn` tells whether the leaves of what was learned draw in the end: by votes, or by corrected votes.
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
    """The options of all lessons with something changed."""
    return {name: replace(each, **changed) for name, each in options.items()}  # type: ignore[arg-type]


def _late(seconds: float) -> Mapping[str, LearnerOptions]:
    """The usual options, but for a demonstrator known to be this late."""
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
