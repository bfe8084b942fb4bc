"""Outcomes: promised in a session, kept with the lesson, tried again whenever it changed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.make.goto_sessions import make_goto_session as goto_lesson
from tests.make.sessions import make_session as scripted
from tests.sim.patrollers import ROBOTS, SCENARIO
from tests.ui.cli.forage_parts import goto

from understudy.errors import DefinitionError, SessionError
from understudy.judging.properties.lesson_tests import (
    find_regressions,
    list_dependents,
    run_lesson_test,
)
from understudy.judging.properties.stored_moments import (
    add_moment_property,
    make_moment_property,
    run_moment_property,
)
from understudy.learning.fit import learn_automaton
from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, Feature, ReadingsView
from understudy.model.learner_options import LearnerOptions, SklearnOptions
from understudy.model.library import Library, TrainedAutomaton, list_dependencies
from understudy.model.property import Property, PropertyKind, StoredMoment
from understudy.model.tree import Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import Column, Continuous
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.sim.team.libraries import collect_libraries, make_coordinator_body
from understudy.storage.library_folder import open_document, save_automaton
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session
from understudy_lab.bench.patrol import lead

LIBRARY = Library.from_automata(FORAGE_KIT, goto)
SITS = replace(goto, transitions={"start": Tree((make_leaf(0),))})


def session(journal: Path | None = None) -> Session:
    lesson = new_lesson(
        LIBRARY, "fetch", states=["goto(station)", "forward"], flags=["done"], features=["done"], live=False
    )
    return Session(Forage([9]), LIBRARY, lesson, journal=journal)


def make_taught_session() -> Session:
    """Start, go to the station, done when there."""
    made = session()
    made.direct("goto")
    made.run_for(60.0)
    made.direct("done")
    made.tick()
    made.reset(11)
    return made


def at(subject: Property, **changes: Any) -> Property:
    """Let a property start at a changed moment."""
    assert isinstance(subject.start, StoredMoment)
    return replace(subject, start=replace(subject.start, **changes))


def test_it_comes_or_it_does_not() -> None:
    made = make_taught_session()
    fetch = made.make_trained_automaton()
    library = LIBRARY.with_automaton(fetch)
    promised = make_moment_property(made, flag="done", within_s=60.0)
    came = run_moment_property(promised, "fetch", library)
    assert came.was_met
    assert came.took_s is not None
    assert came.took_s == run_moment_property(promised, "fetch", library).took_s, (
        "a world is the same every time"
    )
    assert run_moment_property(replace(promised, seconds=came.took_s), "fetch", library).was_met
    assert not run_moment_property(replace(promised, seconds=came.took_s - 0.1), "fetch", library).was_met
    assert not run_moment_property(promised, "fetch", library.with_automaton(TrainedAutomaton(SITS))).was_met


def test_time_counts_from_the_moment() -> None:
    """Some seconds later, the flag is raised that much sooner."""
    made = make_taught_session()
    library = LIBRARY.with_automaton(made.make_trained_automaton())
    times = []
    for _ in range(2):
        promised = make_moment_property(made, flag="done", within_s=60.0)
        times.append(run_moment_property(promised, "fetch", library).took_s or 0.0)
        made.direct("goto")
        made.run_for(3.0)
    assert times[1] == pytest.approx(times[0] - 3.0, abs=0.2)


def test_another_flag_is_not_what_was_promised() -> None:
    """It gives up at once instead."""
    promised = make_moment_property(make_taught_session(), flag="done", within_s=5.0)
    states = (START, State("done", flag="done"), State("failed", flag="failed"))
    for index, came in ((1, True), (2, False)):
        fetch = Automaton("fetch", states, transitions={"start": Tree((make_leaf(index),))})
        assert (
            run_moment_property(promised, "fetch", LIBRARY.with_automaton(TrainedAutomaton(fetch))).was_met
            is came
        )


def test_what_cannot_be_tried_says_why() -> None:
    made = make_taught_session()
    promised = make_moment_property(made, flag="done", within_s=5.0)
    assert "has no behavior 'fetch'" in run_moment_property(promised, "fetch", LIBRARY).problem
    library = LIBRARY.with_automaton(made.make_trained_automaton())
    assert "snapshot" in run_moment_property(at(promised, snapshot=b"nothing"), "fetch", library).problem
    assert "TOML" in run_moment_property(at(promised, scenario="nothing ="), "fetch", library).problem
    for agent in (1, -1):
        assert (
            f"no agent {agent} in its world"
            in run_moment_property(at(promised, agent=agent), "fetch", library).problem
        )
    assert "sort 'forager'" in run_moment_property(at(promised, sort="patrol"), "fetch", library).problem


def test_what_breaks_on_the_way_says_why() -> None:
    """A feature of somebody's own that works at first: the outcome does not come, and others can still be tried."""
    calls: list[ReadingsView] = []

    def read_worn_sensor(robot: ReadingsView) -> Column:
        calls.append(robot)
        return np.full(2 if len(calls) > 5 else 1, 1.0)

    feature = BoundFeature(Feature("worn", Continuous(), function=read_worn_sensor))
    cut = Tree((Node(TestKind.BELOW, 0, high=9.0, yes=1, no=2), make_leaf(1), make_leaf(2)))
    states = (START, State("forward", "forward"), State("done", flag="done"))
    fetch = Automaton("fetch", states, (feature,), transitions={"start": cut, "forward": cut})
    found = run_moment_property(
        make_moment_property(make_taught_session(), flag="done", within_s=5.0),
        "fetch",
        LIBRARY.with_automaton(TrainedAutomaton(fetch)),
    )
    assert not found.was_met
    assert "worn" in found.problem


def test_a_promise_is_a_step_that_is_kept_and_undone(tmp_path: Path) -> None:
    made = session(tmp_path / "journal")
    made.direct("goto")
    made.run_for(1.0)
    first = add_moment_property(made, flag="done", within_s=5.0)
    made.run_for(1.0)
    second = add_moment_property(made, flag="done", within_s=7.0)
    assert list(made.lesson.properties) == [first, second]
    assert first.start != second.start
    path = save_automaton(tmp_path, made.make_trained_automaton())
    assert '"within_s": 7' in path.read_text()
    kept = open_document(path, FORAGE_KIT).taught.lesson
    assert kept is not None
    assert kept.properties == (first, second)
    assert made.undo() == "choose properties"
    assert list(made.lesson.properties) == [first]
    made.close()
    again = Session.resume(tmp_path / "journal", Forage([9]), LIBRARY)
    assert list(again.lesson.properties) == [first]
    again.redo()
    assert list(again.lesson.properties) == [first, second]
    again.close()


def test_what_cannot_be_promised() -> None:
    with pytest.raises(SessionError, match="its flags are done"):
        make_moment_property(session(), flag="failed", within_s=5.0)
    with pytest.raises(DefinitionError, match="above 0"):
        make_moment_property(session(), flag="done", within_s=0.0)
    with pytest.raises(SessionError, match="simulated"):
        make_moment_property(scripted(flags=("done",)), flag="done", within_s=1.0)


def test_a_change_below_is_found_from_above() -> None:
    """GoTo changes so that it never arrives: what fetches with it no longer does, and its former version is named."""
    made = make_taught_session()
    add_moment_property(made, flag="done", within_s=60.0)
    library = LIBRARY.with_automaton(made.make_trained_automaton())
    seen = run_lesson_test(library, "fetch", {})
    assert (seen.is_passing, len(seen.properties), seen.affected) == (True, 1, ())
    broken = library.with_automaton(TrainedAutomaton(SITS))
    seen = run_lesson_test(broken, "fetch", {"goto": TrainedAutomaton(goto)})
    assert not seen.is_passing
    assert [each.since for each in seen.failed] == [("goto",)]
    seen = run_lesson_test(broken, "goto", {"goto": TrainedAutomaton(goto)})
    assert (seen.is_passing, seen.changed, seen.affected) == (True, True, ("fetch",))
    (said,) = find_regressions(library, TrainedAutomaton(SITS), TrainedAutomaton(goto))
    assert said == "fetch no longer has the property: done is raised within 60 s in forage"
    assert find_regressions(library, TrainedAutomaton(goto), TrainedAutomaton(goto)) == ()
    assert find_regressions(library, TrainedAutomaton(goto), None) == ()


def test_what_coordinators_promised_is_tried_with_what_everybody_knows() -> None:
    """Their own change, or one of their robots: told only where it is known what everybody knows."""
    known = dict(collect_libraries(SCENARIO, ROBOTS, lambda name, kit: Library.from_automata(kit, lead())))
    lesson = new_lesson(
        known["patrol"], "out", states=["wander"], flags=["done"], features=["all_done"], live=False
    )
    made = Session(make_coordinator_body(SCENARIO, "patrol", known), known["patrol"], lesson)
    made.direct("wander")
    made.run_for(1.0)
    made.direct("done")
    made.tick()
    add_moment_property(made, flag="done", within_s=3.0)
    former = made.make_trained_automaton()
    made.delete(max(example.number for example in made.examples))
    coordinators = known["patrol"]
    assert find_regressions(coordinators, made.make_trained_automaton(), former) == ()
    assert find_regressions(coordinators, made.make_trained_automaton(), former, known) == (
        "out no longer has the property: done is raised within 3 s in patrol",
    )
    known["patrol"] = coordinators.with_automaton(former)
    wander = ROBOTS.taught["wander"]
    unbound = TrainedAutomaton(replace(wander.automaton, parameters=("A",)))
    assert find_regressions(ROBOTS, unbound, wander) == ()
    assert find_regressions(ROBOTS, unbound, wander, known) == (
        "patrol/out no longer has the property: done is raised within 3 s in patrol",
    )
    assert find_regressions(ROBOTS, wander, wander, known) == ()


def test_above_and_below() -> None:
    def runs(name: str, *behaviors: str) -> Automaton:
        return Automaton(name, (START, *(State(each, each, Binding()) for each in behaviors)))

    library = Library.from_automata(
        FORAGE_KIT, runs("a", "forward"), runs("b", "a"), runs("c", "a", "b"), runs("d")
    )
    assert list_dependents(library, "a") == ("b", "c")
    assert list_dependencies(library, "c") == ("c", "b", "a")
    assert list_dependents(library, "d") == ()


def test_a_classifier_that_was_fitted_to_the_same_is_the_same() -> None:
    """Whatever was promised meanwhile, and whoever sits in quarantine."""
    lesson = goto_lesson()
    scikit = replace(
        lesson, options=LearnerOptions(learner=SklearnOptions("KNeighborsClassifier", {"n_neighbors": 1}))
    )
    former, now = (TrainedAutomaton(learn_automaton(each), each) for each in (scikit, replace(scikit)))
    assert former.automaton != now.automaton, "each is fitted for itself"
    held = replace(scikit.examples[-1], number=99, quarantined="slipped")
    more = replace(scikit, examples=(*scikit.examples, held))
    less = replace(scikit, examples=scikit.examples[:-1])
    for other, expected in (
        (now, False),
        (TrainedAutomaton(learn_automaton(more), more), False),
        (TrainedAutomaton(learn_automaton(less), less), True),
    ):
        library = Library.from_automata(FORAGE_KIT).with_automaton(other)
        assert run_lesson_test(library, "goto", {"goto": former}).changed is expected


def test_properties_in_words() -> None:
    start = StoredMoment("forage", "", b"")
    one = Property(kind=PropertyKind.ALWAYS, what="done is raised", seconds=5.0, start=start)
    assert str(one) == "done is raised within 5 s in forage"
    assert (
        str(replace(one, targets=Binding(A="station"))) == "done is raised within 5 s in forage, A = station"
    )
