"""Tests of lessons: whether a library still does what it was taught, and which automata are affected by a change."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

from understudy.errors import UnderstudyError, join_names
from understudy.judging.lesson_replay import LessonReplay, replay_lesson
from understudy.judging.properties.run_property import PropertyResult
from understudy.judging.properties.stored_moments import run_moment_property
from understudy.learning.fit import learn
from understudy.learning.training_set import select_teaching_examples
from understudy.model.learner_options import SklearnOptions
from understudy.model.lesson import Lesson, ReadingLog
from understudy.model.library import Library, TrainedAutomaton, list_dependencies
from understudy.model.property import Property, StoredMoment
from understudy.sim.team.libraries import Libraries
from understudy.storage.document import fingerprint_automaton
from understudy.storage.library_folder import make_file_stem, read_document

NOBODY: Libraries = MappingProxyType({})
MOST_NAMED = 3
"""The largest number of examples that a sentence names."""
MOST_CHANGES = 6


@dataclass(frozen=True, slots=True)
class FailedProperty:
    """A property of a lesson that failed.

    `since` names the automata whose former version, put in the place of the current one, makes it hold.
    """

    result: PropertyResult
    since: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class LessonTestResult:
    """The result of testing one automaton.

    `replayed` compares its decisions with its lesson and its former version. `properties` are the results of its
    properties, and `failed` those that failed. `changed` is True if the automaton or its transition functions
    differ from the former version; `affected` then names the automata that run it, directly or through others.
    """

    name: str
    replayed: LessonReplay
    properties: tuple[PropertyResult, ...]
    failed: tuple[FailedProperty, ...]
    changed: bool
    affected: tuple[str, ...]

    @property
    def is_passing(self) -> bool:
        """True if no decision became wrong since the former version and no property failed."""
        return not self.replayed.regressions and not self.failed


def run_lesson_test(
    library: Library, name: str, formers: Mapping[str, TrainedAutomaton], libraries: Libraries = NOBODY
) -> LessonTestResult:
    """Test an automaton of a library on its lesson and the properties that are stored in it.

    `formers` has the former versions by name, for those automata that have one. `libraries` has the library of each
    sort of agent, which is needed if the world of a property has coordinators.
    """
    taught, former = library.taught[name], formers.get(name)
    changed = former is not None and has_changed(former, taught)
    results = [run_moment_property(each, name, library, libraries) for each in _list_properties(taught)]
    return LessonTestResult(
        name,
        replay_lesson(taught, former),
        tuple(results),
        tuple(
            FailedProperty(each, _since(each.tested, name, library, formers, libraries))
            for each in results
            if not each.was_met
        ),
        changed,
        list_dependents(library, name, libraries) if changed else (),
    )


def has_changed(former: TrainedAutomaton, taught: TrainedAutomaton) -> bool:
    """Return whether an automaton differs from its former version, including its transition functions.

    Classifiers are compared by the examples and options they are fitted to, because each fit makes a new object.
    """
    if (
        former.lesson is None
        or taught.lesson is None
        or not isinstance(taught.lesson.options.learner, SklearnOptions)
    ):
        return former.automaton != taught.automaton
    return fingerprint_automaton(_bare(former, former.lesson)) != fingerprint_automaton(
        _bare(taught, taught.lesson)
    )


def _bare(taught: TrainedAutomaton, lesson: Lesson) -> TrainedAutomaton:
    """Make an automaton whose lesson has only the examples and options that its classifier is fitted to."""
    examples = tuple(
        replace(each, moment=None, window=0, quarantined="") for each in select_teaching_examples(lesson)
    )
    return TrainedAutomaton(
        taught.automaton, replace(lesson, examples=examples, record=ReadingLog(), properties=())
    )


def _list_properties(taught: TrainedAutomaton) -> tuple[Property, ...]:
    return () if taught.lesson is None else taught.lesson.properties


def _since(
    subject: Property,
    name: str,
    library: Library,
    formers: Mapping[str, TrainedAutomaton],
    libraries: Libraries,
) -> tuple[str, ...]:
    """List the automata whose former version makes a property hold."""
    causes = []
    for each in list_dependencies(library, name):
        former = formers.get(each)
        if former is None or not has_changed(former, library.taught[each]):
            continue
        if run_moment_property(subject, name, library.with_automaton(former), libraries).was_met:
            causes.append(each)
    return tuple(causes)


def list_dependents(library: Library, name: str, libraries: Libraries = NOBODY) -> tuple[str, ...]:
    """List the automata that run the given one, directly or through others.

    Automata of coordinators in other libraries that order one of these are listed as SORT/NAME.
    """
    users: dict[str, None] = {}
    waiting = [name]
    while waiting:
        each = waiting.pop()
        waiting += [user for user in library.find_users(each) if user not in users]
        users |= dict.fromkeys(library.find_users(each))
    ordering = (f"{sort}/{user}" for sort, user in _ordering({name, *users}, library, libraries))
    return (*users, *ordering)


def _ordering(runs: set[str], library: Library, libraries: Libraries) -> Iterator[tuple[str, str]]:
    """Yield the coordinators' automata, each with its sort, that order one of the automata `runs` of a library.

    Automata that run such an automaton, directly or through others, are included.
    """
    for sort, other in libraries.items():
        if other is not library:
            ordering = {key for key in other.taught if runs & set(_ordered(other, key))}
            users = {user for key in ordering for user in (key, *list_dependents(other, key))}
            yield from ((sort, user) for user in other.taught if user in users)


def _ordered(library: Library, name: str) -> Iterator[str]:
    """Yield the names of the behaviors that a coordinator's automaton orders its members to run."""
    for state in library.taught[name].automaton.states:
        behavior = library.kit.behaviors.get(state.behavior or "")
        if behavior is not None and behavior.order is not None:
            yield from (duty.behavior for duty in behavior.order.duties)


def find_regressions(
    library: Library, taught: TrainedAutomaton, former: TrainedAutomaton | None, libraries: Libraries = NOBODY
) -> tuple[str, ...]:
    """List, one sentence each, the presses and properties that a new version of an automaton breaks.

    Each worked with the former version. Properties of all automata that run the automaton are tested too.
    `libraries` has the library of each sort of agent, including `library`; if it is empty, properties of
    coordinators are skipped.
    """
    if former is None:
        return ()
    sentences = list(describe_lost_decisions(replay_lesson(taught, former)))
    now, before = (_AllLibraries(library, each, libraries) for each in (taught, former))
    for sort, each in now.list_runners(taught.automaton.name):
        for subject in _list_properties(now.find_library(sort).taught[each]):
            is_testable = not (isinstance(subject.start, StoredMoment) and subject.start.sort) or libraries
            if (
                is_testable
                and not now.does_hold(subject, sort, each)
                and before.does_hold(subject, sort, each)
            ):
                sentences.append(f"{f'{sort}/' if sort else ''}{each} no longer has the property: {subject}")
    return tuple(sentences)


class _AllLibraries:
    """The libraries of all sorts of agents, one of them with a given version of an automaton.

    The sort of the library that has this version is "".
    """

    def __init__(self, library: Library, taught: TrainedAutomaton, libraries: Libraries) -> None:
        self._own = library.with_automaton(taught)
        self._known = {sort: self._own if each is library else each for sort, each in libraries.items()}

    def find_library(self, sort: str) -> Library:
        """Return the library of a sort of agent."""
        return self._known[sort] if sort else self._own

    def list_runners(self, name: str) -> Iterator[tuple[str, str]]:
        """Yield an automaton and all automata that run or order it, each after its sort."""
        running = (name, *list_dependents(self._own, name))
        yield from (("", each) for each in running)
        yield from _ordering(set(running), self._own, self._known)

    def does_hold(self, subject: Property, sort: str, name: str) -> bool:
        """Return whether a property of an automaton holds with these libraries."""
        return run_moment_property(subject, name, self.find_library(sort), self._known).was_met


def describe_lost_decisions(replay: LessonReplay) -> Iterator[str]:
    """Yield a sentence about each kind of decision that agreed with the demonstrator before and no longer does."""
    by_way: dict[tuple[str, str, str], list[str]] = {}
    for each in replay.regressions:
        by_way.setdefault((each.state, each.shown, each.now), []).append(str(each.number))
    for (state, wanted, now), numbers in by_way.items():
        was = f"stayed in {state}" if wanted == state else f"went from {state} to {wanted}"
        more = f" and {len(numbers) - MOST_NAMED} more" if len(numbers) > MOST_NAMED else ""
        which = f"example{'s' * (len(numbers) > 1)} {', '.join(numbers[:MOST_NAMED])}{more}"
        does = "stays" if now == state else f"goes to {now}"
        yield f"where it {was} as shown ({which}), it now {does}"


def describe_test_result(result: LessonTestResult, former: str) -> Iterator[str]:
    """Yield sentences about a test result, the most serious first.

    `former` is how the text calls the former version, such as "version 3".
    """
    yield from describe_regressions(result)
    yield from describe_other_differences(result, former)


def describe_regressions(result: LessonTestResult) -> Iterator[str]:
    """Yield sentences about decisions that became wrong and properties that failed."""
    yield from describe_lost_decisions(result.replayed)
    yield from map(describe_failed_property, result.failed)


def describe_other_differences(result: LessonTestResult, former: str) -> Iterator[str]:
    """Yield sentences about other differences from the lesson or the former version, and the automata they affect.

    `former` is how the text calls the former version, such as "version 3".
    """
    numbers = [str(each.number) for each in result.replayed.mismatches]
    if numbers:
        many = f"{len(numbers)} example{'s' * (len(numbers) != 1)}"
        yield f"{many} decided differently than shown: {', '.join(numbers)}"
    if result.replayed.overruled:
        watched = f"{result.replayed.overruled} of {result.replayed.watched} moments in which you watched"
        yield f"{watched}: it decides otherwise than it did"
    if result.replayed.changes:
        yield _describe_changes(result.replayed)
    if result.changed:
        run = "runs" if len(result.affected) == 1 else "run"
        yield f"changed since {former}" + (
            f"; {join_names(result.affected)} {run} it" if result.affected else ""
        )


def describe_failed_property(each: FailedProperty) -> str:
    """Describe a property that failed: with which former versions it holds, or why it could not be tested."""
    why = f": {each.result.problem}" if each.result.problem else ""
    if each.since:
        why = f"; it holds with the former version of {join_names(each.since)}"
    return f"property fails: {each.result.tested}{why}"


def _describe_changes(replay: LessonReplay) -> str:
    """Describe the decisions that changed at moments in the second before presses."""
    total = sum(each.moments for each in replay.changes)
    changes = join_names(
        f"{each.now} instead of {each.formerly} in {each.state} ({each.moments})"
        for each in replay.changes[:MOST_CHANGES]
    )
    return f"at {total} of {replay.before} moments before presses it decides otherwise than before: {changes}"


def find_regressions_since_saved(
    folder: Path | str, library: Library, taught: TrainedAutomaton, libraries: Libraries = NOBODY
) -> tuple[str, ...]:
    """List the presses and properties that an automaton no longer satisfies, although its saved version does.

    There is one sentence for each. `taught` is the automaton, `folder` has its saved version, `library` the automata
    that it uses. See `find_regressions`.
    """
    return find_regressions(
        library,
        taught,
        _read_former_version(Path(folder) / f"{make_file_stem(taught.automaton.name)}.json", library),
        libraries,
    )


def _read_former_version(path: Path, library: Library) -> TrainedAutomaton | None:
    """Read the saved version of an automaton; return None if there is none, or it cannot be read."""
    if not path.exists():
        return None
    try:
        return read_document(path, library.kit, learn).taught
    except UnderstudyError:
        return None  # saving keeps it as a former version, whatever is wrong with it
