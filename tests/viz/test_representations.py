"""Every value in one line, and as notebooks show it: well-formed, small, and safe whatever its names are."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from tests.ui.cli.forage_parts import AUTOMATA, goto

from understudy.judging.evaluation import Evaluation
from understudy.judging.outcomes import Outcomes
from understudy.model.automaton import START, Automaton, State
from understudy.model.diff import diff_automata
from understudy.model.features import BoundFeature, Feature
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.tree import Tree, make_leaf
from understudy.model.value_kinds import Continuous
from understudy.runtime.engine.engine import Engine
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import link
from understudy.runtime.run_loop import Run
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.sim.scenario.files import load_scenario
from understudy.sim.team.libraries import collect_libraries, make_team
from understudy.sim.world import World
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session

LIBRARY = Library.from_automata(FORAGE_KIT, *AUTOMATA)
NAUGHTY = '<img src="x" onerror="alert(1)"> & $x$'
"""A name that would run a script if it were not escaped."""
FEATURE = BoundFeature(Feature(NAUGHTY, Continuous(), reading="range", unit="m"))
ODD = Automaton(
    NAUGHTY,
    (START, State(NAUGHTY, "forward"), State("on")),
    (FEATURE,),
    transitions={"start": Tree((make_leaf(1),))},
)
ODD_LESSON = Lesson(
    replace(ODD, transitions={}),
    tuple(Example(at, NAUGHTY, (float(at),), "on", ExampleKind.DIRECTIVE) for at in range(40)),
)
ODD_TAUGHT = TrainedAutomaton(ODD, ODD_LESSON)
COLUMN = np.ones(2)
RESULT = Evaluation(
    NAUGHTY,
    "forage",
    (1, 2),
    Outcomes(np.array([3.0, np.nan]), 9 * COLUMN, COLUMN.astype(int), COLUMN.astype(int)),
    None,
)
WORLD = Forage([1])
PROGRAM = link(LIBRARY, "forage")
LESSON = new_lesson(
    LIBRARY, "mine", states=["forward", "goto=goto(station)"], features=["distance_to(station)"]
)
TEAM_SCENARIO = load_scenario("patrol")
TEAM_LIBRARIES = collect_libraries(
    TEAM_SCENARIO, {kind: Library(World(TEAM_SCENARIO).kit) for kind in TEAM_SCENARIO.types}
)

VALUES: dict[str, Any] = {
    "automaton": goto,
    "automaton with an odd name": ODD,
    "trained automaton": ODD_TAUGHT,
    "tree": goto.transitions["forward"],
    "lesson": ODD_LESSON,
    "example": ODD_LESSON.examples[3],
    "record": ODD_LESSON.record,
    "kit": FORAGE_KIT,
    "library": LIBRARY,
    "odd library": Library(FORAGE_KIT, {NAUGHTY: ODD_TAUGHT}),
    "evaluation": RESULT,
    "difference": diff_automata(TrainedAutomaton(goto), ODD_TAUGHT),
    "world": WORLD,
    "many worlds": Forage(range(100, 200)),
    "run": Run.from_program(WORLD, PROGRAM),
    "engine": Engine.from_program(WORLD, PROGRAM),
    "interpreter": Interpreter(PROGRAM),
    "session": Session(Forage([1]), LIBRARY, LESSON),
}

SAID = {
    "automaton": "<Automaton 'goto(A)': 5 states, 2 features>",
    "tree": "<Tree of depth 3: 4 leaves>",
    "library": "<Library with 5 basic behaviors: 4 automata goto, harvest, deposit, forage>",
    "record": "<ReadingLog of 0 moments: 0 readings>",
    "world": "<Forage of 'forage': 1 robot in 1 world, seed 1>",
    "many worlds": "<Forage of 'forage': 1 robot in 100 worlds, seeds 100, 101, 102, …, 199>",
    "run": "<Run of 1 agent: on a Forage, at 0.0 s>",
    "engine": "<Engine of 1 agent: on a Forage, at 0.0 s>",
    "interpreter": "<Interpreter in start>",
    "session": "<Session of 'mine': live mode, in state start, 0 examples, at 0.0 s>",
    "evaluation": f"<Evaluation of {NAUGHTY!r} in forage: success in 1 of 2 worlds>",
}


@pytest.mark.parametrize("name", VALUES)
def test_a_value_is_one_short_line(name: str) -> None:
    line = repr(VALUES[name])
    assert "\n" not in line
    assert len(line) <= 120
    assert line.startswith("<")
    assert line.endswith(">")


@pytest.mark.parametrize("name", SAID)
def test_a_line_says_what_matters(name: str) -> None:
    assert repr(VALUES[name]) == SAID[name]


def test_a_long_line_is_cut() -> None:
    line = repr(Automaton("long " * 50))
    assert len(line) == 120
    assert line.endswith("…>")


def test_teams_are_one_short_line_too() -> None:
    team = make_team(TEAM_SCENARIO, [1], TEAM_LIBRARIES, {})
    assert repr(team) == "<Team of 4 robots: 1 squad, on a World>"


@pytest.mark.parametrize("name", [name for name, value in VALUES.items() if hasattr(value, "_repr_html_")])
def test_cards_are_well_formed_and_small(name: str) -> None:
    html = VALUES[name]._repr_html_()
    ElementTree.fromstring(html)
    assert "<img" not in html
    assert len(html) < 12_000
    assert not re.search(
        r"(?<!-)color:(?!inherit)|background:(?!none)", html
    )  # those of the page: light or dark


@pytest.mark.parametrize("name", [name for name, value in VALUES.items() if hasattr(value, "_repr_svg_")])
def test_pictures_are_well_formed(name: str) -> None:
    svg = VALUES[name]._repr_svg_()
    ElementTree.fromstring(svg.encode())
    assert "<img" not in svg


def test_every_value_that_was_asked_for_is_shown() -> None:
    shown = {
        name
        for name, value in VALUES.items()
        if hasattr(value, "_repr_html_") or hasattr(value, "_repr_svg_")
    }
    assert shown >= {
        "automaton", "trained automaton", "lesson", "library", "evaluation", "difference", "world", "run", "session",
    }  # fmt: skip


def rows(html: str) -> list[list[str]]:
    return [["".join(cell.itertext()) for cell in row] for row in ElementTree.fromstring(html).iter("tr")]


def test_a_lesson_shows_some_examples_and_how_many_more() -> None:
    html = ODD_LESSON._repr_html_()
    assert rows(html)[:2] == [
        ["#", "state", "next", "kind", NAUGHTY],
        ["0", NAUGHTY, "on", "directive", "0.00 m"],
    ]
    assert len(rows(html)) == 9
    assert "and 32 more" in html
    assert "40 directives" in html


def test_a_session_shows_where_it_is() -> None:
    html = VALUES["session"]._repr_html_()
    assert "▸ start" in html
    assert rows(html)[1][0] == "distance_to(station)"
    assert rows(html)[1][1].endswith(" m")


def test_an_evaluation_shows_its_interval() -> None:
    html = RESULT._repr_html_()
    assert "success 50 % (95 % interval 1 to 99 %)" in html
    assert rows(html)[1][1:] == ["1 of 2 worlds", "3.0 s", "3.0 s"]


def test_a_library_shows_its_automata() -> None:
    assert [row[0] for row in rows(LIBRARY._repr_html_())] == [
        "automaton",
        "goto(A)",
        "harvest",
        "deposit",
        "forage",
    ]


def test_a_run_shows_what_its_agents_do() -> None:
    many = Run.from_program(Forage(range(12)), link(LIBRARY, "forage"))
    many.tick()
    html = many._repr_html_()
    assert rows(html)[1] == ["0", "harvest > goto > " + many.path(0)[2]]
    assert "and 4 more" in html


def test_an_evaluation_shows_its_goal_and_its_metrics() -> None:
    shown = replace(RESULT, goal="at_station", metrics={"way": np.array([2.0, 4.0])})._repr_html_()
    assert "judged by at_station" in shown
    assert "way 3 in the median" in shown
    assert "judged by the goal of the scenario" in RESULT._repr_html_()
