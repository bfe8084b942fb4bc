"""The coach at the desk: what to show next, set up on a key, and the robot that asks where it is unsure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from understudy.coaching.advice import Advice
from understudy.coaching.asking import Asking, Question, When
from understudy.coaching.coach import advice
from understudy.coaching.staging import stage
from understudy.desk.said import Said
from understudy.desk.why import Why
from understudy.errors import SessionError
from understudy.training.session import Session

if TYPE_CHECKING:
    from understudy.desk.desk import Desk

TURN = (When.NEVER, When.PAUSE, When.MARK)
WHEN_SAID = {
    When.NEVER: "It does not ask",
    When.PAUSE: "It asks where it is unsure, and waits",
    When.MARK: "Where it is unsure it goes on, and marks the moment",
}


class Coach:
    """Advice on one session's lesson, made again only when the lesson changed; `asking` is off at first."""

    def __init__(self, session: Session, why: Why) -> None:
        self.asking = Asking(session, When.NEVER)
        self._session, self._why = session, why
        self._for: object = None
        self._advice: tuple[Advice, ...] = ()
        self._next = 0

    def advice(self) -> tuple[Advice, ...]:
        """What the lesson lacks as it stands, most useful first."""
        lesson, transitions = self._why.learned()
        if self._for is not lesson:
            self._for, self._next = lesson, 0
            self._advice = advice(lesson, transitions, kit=self._session.library.kit)
        return self._advice

    def ask_otherwise(self) -> str:
        """Go on to the next way of asking; what it is now."""
        asking = self.asking
        asking.when = TURN[(TURN.index(asking.when) + 1) % len(TURN)]
        return WHEN_SAID[asking.when]

    def set_up_next(self, seeds: Sequence[int] = ()) -> tuple[str, int | None]:
        """Set up the next advice that is about a place; its sentence, with what could not be, and the world's new seed.

        SessionError where no advice is about a place.
        """
        places = [each for each in self.advice() if each.region is not None]
        if not places:
            said = [each.sentence for each in self.advice()] or ["what was shown hangs together"]
            raise SessionError(f"there is no place to go to: {said[0]}")
        chosen = places[self._next % len(places)]
        self._next += 1
        staged = stage(self._session, chosen, seeds=seeds)
        return chosen.sentence + ("" if staged.there else f" {staged.sentence}"), staged.seed


OTHER_WORLDS = 4
"""So many further worlds are looked through for a situation that this one does not have."""


def set_up(desk: Desk) -> None:
    """Set up the next situation that the coach wants to be shown; nothing is recorded."""
    if desk.driving:
        desk.drive()
    said, seed = desk.coach.set_up_next(range(desk.seed_after, desk.seed_after + OTHER_WORLDS))
    desk.seed = desk.seed if seed is None else seed
    desk.moved(said)


def wait(desk: Desk, question: Question) -> None:
    """Let time stand still at a question; going on is an answer, too."""
    if not desk.paused:
        desk.pause()
    desk.said = Said(f"{question.sentence} Space lets it go on", "correction")
