"""Why the robot does what it does, in words: the decision now, and the last switch it made by itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from understudy.desk.words import signed
from understudy.learning.explain import Explanation, explain
from understudy.learning.transitions import learn
from understudy.model.account import shown
from understudy.model.automaton import Transition
from understudy.model.conditions import sentences
from understudy.model.lesson import Lesson
from understudy.model.tree import Tree
from understudy.training.screen import Screen
from understudy.training.session import Session
from understudy.training.trainee import Mode

MOST_EXAMPLES = 6


@dataclass(frozen=True, slots=True)
class Switch:
    """A switch that what was learned made by itself."""

    time_s: float
    before: str
    after: str
    values: tuple[float, ...]


class Why:
    """Explains one session; what the lesson says is learned again only when the lesson changed."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._for: tuple[object, ...] = ()
        self._lesson: Lesson = session.lesson
        self._transitions: dict[str, Transition] = {}
        self.switch: Switch | None = None

    def learned(self) -> tuple[Lesson, Mapping[str, Transition]]:
        """The lesson as it stands, and what was learned from it; both the same objects until it changes."""
        session = self._session
        key = (session.examples, session.automaton)
        if not self._for or any(new is not old for new, old in zip(key, self._for, strict=True)):
            self._for, self._lesson = key, session.lesson
            self._transitions = dict(learn(self._lesson))
        return self._lesson, self._transitions

    def decision(self, state: str, values: Sequence[float]) -> Explanation:
        """What the lesson as it stands decides in a state for a feature vector."""
        self.learned()
        return explain(self._lesson, state, values, self._transitions.get(state))

    def rules(self) -> list[tuple[str, str]]:
        """What was learned so far: (state, when it is left), a pair per condition."""
        self.learned()
        automaton = self._lesson.automaton
        said = []
        for state, function in self._transitions.items():
            if not isinstance(function, Tree):
                said.append((state, "decided by a classifier of scikit-learn"))
                continue
            vectors = shown(self._lesson, state)
            found = sentences(function, automaton.features, automaton.state_names, state, vectors)
            said.extend((state, signed(sentence)) for sentence in found)
        return said

    def lines(self, screen: Screen) -> list[str]:
        """The explanation in sentences."""
        values = tuple(screen.features.values())
        now = self.decision(screen.state, values) if screen.flag is None else None
        if screen.mode is Mode.TRAINING:
            said = ["You decide: it is in training."]
            said.append(f"In testing it {_said(now)}." if now else "A raised flag is never left.")
        else:
            said = [
                f"It {_said(now)}." if now else f"It raised {screen.flag}, which is never left by itself."
            ]
        if self.switch is not None:
            was = self.decision(self.switch.before, self.switch.values)
            when = f"{screen.time_s - self.switch.time_s:.1f} s ago"
            if was.next == self.switch.after:
                said.append(f"{when} it went from {was.state} to {was.next}{_because(was)}.")
            else:  # the lesson changed since
                said.append(
                    f"{when} it went from {was.state} to {self.switch.after}; by now it {_said(was)}."
                )
        return said


def _said(explanation: Explanation) -> str:
    stays = explanation.next == explanation.state
    what = (
        f"stays in {explanation.state}" if stays else f"goes from {explanation.state} to {explanation.next}"
    )
    return what + _because(explanation)


def _because(explanation: Explanation) -> str:
    if not explanation.shown:
        return (
            ": nothing was ever shown there"
            if not explanation.conditions
            else (f": nothing was ever shown where {signed(' and '.join(explanation.conditions))}")
        )
    because = (
        f" because {signed(' and '.join(explanation.conditions))}" if explanation.conditions else ", always"
    )
    numbers = [str(example.number) for example in explanation.examples if example.pressed]
    more = "…" if len(numbers) > MOST_EXAMPLES else ""
    return f"{because} (shown by {', '.join(numbers[:MOST_EXAMPLES])}{more})" if numbers else because
