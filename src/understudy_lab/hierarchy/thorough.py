"""A teacher who, where a try went nowhere, looks at each of the parts: layers allow that, one automaton does not."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

from understudy.model.lesson import Lesson
from understudy.runtime.body import Body
from understudy.training.session import Session
from understudy_lab.teachers.person import Verdict
from understudy_lab.teachers.teacher import Teacher, Topic

MOST = 20
"""So many corrections of one part are borne at one look."""


class Thorough(Teacher):
    """Where a try is lost, tries every part on the spot, in the order taught; corrects it, or shows it again.

    The innermost automaton alone is often not to blame: a Harvest that leaves its food too early looks like a GoTo.
    Where no part goes wrong on the spot, the one that was running is shown again. Who is content is told whether what
    they taught `held` in worlds that they do not see; where not, they go on with tries until they are content again.
    """

    def __init__(self, *arguments: Any, held: Callable[[str], bool], **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._held = held
        self._shown_again: Counter[str] = Counter()

    def _try(self, topic: Topic, lesson: Lesson) -> bool:
        content = super()._try(topic, lesson)
        while not self._held(topic.name) and content and not self._had_enough(topic):
            content = super()._try(topic, self.library.taught[topic.name].lesson or lesson)
        return content

    def _correct_below(self, session: Session) -> bool:
        """Put right every part of the automaton in this session; whether that helps."""
        running = session.automaton.state(session.screen().path[0]).behavior
        wrong = False
        for name, topic in self._topics.items():
            if name != session.automaton.name:
                for targets in _targets(topic):
                    wrong = self._put_right(topic, session.body, targets) or wrong
        if not wrong and running in self._topics:
            self._show_again(self._topics[running])  # it goes wrong at times only
            return True
        return wrong

    def _put_right(self, topic: Topic, body: Body, targets: Mapping[str, str]) -> bool:
        lesson = self.library.taught[topic.name].lesson
        if lesson is None:
            return False
        part = Session(body, self.library, lesson, targets=targets)
        if targets and any(value != value for value in part.screen().features.values()):
            return False  # its target is not there
        for corrections in range(MOST):
            verdict = self._test(topic, part)
            if verdict is Verdict.CORRECTED:
                continue
            if verdict is Verdict.LOST:
                self._show_again(topic)
            return corrections > 0 or verdict is Verdict.LOST
        return True

    def _show_again(self, topic: Topic) -> None:
        lesson = self.library.taught[topic.name].lesson
        if lesson is not None:
            case = topic.cases[self._shown_again[topic.name] % len(topic.cases)]
            self._shown_again[topic.name] += 1
            self._show_case(topic, case, lesson)


def _targets(topic: Topic) -> list[Mapping[str, str]]:
    """What its parameters stood for when it was shown, each once."""
    return list({tuple(case.targets.items()): case.targets for case in topic.cases}.values())
