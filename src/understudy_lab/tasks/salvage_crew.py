"""How a person teaches the coordinator of scouts and carriers: Lead, by joint orders to both."""

from __future__ import annotations

from understudy.model.kinds import YES
from understudy.training.lesson_design import new_lesson
from understudy.training.session_view import Screen
from understudy_lab.teachers.person import after
from understudy_lab.teachers.teacher import Case, Topic


def show_lead(screen: Screen) -> str | None:
    """All seek until a scout is at a wreck; then two thirds of the carriers haul; when all scouts are, all do, and
    scouts stay where they are.
    """
    if screen.features["all_found(wreck)"] == YES:
        return "work"
    return "share" if screen.features["some_found(wreck)"] == YES else "seek"


LEAD = Topic(
    "lead",
    lambda library: new_lesson(
        library,
        "lead",
        states=["seek", "share", "work"],
        features=["some_found(wreck)", "all_found(wreck)"],
    ),
    show_lead,
    show_lead,
    after(200.0),
    cases=(Case("wrecks with little in them", enough=after(200.0)),),
    tries=3,
    limit_s=240.0,
    patience_s=1000.0,
)

TOPICS = (LEAD,)
