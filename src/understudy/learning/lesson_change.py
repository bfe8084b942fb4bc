"""Changes of lessons: what an automaton decides otherwise after presses and edits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property

from understudy.errors import UnderstudyError
from understudy.learning.fit import learn_automaton
from understudy.model.automaton import Automaton, Transition
from understudy.model.change_summary import ChangeSummary, summarize_change
from understudy.model.learner_options import TreeOptions
from understudy.model.lesson import Example, Lesson
from understudy.model.library import TrainedAutomaton


class LessonStep:
    """A step from one lesson to the next; its summary is computed on the first request.

    Parameters
    ----------
    before
        The lesson before the step.
    after
        The lesson after it.
    former
        The automaton that was learned before the step. None: it is learned on request.
    learned
        The automaton that was learned after it. None: it is learned on request.
    """

    def __init__(
        self,
        before: Lesson,
        after: Lesson,
        *,
        former: Automaton | None = None,
        learned: Automaton | None = None,
    ) -> None:
        self._lessons = before, after
        self._former, self._learned = former, learned

    @cached_property
    def summary(self) -> ChangeSummary | None:
        """What the automaton decides otherwise since; None if there is nothing to say."""
        before, after = self._lessons
        if not all(isinstance(each.options.learner, TreeOptions) for each in self._lessons):
            return None
        try:
            old, new = self._former or learn_automaton(before), self._learned or learn_automaton(after)
        except UnderstudyError:  # what is left of the lesson cannot be learned
            return None
        return summarize_lesson_change(TrainedAutomaton(old, before), TrainedAutomaton(new, after))


class ChangeSince:
    """The changed decisions of an automaton since a former lesson, compared again only if the lesson has changed.

    Parameters
    ----------
    former
        The former lesson. None: there is none, and nothing to say.
    """

    def __init__(self, former: Lesson | None) -> None:
        self._former = former
        self._step: tuple[Lesson, LessonStep] | None = None

    def summarize(self, lesson: Lesson, transitions: Mapping[str, Transition]) -> ChangeSummary | None:
        """Summarize what the transition functions learned from a lesson decide otherwise."""
        if self._former is None:
            return None
        if self._step is None or self._step[0] is not lesson:
            learned = replace(lesson.automaton, transitions=transitions)
            self._step = lesson, LessonStep(self._former, lesson, learned=learned)
        return self._step[1].summary


def summarize_lesson_change(before: TrainedAutomaton, after: TrainedAutomaton) -> ChangeSummary | None:
    """Summarize what an automaton decides otherwise than its former version, apart from what new presses say."""
    was, now = before.lesson, after.lesson
    pressed = [] if was is None or now is None else list_new_presses(was, now)
    return summarize_change(before, after, pressed)


def list_new_presses(before: Lesson, after: Lesson) -> list[Example]:
    """List the press-made examples that a lesson did not have before: those that were pressed or edited since."""
    former = {_identify(example) for example in before.examples}
    return [each for each in after.examples if each.is_from_press and _identify(each) not in former]


def _identify(example: Example) -> tuple[object, ...]:
    """Return what an example teaches; absent values are None, as NaN differs from itself."""
    values = (None if value != value else value for value in example.values)
    return example.number, example.state, example.next, bool(example.quarantined), *values
