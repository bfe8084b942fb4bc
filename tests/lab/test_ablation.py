"""The ablation experiment: its people, its drawing leaves, its other features, and a teaching beside the published."""

from __future__ import annotations

import numpy as np
import pytest
from tests.make.lessons import make_lesson

from understudy.learning.fit import learn_automaton
from understudy.model.features import Percept, ReadingsView
from understudy.model.lesson import ExampleKind
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.tree import STAY
from understudy.sim.forage import FORAGE_KIT
from understudy.training.session import Session
from understudy_lab.ablation import study
from understudy_lab.ablation.evaluate import make_stochastic_automaton, name_chance_reading
from understudy_lab.ablation.variants import (
    ATTENTIVE_S,
    AWAY_S,
    BASE,
    SILENT,
    VARIANTS,
    Candid,
    Confirming,
    Inattentive,
    cosine_to,
    round_angle_to,
    signed_angle_to,
    sine_to,
)
from understudy_lab.forage.teach import make_practice
from understudy_lab.results import differences, load_published
from understudy_lab.runner import row_of
from understudy_lab.tasks.forage_teacher import GOTO
from understudy_lab.teachers.person import ReactionTime


@pytest.mark.retrains
def test_a_teaching_is_as_published() -> None:
    known = load_published("ablation")
    assert known is not None
    row = row_of(study.EXPERIMENT, {"variant": "defaults by hand, not watched", "seed": study.SEEDS[0]})
    assert differences([row], known, study.EXPERIMENT) == []


def test_every_variant_is_set_against_a_base() -> None:
    assert {variant.against for variant in VARIANTS.values()} == {BASE, SILENT}


# Leaves that draw


def test_leaves_draw_by_their_votes() -> None:
    shown = make_lesson(
        [
            ("go", [9], "go", "default"),
            ("go", [2], "load", "directive"),
            ("go", [2], "load", "directive"),
            ("go", [2], "go", "confirmation"),  # contradicts the two before
        ]
    )
    automaton = make_stochastic_automaton(TrainedAutomaton(learn_automaton(shown), shown), corrected=False)
    assert str(automaton.features[-1]) == name_chance_reading("lesson")
    decide = automaton.transitions["go"].decide
    go, load = automaton.index("go"), automaton.index("load")
    assert [decide([9, draw]) for draw in (0.0, 0.5, 0.99)] == [go, go, go]
    assert [decide([2, draw]) for draw in (0.0, 0.3, 0.34, 0.99)] == [
        go,
        go,
        load,
        load,
    ]  # declared: go, load


def test_corrected_votes_leave_a_chance_to_every_state() -> None:
    shown = make_lesson([("go", [9], "go", "default"), ("go", [2], "load", "directive")])
    automaton = make_stochastic_automaton(TrainedAutomaton(learn_automaton(shown), shown), corrected=True)
    decide = automaton.transitions["go"].decide
    start, go, load = range(3)
    assert [decide([2, draw]) for draw in (0.1, 0.3, 0.6)] == [start, go, load]  # 1, 1 and 2 of 4


def test_absence_never_shown_stays_whatever_is_drawn() -> None:
    shown = make_lesson([("go", [9], "go", "default"), ("go", [2], "load", "directive")])
    decide = (
        make_stochastic_automaton(TrainedAutomaton(learn_automaton(shown), shown), corrected=False)
        .transitions["go"]
        .decide
    )
    assert decide([float("nan"), 0.5]) == STAY


# People


def session() -> Session:
    library = Library(FORAGE_KIT)
    return Session(make_practice("an arena", 2**41), library, GOTO.choose(library), targets={"A": "station"})


PROMPT = ReactionTime(0.0, 0.0, 0.05)


def test_who_confirms_makes_an_example_of_staying() -> None:
    person, taught = Confirming(np.random.default_rng(1), PROMPT), session()
    person.show(
        taught,
        lambda view: "forward" if view.state == "start" else None,
        until=lambda view: view.time_s > 1.5,
        limit_s=3.0,
    )
    kinds = [example.kind for example in taught.examples]
    assert kinds == [ExampleKind.DIRECTIVE, ExampleKind.DEFAULT, ExampleKind.CONFIRMATION]
    assert person.presses == 2


@pytest.mark.parametrize("person", [Inattentive, Candid])
def test_who_looks_away_does_so_a_third_of_the_time(person: type[Inattentive]) -> None:
    watcher, taught = person(np.random.default_rng(2)), session()
    looking = []

    def until(screen: object) -> bool:
        looking.append(watcher._looking)
        assert taught.is_watching is (watcher._looking or person is Inattentive)
        return False

    watcher.show(taught, lambda view: None, until=until, limit_s=300.0)
    assert np.mean(looking) == pytest.approx(ATTENTIVE_S / (ATTENTIVE_S + AWAY_S), abs=0.15)


# Angles as other features


@pytest.mark.parametrize(
    ("bearing", "signed", "sine", "cosine"),
    [(0.0, 0.0, 0.0, 1.0), (np.pi / 2, np.pi / 2, 1.0, 0.0), (3 * np.pi / 2, -np.pi / 2, -1.0, 0.0)],
)
def test_angles_as_numbers(bearing: float, signed: float, sine: float, cosine: float) -> None:
    percept: Percept = {("bearing", "A"): np.array([bearing])}
    found = []
    for each in (signed_angle_to, round_angle_to, sine_to, cosine_to):
        assert each.function is not None
        found.append(float(each.function(ReadingsView(percept), ReadingsView(percept, "A"))[0]))
    assert found == pytest.approx([signed, bearing, sine, cosine])
