"""What is in training, tried in unseen worlds beside the one on the page: the rate, the failures, and who ends it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np
import pytest
from tests.make.studios import GOTO, Page, make_studio, open_page, serve_studio
from tests.ui.cli.commands import run_json

from understudy.judging.evaluate import evaluate
from understudy.judging.evaluation import Evaluation
from understudy.judging.intervals import interval_of_share
from understudy.judging.rollout import Progress
from understudy.ui.controller.beside import make_threads
from understudy.ui.web.server import StudioServer
from understudy.ui.web.unseen_worlds import UnseenWorldsEvaluation
from understudy.ui.web.views import lesson_test

OTHER = {**GOTO, "name": "other", "discard": True}


@pytest.fixture
def person(server: StudioServer) -> Iterator[Page]:
    """Somebody who has shown a goto that turns until A is ahead, drives on, and is done after a while."""
    with serve_studio(server) as client, open_page(client) as here:
        here.done(**GOTO)
        teach(here, server)
        yield here


def teach(person: Page, made: StudioServer) -> None:
    person.done("pause", paused=True)
    for state, *readings in (
        ("rotate_left", ("5 m", "90°"), ("5 m", "90°")),
        ("forward", ("5 m", "0°"), ("1 m", "0°")),
        ("done", ("0.3 m", "0°")),
    ):
        known = len(made.host.active_trainer.session.examples)
        person.done("press", state=state)
        person.done("step")
        new = made.host.active_trainer.session.examples[known:]  # the press, and that it stays so for now
        for example, values in zip(new, readings, strict=True):
            person.done(
                "edit", number=example.number, values=dict(zip(GOTO["features"], values, strict=True))
            )


def read_evaluation(person: Page) -> dict[str, Any] | None:
    """What the page is shown of the evaluation; None where there is none."""
    session = person.news["session"]
    return None if session is None else session.get("evaluation")


def wait_for_result(person: Page) -> dict[str, Any]:
    """What came of it."""
    while (found := read_evaluation(person)) is None or (found["result"] is None and not found["problem"]):
        person.wait_for_news()
    return found


def evaluate_and_wait(person: Page, **fields: Any) -> dict[str, Any]:
    """Try it; what came of it."""
    person.done("evaluate", **fields)
    result: dict[str, Any] = wait_for_result(person)["result"]
    person.done("cancel_evaluation")
    return result


@pytest.fixture
def held_evaluations(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Event, Event]]:
    """Evaluations that are at the third world until the first event is set; the second is, once one has ended."""
    let_go, over = Event(), Event()

    def evaluate_slowly(*given: Any, progress: Progress, **more: Any) -> Evaluation:
        try:
            while not let_go.wait(0.001):
                progress(3, 5)
            return evaluate(*given, progress=progress, **more)
        finally:
            over.set()

    monkeypatch.setattr(lesson_test, "evaluate", evaluate_slowly)
    yield let_go, over
    let_go.set()


def test_the_rate_is_that_of_eval_on_the_same_worlds(person: Page, server: StudioServer) -> None:
    result = evaluate_and_wait(person)
    library = lesson_test._present(server.host)
    judged = evaluate(library, "goto", "forage", range(1000, 1100), binding={"A": "station"})
    failed = [seed for seed, done in zip(judged.seeds, judged.taught.finished, strict=True) if not done]
    assert 0 < len(failed) < 100
    assert result == {
        "success": "done within 1800 s",
        "succeeded": 100 - len(failed),
        "interval": list(interval_of_share(100 - len(failed), 100)),
        "first": 1000,
        "last": 1099,
        "failed": [{"seed": seed, "problem": "not done after 1800 s"} for seed in failed],
        "raised": "done counts wherever it is raised: nothing shown says where it is right",
        "leaves_shown": False,
    }
    assert evaluate_and_wait(person) == result
    person.done("save")
    of_goto = ("--behavior", "goto", "--bind", "A=station", "--seeds", "1000:1100")
    told = run_json("eval", "-l", server.host.library_view.folder, *of_goto)
    assert (told["success"], told["failed_seeds"]) == ((100 - len(failed)) / 100, failed)


def test_in_testing_it_does_in_a_world_what_it_did_when_it_was_tried_there(
    person: Page, server: StudioServer
) -> None:
    library = lesson_test._present(server.host)
    seconds = evaluate(library, "goto", "forage", range(1000, 1040), binding={"A": "station"}).taught.seconds
    quickest = int(np.nanargmin(seconds))
    person.done("toggle_mode")
    person.done("reset", seed=1000 + quickest)
    while server.host.active_trainer.session_view.flag is None:
        person.done("step")
    assert server.host.world.time_s == pytest.approx(seconds[quickest])


def test_worlds_that_were_on_the_page_are_left_out(person: Page) -> None:
    for seed in (1001, 1003):
        person.done("reset", seed=seed)
    result = evaluate_and_wait(person, count=4)
    assert (result["first"], result["last"]) == (1000, 1005)
    assert not {each["seed"] for each in result["failed"]} & {1001, 1003}


def test_the_first_hundred_failures_are_listed(person: Page, server: StudioServer) -> None:
    last = server.host.active_trainer.session.examples[-1]
    assert last.next == "done"
    person.done("delete", number=last.number)
    result = evaluate_and_wait(person, count=120)
    assert result["succeeded"] <= 20
    assert len(result["failed"]) == 100


def test_what_has_no_flag_is_judged_by_the_goal(person: Page) -> None:
    person.done(**{**GOTO, "name": "drive", "flags": [], "discard": True})
    person.done("press", state="forward")
    person.done("step")
    result = evaluate_and_wait(person, count=2)
    assert result["success"] == "the goal of forage within 3 times the time of a hand-written controller"
    assert all(each["problem"].startswith("goal not reached after ") for each in result["failed"])
    assert result["succeeded"] == 0


@pytest.mark.parametrize("count", [0, 1001])
def test_a_number_of_worlds_that_makes_no_sense(person: Page, count: int) -> None:
    error = person.say("evaluate", count=count)["error"]
    assert error == f"the studio: number of worlds is {count}; give one from 1 to 1000"
    assert read_evaluation(person) is None


@pytest.mark.parametrize("count", [-1, 4.5, "many"])
def test_a_number_of_worlds_that_is_none(person: Page, count: Any) -> None:
    error = person.say("evaluate", count=count)["error"]
    assert error == "The count is not a whole number of 0 or more. Nothing was changed"


def test_what_cannot_be_tried_is_said(server: StudioServer) -> None:
    with serve_studio(server) as client, open_page(client) as person:
        assert "No automaton is open" in person.say("evaluate")["error"].capitalize()
        person.done(**GOTO)
        assert "there is nothing to test yet" in person.say("evaluate")["error"]


def test_without_a_goal_and_without_a_flag_nothing_says_what_success_is(tmp_path: Path) -> None:
    wander: dict[str, Any] = {
        "do": "new",
        "name": "wander",
        "states": ["forwards"],
        "features": ["time_in_state"],
        "flags": [],
    }
    with (
        serve_studio(make_studio(tmp_path / "library", world="patrol")) as client,
        open_page(client) as person,
    ):
        person.done(**wander)
        person.done("pause", paused=True)
        person.done("press", state="forwards")
        person.done("step")
        error = person.say("evaluate")["error"]
        said = "success is not defined: scenario patrol has no goal, and wander has no flag done, nor a single other"
        assert error == f"{said} one; choose what success means beside the score"
        person.done("change_design", states=["forwards"], features=["time_in_state"], flags=["done"])
        person.done("press", state="done")
        person.done("step")
        result = evaluate_and_wait(person, count=3)
        assert result["success"] == "done within 600 s"


def test_a_coordinator_is_not_tried(tmp_path: Path) -> None:
    with (
        serve_studio(make_studio(tmp_path / "library", world="patrol")) as client,
        open_page(client) as person,
    ):
        (sort, *_) = person.scene["squads"]
        person.done("select_agent", agent=0, sort=sort["name"])
        offered = person.news["library"]["basic"]
        person.done("new", name="lead", states=[offered[0]], features=["time_in_state"], flags=["done"])
        assert "coordinators cannot be tested" in person.say("evaluate")["error"]


def test_the_world_goes_on_and_what_is_tried_stays_as_it_was(
    person: Page, server: StudioServer, held_evaluations: tuple[Event, Event]
) -> None:
    let_go, _ = held_evaluations
    before = lesson_test._present(server.host)
    person.done("evaluate", count=5)
    while (found := read_evaluation(person)) is None or found["finished"] != 3:
        person.wait_for_news()
    assert (found["behavior"], found["worlds"], found["result"]) == ("goto(station)", 5, None)
    assert "already" in person.say("evaluate")["error"]
    person.done("reset", seed=1002)  # another world on the page
    tick = server.host.frame
    first = tick()
    person.done("step")
    assert tick() != first
    person.done("press", state="rotate_right")  # and another lesson
    person.done("step")
    let_go.set()
    found = wait_for_result(person)
    assert found["edition"] < person.news["session"]["edition"]
    judged = evaluate(before, "goto", "forage", range(1000, 1005), binding={"A": "station"})
    assert found["result"]["succeeded"] == judged.taught.finished.sum()
    while "succeeded in" not in person.news["message"]["text"]:
        person.wait_for_news()
    sentence = f"goto(station) succeeded in {found['result']['succeeded']} of 5 worlds"
    anywhere = "(done counts wherever it is raised: nothing shown says where it is right)"
    assert person.news["message"]["text"] == f"{sentence} {anywhere}"


@pytest.mark.parametrize("end", ["cancel_evaluation", "another session", "the studio"])
def test_it_ends_when_it_is_cancelled_and_with_its_session(
    person: Page, server: StudioServer, held_evaluations: tuple[Event, Event], end: str
) -> None:
    person.done("evaluate")
    actions: dict[str, Callable[[], object]] = {
        "cancel_evaluation": lambda: person.done("cancel_evaluation"),
        "another session": lambda: person.done(**OTHER),
        "the studio": server.host.close,
    }
    actions[end]()
    assert held_evaluations[1].wait(60)
    assert server.host.evaluation is None
    if end != "the studio":
        while read_evaluation(person) is not None:
            person.wait_for_news()
        if end == "cancel_evaluation":
            assert person.news["message"]["text"] == "Test cancelled"
            person.done("cancel_evaluation")  # there is none, which is no mistake


def test_who_looks_on_sees_it_and_may_not_begin_or_end_it(server: StudioServer) -> None:
    with serve_studio(server) as client, open_page(client) as person, open_page(client) as other:
        person.done(**GOTO)
        teach(person, server)
        person.done("evaluate", count=5)
        assert wait_for_result(other) == wait_for_result(person)
        for do in ("evaluate", "cancel_evaluation"):
            assert "not in control" in other.say(do)["error"]


def test_what_goes_wrong_in_a_world_is_said(person: Page, monkeypatch: pytest.MonkeyPatch) -> None:
    def evaluate_wrongly(*_: object, **__: object) -> Evaluation:
        raise ValueError("no more worlds")

    monkeypatch.setattr(lesson_test, "evaluate", evaluate_wrongly)
    person.done("evaluate")
    found = wait_for_result(person)
    assert (found["result"], found["problem"]) == (
        None,
        "internal error: ValueError: no more worlds",
    )
    while person.news["message"]["tone"] != "error":
        person.wait_for_news()
    person.done("evaluate")  # again, if one likes


def test_an_evaluation_that_is_cancelled_tells_nothing() -> None:
    """Not even that it has ended."""
    began, over = Event(), Event()

    def run(progress: Progress) -> Evaluation:
        began.set()
        try:
            while True:
                progress(1, 2)
        finally:
            over.set()

    running = UnseenWorldsEvaluation("goto", 1, {}, worlds=2, evaluate=run, beside=make_threads())
    assert began.wait(60)
    running.cancel()
    assert over.wait(60)
    assert running.is_running
    assert running.take_status() is None
