"""What became of an automaton that was tested, in sentences: the same in the terminal and in the studio."""

from __future__ import annotations

from collections.abc import Iterator

from understudy.analysis.lesson_replay import Replayed
from understudy.analysis.lesson_tests import Examined, Failed, sentences
from understudy.errors import listed

MOST_CHANGES = 6


def lines(seen: Examined, former: str) -> Iterator[str]:
    """What there is to say of it, the worst first; `former` is what the former version is called ("version 3")."""
    yield from worse(seen)
    yield from otherwise(seen, former)


def worse(seen: Examined) -> Iterator[str]:
    """What worked and no longer does, and promises that are not kept."""
    yield from sentences(seen.replayed)
    yield from map(failed, seen.failed)


def otherwise(seen: Examined, former: str) -> Iterator[str]:
    """What else is not as shown, or not as it was, and whom that affects."""
    numbers = [str(each.number) for each in seen.replayed.otherwise]
    if numbers:
        many = f"{len(numbers)} example{'s' * (len(numbers) != 1)}"
        yield f"{many} decided otherwise than shown: {', '.join(numbers)}"
    if seen.replayed.changes:
        yield _anew(seen.replayed)
    if seen.changed:
        run = "runs" if len(seen.affected) == 1 else "run"
        yield f"changed since {former}" + (f"; {listed(seen.affected)} {run} it" if seen.affected else "")


def failed(each: Failed) -> str:
    """That a promise was not kept, and with which former versions it would have been, or why it cannot be tried."""
    why = f": {each.tried.problem}" if each.tried.problem else ""
    if each.since:
        why = f"; it does with the former version of {listed(each.since)}"
    return f"promised, and did not come: {each.tried.outcome}{why}"


def _anew(replay: Replayed) -> str:
    """What is decided otherwise in the second before presses."""
    total = sum(each.moments for each in replay.changes)
    said = listed(
        f"{each.now} instead of {each.formerly} in {each.state} ({each.moments})"
        for each in replay.changes[:MOST_CHANGES]
    )
    return f"at {total} of {replay.before} moments before presses it decides anew: {said}"
