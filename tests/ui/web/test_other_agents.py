"""What the other robots do meanwhile, and whether somebody watches."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.make.studios import GOTO, Page, Wall, make_studio, open_page, serve_studio, teach, to_json

from understudy.ui.web.server import StudioServer


@pytest.fixture
def server(tmp_path: Path) -> StudioServer:
    return make_studio(tmp_path / "library", world="forage-team")


@pytest.fixture
def person(server: StudioServer) -> Iterator[Page]:
    with serve_studio(server) as client, open_page(client) as here:
        here.done(**GOTO)
        here.done("pause", paused=True)
        yield here


def places(made: StudioServer) -> list[tuple[float, float]]:
    robots = made.host.world.view().robots
    return list(zip(robots.x.tolist(), robots.y.tolist(), strict=True))


def test_the_others_idle_or_run_a_behavior(server: StudioServer, person: Page) -> None:
    before = places(server)
    person.done("step")
    assert places(server) == before
    person.done("set_other_agents", behavior="forward")
    for _ in range(5):
        person.done("step")
    moved = [now != then for now, then in zip(places(server), before, strict=True)]
    assert moved == [False, *[True] * (len(before) - 1)]
    assert to_json(server.host.session_data())["others"] == {"behavior": "forward", "targets": {}}
    there = places(server)
    person.done("set_other_agents", behavior=None)
    person.done("step")
    assert places(server) == there
    assert to_json(server.host.session_data())["others"] is None


def test_the_others_run_what_was_just_saved(server: StudioServer, person: Page) -> None:
    teach(person, "forward")
    assert "goto" in person.say("set_other_agents", behavior="goto", targets={"A": "station"})["error"]
    person.done("save")
    person.done("set_other_agents", behavior="goto", targets={"A": "station"})
    assert server.host.status.text == "The other robots run goto(station) meanwhile"
    before = places(server)
    person.done("step")
    assert places(server)[1:] != before[1:]
    person.done("open", name="goto")
    assert to_json(server.host.session_data())["others"] is None


WRONG = [
    ("fly", {}, "no behavior 'fly'"),
    ("goto", {}, "need targets for A"),
    ("forward", {"A": "station"}, "need no targets"),
    ("goto", {"A": "moon"}, "no target 'moon'"),
]


@pytest.mark.parametrize(("behavior", "targets", "said"), WRONG)
def test_what_the_others_cannot_do(
    server: StudioServer, person: Page, behavior: str, targets: dict[str, str], said: str
) -> None:
    teach(person, "forward")
    person.done("save")
    person.done("set_other_agents", behavior="forward")
    assert said in person.say("set_other_agents", behavior=behavior, targets=targets)["error"]
    assert to_json(server.host.other_behavior) == {"behavior": "forward", "targets": {}}
    before = places(server)
    person.done("step")
    assert places(server)[1:] != before[1:]


def test_one_robot_has_no_company(tmp_path: Path) -> None:
    with serve_studio(make_studio(tmp_path)) as client, open_page(client) as person:
        assert "No automaton is open" in person.say("set_other_agents", behavior=None)["error"].capitalize()
        person.done(**GOTO)
        assert "one robot" in person.say("set_other_agents", behavior="forward")["error"]


def test_nobody_watches(server: StudioServer, person: Page) -> None:
    assert "presses only" in person.say("toggle_watching")["error"]
    person.done("change_design", states=["forward", "rotate_left"], features=["angle_to(A)"], watched=True)
    teach(person, "forward")
    for watching, state in ((False, "rotate_left"), (True, "forward")):
        person.done("toggle_watching")
        for _ in range(60):
            person.done("step")
        teach(person, state)
        session = to_json(server.host.session_data())
        kinds = [each["kind"] for each in session["examples"]]
        assert (session["watching"], "watched" in kinds) == (watching, watching)


def test_after_a_kill_the_others_go_on_and_who_did_not_watch_still_does_not(tmp_path: Path) -> None:
    folder = tmp_path / "library"
    with serve_studio(make_studio(folder, world="forage-team")) as client, open_page(client) as person:
        person.done(**GOTO)
        person.done("pause", paused=True)
        person.done(
            "change_design", states=["forward", "rotate_left"], features=["angle_to(A)"], watched=True
        )
        teach(person, "forward")
        person.done("set_other_agents", behavior="rotate_left")
        person.done("set_other_agents", behavior="forward")
        person.done("toggle_watching")
    made = make_studio(folder, world="forage-team")
    with serve_studio(made) as client, open_page(client) as person:
        person.done("open", name="goto")
        session = to_json(made.host.session_data())
        assert session["others"] == {"behavior": "forward", "targets": {}}
        assert not session["watching"]
        before = places(made)
        person.done("step")
        assert all(now != then for now, then in zip(places(made)[1:], before[1:], strict=True))


def test_others_that_the_library_has_no_more_idle_after_a_kill(tmp_path: Path) -> None:
    folder = tmp_path / "library"
    with serve_studio(make_studio(folder, world="forage-team")) as client, open_page(client) as person:
        person.done(**{**GOTO, "name": "reach"})
        person.done("pause", paused=True)
        teach(person, "forward")
        person.done("save")
        person.done(**GOTO)
        person.done("pause", paused=True)
        teach(person, "forward")
        person.done("set_other_agents", behavior="reach", targets={"A": "station"})
    (folder / "reach.json").unlink()
    made = make_studio(folder, world="forage-team")
    with serve_studio(made) as client, open_page(client) as person:
        person.done("open", name="goto")
        assert to_json(made.host.session_data())["others"] is None
        person.done("step")


def test_robots_are_counted_as_they_are_drawn(server: StudioServer, person: Page) -> None:
    """The page writes 1 beside the first of them."""
    person.done("select_agent", agent=1)
    assert server.host.status.text == "Training goto with robot 2 now"
    teach(person, "forward")
    assert "from robot 2" in person.say("select_agent", agent=0)["error"]
    x, y = places(server)[3]
    error = person.say("move_robot", agent=1, x=x, y=y)["error"]
    assert "place of robot 2" in error
    assert "overlaps robot 4" in error
    assert (
        "is (-1.52, 0.35, 0.4)"
        in person.say("add_obstacle", x=-1.516483516483, y=0.35164835, radius=0.4)["error"]
    )


def test_the_robot_is_chosen_before_the_lesson(tmp_path: Path) -> None:
    made = make_studio(tmp_path / "library", world="forage-team")
    with serve_studio(made) as client, open_page(client) as here:
        here.done("select_agent", agent=2)
        assert made.host.status.text == "Robot 3 will be trained"
        here.done(**GOTO)
        assert made.host.active_trainer.robot == 2


def test_time_before_a_lesson(tmp_path: Path) -> None:
    """It stands still until somebody lets it go; robots idle, and a lesson begins in the world as it is then."""
    wall = Wall()
    made = make_studio(tmp_path, world="patrol", wall=wall)
    host = made.host
    with serve_studio(made) as client, open_page(client) as person:
        assert person.news["paused"]
        person.done("step")
        assert host.world.time_s == pytest.approx(host.world.tick_s)
        person.done("pause", paused=False)
        before = host.world.view().robots.x.tolist()
        wall.now += 0.2
        host.run_due_ticks()
        assert host.world.time_s == pytest.approx(0.2 + host.world.tick_s)
        assert host.world.view().robots.x.tolist() == before
        person.done("speed", speed=2.0)
        wall.now += 0.2
        host.run_due_ticks()
        assert host.world.time_s == pytest.approx(0.6 + host.world.tick_s)
        person.done("pause", paused=True)
        wall.now += 0.2
        host.run_due_ticks()
        assert host.world.time_s == pytest.approx(0.6 + host.world.tick_s)
