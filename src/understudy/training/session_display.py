"""Representations of a session: a line for `repr`, and a card in notebooks."""

from __future__ import annotations

from understudy.model.drawing import call_markup, format_number_of, format_repr
from understudy.runtime.body import Body
from understudy.training.lesson_log import LessonLog
from understudy.training.trainee import Trainee


class SessionDisplay:
    """The part of a session that represents it."""

    body: Body
    trainee: Trainee
    _log: LessonLog

    def __repr__(self) -> str:
        lesson, taught = self._log.lesson, self.trainee.taught
        examples = format_number_of(len(lesson.examples), "example")
        facts = [f"{self.trainee.mode} mode", f"in state {taught.state_name}", examples]
        return format_repr(self, f"of {lesson.name!r}", *facts, f"at {self.body.time_s:.1f} s")

    def _repr_html_(self) -> str:
        return call_markup("html_cards:write_session_html", self)
