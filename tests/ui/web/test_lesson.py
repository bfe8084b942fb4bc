"""A whole lesson through messages alone, and what it leaves in the library's folder."""

from __future__ import annotations

import json
from math import pi, tau
from pathlib import Path

import pytest
from tests.make.studios import GOTO, Page, make_studio, open_page, serve_studio


def choose_direction(page: Page) -> str | None:
    """What a robot on its way to A should do, from the frame alone; None where it has said that it is there."""
    assert page.frame is not None
    state = page.news["session"]["states"][page.frame.state]["name"]
    distance, angle = page.frame.features
    bearing = (angle + pi) % tau - pi
    if distance < 0.4:
        return None if state == "done" else "done"
    if state.startswith("rotate"):
        turned = bearing if state == "rotate_left" else -bearing
        return "forward" if turned < 0.12 else state
    if abs(bearing) > 0.6:
        return "rotate_left" if bearing > 0 else "rotate_right"
    return "forward"


def step(page: Page) -> None:
    """One tick, and its frame."""
    assert page.frame is not None
    before = page.frame.tick
    page.done("step")
    while page.frame.tick == before:
        page.hear()


def guide(page: Page, *, limit: int = 600) -> int:
    presses = 0
    for _ in range(limit):
        assert page.frame is not None
        state = page.news["session"]["states"][page.frame.state]["name"]
        right = choose_direction(page)
        if right is None:
            return presses
        if right != state:
            page.done("press", state=right)
            presses += 1
        step(page)
    raise AssertionError("not there")


def test_goto_from_an_empty_library(tmp_path: Path) -> None:
    folder = tmp_path / "library"
    with serve_studio(make_studio(folder)) as client, open_page(client) as person:
        assert person.hello["has_control"]
        assert not person.news["session"]
        person.done(**GOTO)
        person.done("pause", paused=True)
        for seed in range(4):
            person.done("reset", seed=seed)
            while person.news["seed"] != seed or person.frame is None or person.frame.tick:
                person.hear()
            guide(person)
        person.done("reset", seed=5)
        while person.news["seed"] != 5:
            person.hear()
        taught = person.news["session"]["presses"]
        person.done("press", state="forward")
        step(person)
        assert person.news["session"]["presses"] == taught + 1 + 1  # with its default
        person.done("undo")
        while person.news["session"]["presses"] != taught:
            person.hear()
        assert person.news["session"]["presses"] == taught
        assert {(edge["from"], edge["to"]) for edge in person.news["session"]["edges"]} >= {
            ("forward", "done"),
            ("rotate_left", "forward"),
        }
        person.done("toggle_mode")
        person.done("reset", seed=11)
        while person.news["session"]["mode"] != "testing" or person.news["seed"] != 11:
            person.hear()
        for _ in range(900):
            step(person)
            if person.news["session"]["flag"]:
                break
        assert person.news["session"]["flag"] == "done"
        assert not folder.joinpath("goto.json").exists()
        person.done("save")
        while person.news["session"]["unsaved"]:
            person.hear()
        assert [row["name"] for row in person.news["library"]["trained"]] == ["goto"]
    document = json.loads((folder / "goto.json").read_text())
    assert document["automaton"]["name"] == "goto"
    assert sorted(path.name for path in folder.iterdir()) == [".journals", "goto.json"]


def test_a_lesson_begins_with_its_options(tmp_path: Path) -> None:
    with serve_studio(make_studio(tmp_path)) as client, open_page(client) as teacher:
        teacher.done(**GOTO, watched=True, reaction_s=0.2)
        session = teacher.wait_for_news()["session"]
        assert (session["watched"], session["reaction_s"], session["examples"]) == (True, 0.2, [])


def test_back_to_a_moment_and_on_from_there(tmp_path: Path) -> None:
    """The world and the automaton go back, the lesson stays; what is done again comes out the same."""
    with serve_studio(make_studio(tmp_path / "library")) as client, open_page(client) as person:
        person.done(**GOTO)
        person.done("pause", paused=True)
        person.done("reset", seed=1)
        person.done("press", state="forward")
        frames: list[object] = []
        for _ in range(12):
            step(person)
            assert person.frame is not None
            frames.append(person.frame.robots)
        taught = person.news["session"]["presses"]
        person.done("rewind", time_s=0.5)
        while person.frame is None or person.frame.tick != 5:
            person.hear()
        assert person.frame.robots == frames[4]
        for expected in frames[5:]:
            step(person)
            assert person.frame.robots == expected
        assert person.news["session"]["presses"] == taught
        number = person.news["session"]["examples"][0]["number"]
        person.done("rewind", example=number)
        assert "no example 10000" in person.say("rewind", example=10_000)["error"]
        assert "neither or both" in person.say("rewind", example=number, time_s=1.0)["error"]


def test_back_to_an_example_of_another_run(tmp_path: Path) -> None:
    """As long as the session is the same, also where it was cut off; the lesson of before has no moments."""
    with serve_studio(make_studio(tmp_path)) as client, open_page(client) as person:
        person.done(**GOTO)
        person.done("pause", paused=True)
        person.done("reset", seed=1)
        for state in ("forward", "rotate_left"):
            person.done("press", state=state)
            for _ in range(6):
                step(person)
        assert person.frame is not None
        turned = person.frame.robots
        person.done("rewind", time_s=0.6)
        person.done("press", state="rotate_right")
        step(person)
    made = make_studio(tmp_path)
    with serve_studio(made) as client, open_page(client) as person:
        person.done("open", name="goto")
        person.done("reset", seed=2)
        person.done("rewind", example=3)
        assert made.host.seed == 1
        assert made.host.world.time_s == pytest.approx(0.6)
        assert made.host.active_trainer.session_view.state == "forward"
        person.done("press", state="rotate_left")
        while person.frame is None or person.frame.tick != 6:
            person.hear()
        for _ in range(6):
            step(person)
        assert person.frame.robots == turned
        person.done("save")
        person.done("open", name="goto")
        assert "example 3 is not from this session" in person.say("rewind", example=3)["error"]


def test_an_example_is_edited(tmp_path: Path) -> None:
    """States and values; these are written as they are shown."""
    with serve_studio(make_studio(tmp_path)) as client, open_page(client) as person:
        person.done(**GOTO)
        person.done("pause", paused=True)
        person.done("press", state="forward")
        step(person)
        person.done(
            "edit", number=1, state="rotate_left", values={"angle_to(A)": "−31", "distance_to(A)": ""}
        )
        first = person.wait_for_news()["session"]["examples"][0]
        assert (first["state"], first["next"], first["values"]) == ("rotate_left", "forward", ["–", "−31°"])


@pytest.mark.parametrize("ticks_after", [0, 7])
def test_cut_off_after_going_back(tmp_path: Path, ticks_after: int) -> None:
    """The lesson is whole, and the world as at the last snapshot, which going back takes."""
    with serve_studio(make_studio(tmp_path)) as client, open_page(client) as person:
        person.done(**GOTO)
        person.done("pause", paused=True)
        for state in ("forward", "rotate_left", "forward"):
            person.done("press", state=state)
            for _ in range(8):
                step(person)
        person.done("rewind", time_s=1.0)
        while person.frame is None or person.frame.time_s > 1.05:
            person.hear()
        there = person.frame
        for _ in range(ticks_after):
            step(person)
    with serve_studio(make_studio(tmp_path)) as client, open_page(client) as person:
        person.done("open", name="goto")
        while not person.news["session"] or person.frame is None or not person.frame.bits & 4:
            person.hear()
        session = person.news["session"]
        assert [each["number"] for each in session["examples"]] == [1, 2, 3, 4, 5, 6]
        assert (session["undoable"], session["state"]) == ("rotate_left → forward", "rotate_left")
        assert (person.frame.time_s, person.frame.robots) == (there.time_s, there.robots)
        person.done("press", state="done")
        step(person)
        person.done("save")


def test_a_press_after_the_end_says_how_to_go_on(tmp_path: Path) -> None:
    """It records nothing; who wanted something else is told what to do."""
    made = make_studio(tmp_path)
    with serve_studio(made) as client, open_page(client) as person:
        person.done(**GOTO)
        person.done("pause", paused=True)
        for state in ("forward", "done", "forward"):
            person.done("press", state=state)
            step(person)
        said = made.host.status.text
        assert said.startswith("done → forward; nothing recorded: goto had ended with done")
        assert "next press teaches again" in said
        assert "go back to before done" in said


def test_a_flag_that_is_added_has_a_name(tmp_path: Path) -> None:
    with serve_studio(make_studio(tmp_path)) as client, open_page(client) as person:
        person.done(**GOTO)
        design = {"states": GOTO["states"], "features": GOTO["features"]}
        assert (
            "'1' cannot be the name of a flag"
            in person.say("change_design", **design, flags=["done", "1"])["error"]
        )
        person.done("change_design", **design, flags=["done", "lost"])
