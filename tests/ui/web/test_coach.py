"""The coach through messages: advice and its places, questions and their answers, marks, the reaction time."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from threading import Event
from typing import Any

import pytest
from tests.make.goto_sessions import make_goto_session as goto_lesson
from tests.make.studios import GOTO, Page, make_studio, open_page, serve_studio, to_json
from tests.ui.web.test_lesson import step

from understudy.addons.checks.verification.finding import FindingKind
from understudy.coaching.give_advice import give_advice
from understudy.learning.fit import learn
from understudy.model.learner_options import LearnerOptions
from understudy.model.library import Library
from understudy.sim.catalog import find_scenario
from understudy.sim.forage import FORAGE_KIT
from understudy.sim.world import World
from understudy.training.lesson_design import new_lesson
from understudy.training.reaction_time import ReactionEstimate
from understudy.ui.controller import coach as coaching
from understudy.ui.controller.coach import AdviceReport
from understudy.ui.controller.lesson_check import check_lesson
from understudy.ui.controller.trainer import Trainer
from understudy.ui.web.actions import coach as coach_actions
from understudy.ui.web.server import StudioServer

PRESSES = ("rotate_left", "forward", "rotate_left", "forward")


@pytest.fixture(autouse=True)
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """A studio that waits for the coach's report."""
    monkeypatch.setattr(coach_actions, "PATIENCE_S", 60.0)


@pytest.fixture
def server(tmp_path: Path) -> StudioServer:
    """A studio whose world moves only when told."""
    return make_studio(tmp_path / "library", seed=4)


@pytest.fixture
def person(server: StudioServer) -> Iterator[Page]:
    """Somebody who has pressed four times, and let time stand still."""
    with serve_studio(server) as client, open_page(client) as person:
        person.done(**GOTO)
        person.done("pause", paused=True)
        for state in PRESSES:
            person.done("press", state=state)
            for _ in range(12):
                step(person)
        yield person


def ready(person: Page) -> dict[str, Any]:
    """What the coach answers, for which the studio waits here as long as it takes."""
    answer = person.done("request_advice")
    assert not answer.get("later")
    return answer


def request_advice(person: Page) -> list[dict[str, Any]]:
    """Its advice."""
    return list(ready(person)["advice"])


def sentences(person: Page) -> list[str]:
    """What the coach says."""
    return [each["sentence"] for each in request_advice(person)]


def test_a_lesson_without_presses_says_so(server: StudioServer) -> None:
    with serve_studio(server) as client, open_page(client) as person:
        assert "No automaton is open" in person.say("request_advice")["error"].capitalize()
        person.done(**GOTO)
        assert sentences(person)[0].startswith("You showed me nothing yet")
        assert ready(person)["reaction"] is None


def test_a_switch_that_is_undone_at_once_is_found_beside_the_advice(server: StudioServer) -> None:
    with serve_studio(server) as client, open_page(client) as person:
        person.done(**GOTO)
        person.done("pause", paused=True)
        assert ready(person)["findings"] == []
        for state in ("rotate_left", "forward", "rotate_left"):
            person.done("press", state=state)
            step(person)
        (found,) = ready(person)["findings"]
        assert not found["error"]
        assert found["sentence"].startswith("forward and rotate_left undo each other where ")
        assert found["sentence"].endswith(": forward → rotate_left → forward, at every tick.")
        assert found["remedy"].startswith("Put the robot into forward there")
        assert found["assumptions"] == [
            "readings of this cell occur: whether the world gives them is not decided here"
        ]


def test_findings_that_the_coach_states_are_left_out() -> None:
    """Nothing leads to the state left, and nothing leaves forward: the coach says both."""
    lesson = goto_lesson(
        (("start", "forward", "directive", 6.0, 10), ("forward", "forward", "default", 6.0, 10))
    )
    transitions, library, body = learn(lesson), Library(FORAGE_KIT), World(find_scenario("forage"))
    advice = give_advice(lesson, transitions, kit=FORAGE_KIT)
    all_found = check_lesson(lesson, transitions, library, body)
    assert [(each.kind, each.states) for each in all_found] == [
        (FindingKind.NEVER_ENTERED, ("left",)),
        (FindingKind.NEVER_ENTERED, ("done",)),
        (FindingKind.NEVER_LEFT, ("forward",)),
    ]
    assert check_lesson(lesson, transitions, library, body, advice=advice) == ()
    assert check_lesson(goto_lesson(()), {}, library, body) == ()


def test_advice_with_a_place_is_set_up(person: Page, server: StudioServer) -> None:
    given = request_advice(person)
    weights = [each["weight"] for each in given]
    assert weights == sorted(weights, reverse=True)
    chosen = next(each for each in given if each["can_set_up"] and "behind you" in each["sentence"])
    state = chosen["sentence"].split("in state ")[1].split(" ")[0]
    person.done("pause", paused=False)
    taught = server.host.active_trainer.session_view.examples
    run = server.host.run.number
    answer = person.done("set_up", sentence=chosen["sentence"])
    assert answer["sentence"] == f"The situation is set up in state {state}: show me what to do."
    trainer = server.host.active_trainer
    assert (trainer.session_view.state, trainer.session_view.examples, server.host.paused) == (
        state,
        taught,
        True,
    )
    assert 2.3 < trainer.session_view.features["angle_to(A)"] < 4.0
    assert server.host.run.number == answer["run"] == run + 1  # one cannot go back beyond
    person.done("press", state="rotate_right")
    step(person)
    assert chosen["sentence"] not in sentences(person)
    assert "out of date" in person.say("set_up", sentence=chosen["sentence"])["error"]


def test_what_cannot_be_set_up_is_said(server: StudioServer) -> None:
    """A robot that carries nothing cannot be made to carry much."""
    carry: dict[str, Any] = {"do": "new", "name": "carry", "states": ["forward", "rotate_left"], "flags": []}
    with serve_studio(server) as client, open_page(client) as person:
        person.done(**carry, features=["food_stored", "angle_to(station)"])
        person.done("pause", paused=True)
        for number, state in enumerate((*PRESSES, *PRESSES)):
            person.done("press", state=state)
            for _ in range(3):
                step(person)
            person.done("edit", number=2 * number + 1, values={"food_stored": str(number)})
        given = request_advice(person)
        full = next(
            each for each in given if each["can_set_up"] and "food_stored is above" in each["sentence"]
        )
        answer = person.done("set_up", sentence=full["sentence"])
        assert answer["sentence"] == "Not fully set up: food_stored differs from the suggestion."


def test_who_looks_on_hears_the_advice_and_may_not_follow_it(server: StudioServer) -> None:
    with serve_studio(server) as client, open_page(client) as person, open_page(client) as other:
        person.done(**GOTO)
        (few, *_) = request_advice(other)
        assert few["kind"] == "few"
        for message in (
            {"do": "set_query_policy", "policy": "mark"},
            {"do": "set_up", "sentence": few["sentence"]},
        ):
            assert "not in control" in other.send(message)["error"]


def test_advice_is_asked_for_again_only_when_the_lesson_changed(person: Page, server: StudioServer) -> None:
    edition = person.news["session"]["edition"]
    for _ in range(3):
        step(person)
    assert person.news["session"]["edition"] == edition
    person.done("undo")
    while person.news["session"]["edition"] == edition:
        person.hear()
    coach = server.host.active_trainer.coach
    assert coach.advice() is coach.advice()


def test_a_large_lesson_is_looked_over_beside_the_world(
    person: Page, server: StudioServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    go = Event()
    monkeypatch.setattr(coach_actions, "PATIENCE_S", 0.0)
    monkeypatch.setattr(
        coaching, "give_advice", lambda *all, **named: go.wait(60) and give_advice(*all, **named)
    )
    for _ in range(2):
        answer = person.done("request_advice")
        assert answer["later"]
        assert "advice" not in answer
    step(person)
    go.set()
    server.host.beside.in_turn.submit(lambda: None).result(60)
    assert person.done("request_advice")["advice"]


def run_until_question(person: Page) -> dict[str, Any]:
    """Let the robot try until it asks."""
    for _ in range(400):
        step_or_ask(person)
        question: dict[str, Any] | None = person.news["session"]["queries"]["question"]
        if question is not None:
            return question
    raise AssertionError("it did not ask")


def step_or_ask(person: Page) -> None:
    """One tick, or a question instead."""
    person.done("step")
    person.wait_for_news()


def test_the_press_is_the_answer_and_it_goes_on_by_itself(person: Page, server: StudioServer) -> None:
    person.done("set_query_policy", policy="pause")
    person.done("toggle_mode")
    question = run_until_question(person)
    assert question["sentence"].startswith("I am not sure: I would ")
    trainer = server.host.active_trainer
    known, state, now = len(trainer.session.examples), trainer.session_view.state, trainer.body.time_s
    there = trainer.session.capture()
    assert server.host.paused
    person.done("press", state="rotate_right")
    view = trainer.session_view
    new = trainer.session.examples[known:]
    assert (new[0].state, new[0].next, new[0].correction) == (state, "rotate_right", True)
    assert (view.mode.value, view.state, server.host.paused) == ("testing", "rotate_right", False)
    assert trainer.body.time_s == pytest.approx(now + 0.1)
    assert trainer.coach.question is None
    trainer.session.rewind(there)
    trainer.session.tick()
    assert trainer.session.view().state == "rotate_right"  # that was learned
    person.done("pause", paused=True)
    person.done("undo")
    assert len(trainer.session.examples) == known


def test_a_question_is_of_one_situation(person: Page, server: StudioServer) -> None:
    person.done("set_query_policy", policy="pause")
    person.done("toggle_mode")
    run_until_question(person)
    person.done("move_robot", agent=0, x=5.0, y=5.0)
    trainer = server.host.active_trainer
    assert trainer.coach.question is None
    person.done("press", state="rotate_right")
    assert (trainer.session_view.waiting, trainer.session_view.mode.value, server.host.paused) == (
        "rotate_right",
        "training",
        True,
    )


@pytest.mark.parametrize("way", ["carry on", "keep"])
def test_carrying_on_records_nothing_and_keeping_confirms(
    person: Page, server: StudioServer, way: str
) -> None:
    person.done("set_query_policy", policy="pause")
    person.done("toggle_mode")
    run_until_question(person)
    trainer = server.host.active_trainer
    known, state = len(trainer.session.examples), trainer.session_view.state
    if way == "keep":
        person.done("confirm")
        (new,) = trainer.session.examples[known:]
        assert (new.state, new.next, new.kind.value) == (state, state, "confirmation")
    else:
        person.done("pause", paused=False)
        assert len(trainer.session.examples) == known
    assert (trainer.coach.question, trainer.session_view.mode.value, server.host.paused) == (
        None,
        "testing",
        False,
    )


def test_at_any_speed_it_stands_still_at_the_question(person: Page, server: StudioServer) -> None:
    """Ticks that were due together are not taken any more."""
    person.done("set_query_policy", policy="pause")
    person.done("speed", speed=16)
    person.done("toggle_mode")
    trainer, wall = server.host.active_trainer, server.host.wall
    person.done("pause", paused=False)
    for _ in range(100):
        wall.now += 0.2  # type: ignore[attr-defined]  # the tests' clock
        server.run_due_ticks()
        if server.host.paused:
            break
    assert trainer.coach.question is not None
    assert trainer.body.time_s == trainer.coach.question.time_s


def test_marks_are_gone_back_to_and_vanish_once_answered(person: Page, server: StudioServer) -> None:
    person.done("set_query_policy", policy="mark")
    person.done("toggle_mode")
    began = server.host.world.time_s
    for _ in range(60):
        step(person)
    marks = to_json(server.host.session_data())["queries"]["marks"]
    assert [mark["run"] for mark in marks] == [server.host.run.number] * len(marks)
    first = marks[0]
    assert first["time_s"] == pytest.approx(began)
    person.done("go_to_mark", number=first["number"])
    trainer = server.host.active_trainer
    assert (server.host.world.time_s, server.host.paused) == (first["time_s"], True)
    assert trainer.coach.question is not None
    assert trainer.coach.question.sentence == first["sentence"]
    person.done("press", state="rotate_right")
    left = to_json(server.host.session_data())["queries"]["marks"]
    assert first["number"] not in [mark["number"] for mark in left]
    assert "moment 99 is no longer marked" in person.say("go_to_mark", number=99)["error"]


def test_marks_of_another_run_are_gone_back_to(person: Page, server: StudioServer) -> None:
    person.done("set_query_policy", policy="mark")
    person.done("toggle_mode")
    for _ in range(60):
        step(person)
    number, run = to_json(server.host.session_data())["queries"]["marks"][0]["number"], server.host.run.number
    person.done("reset", seed=9)
    person.done("go_to_mark", number=number)
    assert (server.host.seed, server.host.run.number) == (4, run + 2)
    assert server.host.active_trainer.coach.question is not None


def test_what_was_left_by_going_back_is_in_no_run(person: Page, server: StudioServer) -> None:
    person.done("set_query_policy", policy="mark")
    person.done("toggle_mode")
    began = server.host.world.time_s
    for _ in range(60):
        step(person)
    before = to_json(server.host.session_data())["queries"]["marks"]
    assert len(before) > 1
    person.done("rewind", time_s=began + 0.5)
    step(person)
    after = {mark["number"]: mark["run"] for mark in to_json(server.host.session_data())["queries"]["marks"]}
    assert after[before[0]["number"]] == before[0]["run"]
    assert after[before[-1]["number"]] is None


def test_how_it_asks_stays_from_one_lesson_to_the_next(person: Page) -> None:
    person.done("set_query_policy", policy="mark")
    person.done(**{**GOTO, "name": "other", "discard": True})
    assert person.wait_for_news()["session"]["queries"] == {"policy": "mark", "question": None, "marks": []}


def test_a_reaction_time_is_offered_taken_and_undone(
    person: Page, server: StudioServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = ReactionEstimate(0.55, 0.4, 0.7, 9, "Taken 0.55 s earlier, they agree.")
    monkeypatch.setattr(coaching, "estimate_reaction_time", lambda lesson, *, steady: found)
    person.done("edit", number=1, next="forward")
    late = ready(person)["reaction"]
    said = "You seem to react within 0.45 s. Taken 0.55 s earlier, they agree."  # and the tick of 0.1 s
    assert late == {"reaction_s": 0.45, "sentence": said}
    person.done("set_reaction_time", reaction_s=0.45)
    assert server.host.active_trainer.session.lesson.options.reaction_s == 0.45
    assert ready(person)["reaction"] is None
    person.done("undo")
    assert server.host.active_trainer.session.lesson.options.reaction_s == 0.0
    assert ready(person)["reaction"] is not None
    assert "reaction_s is 7" in person.say("set_reaction_time", reaction_s=7)["error"]


def test_unlearning_is_chosen_among_the_options(server: StudioServer) -> None:
    with serve_studio(server) as client, open_page(client) as person:
        person.done(**GOTO, unlearning=True)
        assert person.wait_for_news()["session"]["unlearning"] is True
        chosen = {key: GOTO[key] for key in ("states", "features", "flags")}
        person.done("change_design", **chosen)
        assert server.host.active_trainer.session.lesson.options.unlearning
        person.done("change_design", **chosen, unlearning=False)
        assert not server.host.active_trainer.session.lesson.options.unlearning


def test_a_press_that_looks_like_a_slip_is_asked_about_once(person: Page, server: StudioServer) -> None:
    """Eight times it turned where A was to the left and went on where it was ahead; once the wrong button was hit."""
    trainer = server.host.active_trainer
    trainer.session.quarantine(
        dict.fromkeys((each.number for each in trainer.session.examples), "in the way")
    )
    for far, angle, says in [*((far, 1.5, "rotate_left") for far in (3, 3.3, 3.6, 3.9)), (3.4, 1.6, "done")]:
        add_example(trainer, "forward", (far, angle), says)
    for far in (0.2, 0.25, 0.3):
        add_example(trainer, "forward", (far, 0.1), "done")
    odd = [each for each in request_advice(person) if each["kind"] == "slip"]
    assert [each["slip"] for each in odd] == [{"state": "forward", "next": "done"}]
    (number, *_) = odd[0]["examples"]
    person.done("confirm_press", number=number)
    assert "slip" not in [each["kind"] for each in request_advice(person)]
    assert "not in question" in person.say("confirm_press", number=number)["error"]
    person.done("correct_slip", number=number, next="rotate_left")
    assert next(each.next for each in trainer.session.examples if each.number == number) == "rotate_left"
    assert "no state 'fly'" in person.say("correct_slip", number=number, next="fly")["error"]


def add_example(trainer: Trainer, state: str, values: tuple[float, float], says: str) -> None:
    """An example as if it had been shown just so."""
    session = trainer.session
    session.direct(state)
    session.tick()
    session.direct(says)
    session.tick()
    number = next(
        each.number for each in reversed(session.examples) if (each.state, each.next) == (state, says)
    )
    session.edit(number, values=dict(zip(("distance_to(A)", "angle_to(A)"), values, strict=True)))
    trainer.refresh_view()


def test_taught_live_a_press_answers_and_live_teaching_goes_on(server: StudioServer) -> None:
    with serve_studio(server) as client, open_page(client) as person:
        person.done(**{**GOTO, "live": True})
        person.done("pause", paused=True)
        person.done("set_query_policy", policy="pause")
        question = run_until_question(person)
        assert (question["answers"][0], server.host.active_trainer.session_view.mode.value) == (
            "start",
            "live",
        )
        person.done("press", state="forward")
        view = server.host.active_trainer.session_view
        assert (view.mode.value, view.state, server.host.paused) == ("live", "forward", False)


def test_taught_live_it_marks_where_it_is_unsure_unless_somebody_chose_otherwise(
    server: StudioServer,
) -> None:
    with serve_studio(server) as client, open_page(client) as person:

        def asks_when(name: str, **options: Any) -> str:
            person.done(**{**GOTO, "name": name, **options}, discard=True)
            return server.host.active_trainer.coach.asking.when.value

        assert asks_when("one", live=True) == "mark"
        assert asks_when("two") == "never"
        person.done("set_query_policy", policy="pause")
        assert asks_when("three", live=True) == asks_when("four") == "pause"


def test_an_answer_can_be_undone_and_then_there_is_nothing_to_undo(server: StudioServer) -> None:
    with serve_studio(server) as client, open_page(client) as person:
        person.done(**{**GOTO, "live": True})
        person.done("pause", paused=True)
        person.done("set_query_policy", policy="pause")
        run_until_question(person)
        person.done("press", state="forward")
        session = server.host.active_trainer.session
        assert [each.next for each in session.examples] == ["forward", "forward"]  # and by default it stays
        person.done("undo")
        assert session.examples == ()
        assert person.say("undo")["error"].startswith("there is nothing to undo: ")


def test_skipping_pauses_where_the_person_is_needed(server: StudioServer) -> None:
    with serve_studio(server) as client, open_page(client) as person:
        person.done(**{**GOTO, "live": True})
        person.done("pause", paused=False)
        person.done("press", state="forward")
        person.done("skip")
        trainer = server.host.active_trainer
        assert server.host.paused
        assert "s later. I am not sure: " in trainer.status.text
        assert trainer.coach.question is not None
        began = trainer.body.time_s
        person.done("skip")  # it may do what it said
        assert trainer.body.time_s > began
        assert trainer.session_view.examples == 2


def test_in_training_nothing_is_skipped(person: Page) -> None:
    assert "nothing happens without you" in person.say("skip")["error"]


def test_it_goes_to_where_an_answer_matters_most(server: StudioServer) -> None:
    with serve_studio(server) as client, open_page(client) as person:
        person.done(**{**GOTO, "live": True})
        assert person.say("next_situation")["error"] == "nothing was taught yet: press a state first"
        person.done("press", state="forward")
        person.done("step")
        trainer, before = server.host.active_trainer, server.host.active_trainer.seed
        person.done("next_situation")
        assert server.host.paused
        assert trainer.seed != before
        assert trainer.seed in server.host.seen_seeds
        assert "an answer here matters most. I am not sure: " in trainer.status.text
        question = trainer.coach.question
        assert question is not None
        shown = trainer.session_view.examples
        person.done("press", state=question.answers[1])
        assert trainer.session_view.examples > shown
        assert trainer.coach.question is None


REACTIONS = [  # what presses agree at, its bounds, what the lesson has; what is offered
    (0.45, (0.4, 0.6), 0.3, None),  # somebody who reacts within 0.3 s, and a tick
    (0.5, (0.4, 0.6), 0.3, None),
    (0.7, (0.5, 0.8), 0.3, 0.6),
    (0.7, (0.3, 0.8), 0.3, None),  # it may be what the lesson has
    (0.45, (0.4, 0.6), 0.0, 0.35),
    (0.1, (0.0, 0.2), 0.3, 0.0),
]


@pytest.mark.parametrize(("found_s", "within", "has_s", "offered_s"), REACTIONS)
def test_a_reaction_time_is_offered_where_it_is_another(
    found_s: float, within: tuple[float, float], has_s: float, offered_s: float | None
) -> None:
    lesson = new_lesson(
        Library(FORAGE_KIT),
        "go",
        states=["forward"],
        features=["at_station"],
        options=LearnerOptions(reaction_s=has_s),
    )
    found = ReactionEstimate(found_s, *within, 20, "They agree.")
    assert AdviceReport(lesson, (), found, tick_s=0.1).new_reaction_s == offered_s
