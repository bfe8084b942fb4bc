"""Real robots in the studio, over wires in memory: armed by a page, stopped by any, and where nobody looks."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import replace
from pathlib import Path
from threading import Event
from typing import Any, ClassVar

import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.make.studios import GOTO, Wall, to_json
from tests.robots.twins import Rig

from understudy.addons.recordings.teach_from_recording import list_recorded_presses, teach_from_recording
from understudy.records.reader import read_recording
from understudy.records.recorder import RunRecorder
from understudy.sim.kit import make_scenario_kit
from understudy.training.lesson_design import new_lesson
from understudy.training.trainee import Mode
from understudy.ui.controller.beside import make_threads
from understudy.ui.web.clients import PER_SECOND, Client
from understudy.ui.web.server import StudioServer
from understudy.ui.web.session_host import SessionHost

ARENA_GOTO = {**GOTO, "targets": {"A": "red_flag"}}
PATIENCE_S = 60.0


class NotedExecutor(ThreadPoolExecutor):
    """Threads for slow actions, whose work can be waited for."""

    begun: ClassVar[list[Future[Any]]] = []

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Begin some work, and note it."""
        future = super().submit(fn, *args, **kwargs)
        self.begun.append(future)
        return future


@pytest.fixture(autouse=True)
def note_slow_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """The work of slow actions is noted."""
    monkeypatch.setattr(NotedExecutor, "begun", [])


def wait_for_work() -> bool:
    """Wait until the work of a slow action has ended; return whether there was any left."""
    left = [each for each in NotedExecutor.begun if not each.done()]
    assert not left or wait(left, PATIENCE_S, FIRST_COMPLETED).done
    return bool(left)


class Lab:
    """A studio with one real robot, and a page that directs."""

    def __init__(
        self,
        folder: Path,
        recorder: RunRecorder | None = None,
        *,
        names: tuple[str, ...] = ("one",),
        world: str = "arena",
    ) -> None:
        self.rig, self.wall = Rig(names, world=world, recorder=recorder), Wall()
        twin = self.rig.twin
        host = SessionHost(
            twin.scenario,
            folder,
            make_scenario_kit(twin.scenario),
            wall=self.wall,
            ground=twin,
            beside=replace(make_threads(), at_once=NotedExecutor()),
        )
        self.studio = StudioServer(host, wall=self.wall)
        self.page = self.studio.connect(None)
        self.rig.send_odometry()

    def say(self, viewer: Client | None = None, **message: Any) -> dict[str, Any]:
        """Say something, and hear the answer."""
        viewer = viewer or self.page
        while viewer.next() is not None:
            pass
        self.studio.handle_text(viewer, json.dumps({"id": 7, **message}))
        return self.hear(viewer)

    def hear(self, viewer: Client, number: int = 7) -> dict[str, Any]:
        """Hear the answer, for which a slow action takes a while."""
        is_working = True
        while True:
            self.studio.answer_slow_actions()
            while (waiting := viewer.next()) is not None:
                text, binary = waiting
                if not binary and (answer := json.loads(text)).get("re") == number:
                    return dict(answer)
            assert is_working, "no answer"
            is_working = wait_for_work()

    def list_robots(self) -> list[dict[str, Any]]:
        """What the page is told of the robots."""
        robots: list[dict[str, Any]] = to_json(self.studio.host.robots.list_statuses())
        return robots

    def wait(self, seconds: float, *, here: bool = True) -> None:
        """Let time pass, a hundredth of a second at a time, with a page that is there or fell silent."""
        for _ in range(round(seconds * 100)):
            self.wall.now += 0.01
            self.rig.now += 0.01
            self.rig.send_odometry(self.rig.last)
            if here:
                self.studio.host.robots.refresh_heartbeat(holding=False)
            self.studio.run_due_ticks()

    def moves(self) -> bool:
        return self.rig.sent(0) != (0.0, 0.0)


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Lab]:
    made = Lab(tmp_path)
    yield made
    made.studio.host.close()


def teach_armed(lab: Lab) -> Lab:
    """A robot that is armed, and driven ahead by a press."""
    assert "error" not in lab.say(**ARENA_GOTO)
    assert "error" not in lab.say(do="arm")
    lab.say(do="pause", paused=False)
    lab.say(do="press", state="forward")
    lab.wait(0.3)
    assert lab.moves()
    return lab


def test_nothing_moves_before_a_person_arms_it(lab: Lab) -> None:
    lab.say(**ARENA_GOTO)
    lab.say(do="pause", paused=False)
    lab.say(do="press", state="forward")
    lab.wait(0.5)
    assert not lab.moves()
    assert lab.list_robots() == [{"name": "one", "armed": False, "stopped": "not armed"}]
    assert [each["kind"] for each in to_json(lab.studio.host.session_data())["examples"]] == [
        "directive",
        "default",
    ]


def test_armed_it_is_taught_as_a_simulated_one(lab: Lab) -> None:
    teach_armed(lab)
    assert lab.list_robots() == [{"name": "one", "armed": True, "stopped": ""}]
    features = lab.studio.host.active_trainer.session_view.features
    assert features["distance_to(A)"] == pytest.approx(2.0)


def test_paused_it_stands_and_stays_armed(lab: Lab) -> None:
    teach_armed(lab).say(do="pause", paused=True)
    lab.wait(0.2)
    assert not lab.moves()
    assert lab.list_robots()[0]["armed"]


@pytest.mark.parametrize("watching", [False, True])
def test_any_page_stops_it(lab: Lab, watching: bool) -> None:
    teach_armed(lab)
    viewer = lab.studio.connect(None) if watching else lab.page
    assert "error" not in lab.say(viewer, do="stop")
    assert not lab.moves()
    assert lab.list_robots()[0] == {
        "name": "one",
        "armed": False,
        "stopped": "emergency: stopped in the studio",
    }
    assert lab.studio.host.paused


def test_real_robots_are_not_tried_in_other_worlds(lab: Lab) -> None:
    error = teach_armed(lab).say(do="evaluate")["error"]
    assert error == "real robots cannot be tested in other worlds"
    assert lab.moves()


def test_a_page_that_only_watches_arms_nothing(lab: Lab) -> None:
    answer = lab.say(lab.studio.connect(None), do="arm")
    assert "not in control" in answer["error"]
    assert not lab.list_robots()[0]["armed"]


def test_it_stops_where_the_page_leaves(lab: Lab) -> None:
    teach_armed(lab)
    lab.studio.disconnect(lab.page)
    assert not lab.moves()
    assert lab.list_robots()[0]["stopped"] == "no page is in control in the studio"


def test_it_stops_where_the_page_falls_silent(lab: Lab) -> None:
    teach_armed(lab)
    lab.wait(0.5, here=False)
    assert lab.list_robots()[0]["armed"]
    lab.wait(0.3, here=False)
    assert not lab.moves()
    assert lab.list_robots()[0]["stopped"] == "the studio stopped responding"


def test_it_stops_where_the_page_is_loaded_again(lab: Lab) -> None:
    """Its connection was lost, though nobody has noticed yet."""
    teach_armed(lab)
    again = lab.studio.connect(lab.page.key)
    assert lab.studio.viewers.director is again
    assert not lab.moves()
    assert not lab.list_robots()[0]["armed"]


@pytest.fixture
def watchdog(lab: Lab, monkeypatch: pytest.MonkeyPatch) -> Iterator[Event]:
    """The watchdog of the robot starts when the event is set."""
    starts = Event()
    monkeypatch.setattr(lab.rig.robots[0], "prepare", lambda: starts.wait(PATIENCE_S))
    yield starts
    starts.set()


def test_the_time_that_arming_takes_is_no_silence(lab: Lab, watchdog: Event) -> None:
    lab.studio.handle_text(lab.page, json.dumps({"id": 7, "do": "arm"}))
    assert lab.studio.host.status.text == "Arming…"
    lab.wait(2.0)
    assert not lab.list_robots()[0]["armed"]
    watchdog.set()
    assert lab.hear(lab.page)["ok"]
    lab.wait(0.1)
    assert lab.list_robots()[0]["armed"]
    assert lab.studio.host.status.text.startswith("Armed")


CANCELS: dict[str, Callable[[Lab], object]] = {
    "the emergency stop": lambda lab: lab.say(do="stop"),
    "a stop from another page": lambda lab: lab.say(lab.studio.connect(None), do="stop_robot", name="one"),
    "control is handed over": lambda lab: lab.say(do="release_control"),
    "the page is closed": lambda lab: lab.studio.disconnect(lab.page),
    "the page is loaded again": lambda lab: lab.studio.connect(lab.page.key),
    "the page is silent": lambda lab: lab.wait(0.7, here=False),
}


@pytest.mark.parametrize("cancel", CANCELS)
def test_a_stop_while_it_is_armed_wins(lab: Lab, watchdog: Event, cancel: str) -> None:
    lab.studio.handle_text(lab.page, json.dumps({"id": 8, "do": "arm"}))
    CANCELS[cancel](lab)
    assert not watchdog.is_set()
    watchdog.set()
    answer = lab.hear(lab.page, 8)
    assert answer["error"] == "robot 'one' stays disarmed: it was stopped meanwhile; arm again"
    assert not lab.list_robots()[0]["armed"]
    assert not lab.moves()


def test_a_stop_between_the_arming_and_its_answer_is_not_said_to_be_armed(lab: Lab) -> None:
    lab.studio.handle_text(lab.page, json.dumps({"id": 8, "do": "arm"}))
    while not lab.list_robots()[0]["armed"]:
        assert wait_for_work()
    lab.studio.host.robots.stop("a key")
    assert "it was stopped meanwhile" in lab.hear(lab.page, 8)["error"]
    assert not lab.list_robots()[0]["armed"]


def test_what_was_read_before_arming_is_not_decided_on(lab: Lab, monkeypatch: pytest.MonkeyPatch) -> None:
    """Else its first tick would be a stop, and logged."""
    lab.say(**ARENA_GOTO)
    lab.say(do="pause", paused=False)
    lab.wait(0.3)
    robot = lab.rig.robots[0]
    arm = robot.arm

    def slowly(by: str, *, stop_count: int | None = None) -> None:
        lab.rig.now += 0.4
        arm(by, stop_count=stop_count)

    monkeypatch.setattr(robot, "arm", slowly)
    lab.say(do="arm")
    lab.say(do="press", state="forward")
    lab.wait(0.3)
    assert lab.moves()
    assert not lab.rig.robots[0].stops


def test_a_page_that_says_too_much_still_stops_it(lab: Lab) -> None:
    teach_armed(lab)
    answers = [lab.say(do="heartbeat", holding=False) for _ in range(PER_SECOND + 1)]
    assert "too many messages" in answers[-1]["error"]
    assert "error" not in lab.say(do="stop")
    assert not lab.list_robots()[0]["armed"]


REFUSED = [
    ({"do": "reset", "seed": 3}, "this body cannot be reset"),
    ({"do": "speed", "speed": 4}, "real robots run in real time; leave it at 1"),
    (
        {"do": "move_robot", "agent": 0, "x": 1.0, "y": 1.0, "heading": None},
        "real robots and objects cannot be moved",
    ),
    ({"do": "rewind", "time_s": 0.0}, "there is nothing to go back to yet"),
]


@pytest.mark.parametrize(("message", "said"), REFUSED)
def test_what_a_real_robot_cannot_do(lab: Lab, message: dict[str, Any], said: str) -> None:
    assert said in teach_armed(lab).say(**message)["error"]


def test_what_cannot_be_armed_says_why(lab: Lab) -> None:
    lab.rig.hear(0, lab.rig.odometry(9.0))
    assert "outside its geofence" in lab.say(do="arm")["error"]


def test_what_was_recorded_teaches_the_same_lesson_again(tmp_path: Path) -> None:
    path = tmp_path / "one.mcap"
    with RunRecorder(path) as recorder:
        lab = teach_armed(Lab(tmp_path / "library", recorder))
        lab.say(do="press", state="rotate_left")
        lab.wait(0.3)
        lab.say(do="confirm")
        lab.wait(0.3)
        lab.say(do="toggle_mode")
        lab.wait(0.3)
        lab.say(do="press", state="done")  # a correction
        lab.wait(0.3)
        session = lab.studio.host.active_trainer.session
        lab.studio.host.close()
    recording = read_recording(path)
    assert recording.head.ran.binding == {"A": "red_flag"}
    assert set(recording.head.files) == {"scenario"}
    empty = new_lesson(
        session.library,
        "goto",
        states=["forward", "rotate_left", "rotate_right"],
        features=["distance_to(A)", "angle_to(A)"],
        parameters=["A"],
        flags=["done"],
        live=False,
    )
    again = teach_from_recording(
        recording, session.library, empty, list_recorded_presses(recording), targets={"A": "red_flag"}
    )
    assert [str(each) for each in again.examples] == [str(each) for each in session.examples]
    assert len(again.examples) >= 4


def test_it_asks_waits_and_goes_on_with_the_answer(tmp_path: Path) -> None:
    """While it waits, it stands; the world goes on, and so does what it reads."""
    path = tmp_path / "one.mcap"
    with RunRecorder(path) as recorder:
        lab = teach_armed(Lab(tmp_path / "library", recorder))
        lab.say(do="press", state="rotate_left")
        lab.wait(0.3)
        lab.say(do="press", state="forward")
        lab.wait(0.3)
        lab.say(do="set_query_policy", policy="pause")
        lab.say(do="toggle_mode")
        session = lab.studio.host.active_trainer.session
        for tenths in range(1, 20):  # ever nearer to the flag
            lab.rig.hear(0, lab.rig.odometry(tenths / 10))
            lab.wait(0.2)
            if session.paused:
                break
        assert "What is right?" in lab.studio.host.status.text
        lab.wait(0.1)
        assert not lab.moves()
        known, state = len(session.examples), session.view().state
        lab.rig.hear(0, lab.rig.odometry(1.95))
        lab.wait(0.2)
        assert "error" not in lab.say(do="press", state="rotate_right")
        assert len(session.examples) == known + 2
        assert (session.examples[-2].state, session.examples[-2].correction) == (state, True)
        assert (session.mode, session.paused, session.view().state) == (Mode.TESTING, False, "rotate_right")
        assert lab.list_robots()[0]["armed"]
        lab.studio.host.close()
    assert [each.does for each in list_recorded_presses(read_recording(path))][-2:] == ["press", "resume"]


def test_of_several_sessions_the_last_is_recorded_as_one(tmp_path: Path) -> None:
    """Presses of another automaton would be none of its states."""
    path = tmp_path / "one.mcap"
    with RunRecorder(path) as recorder:
        lab = teach_armed(Lab(tmp_path / "library", recorder))
        other = {"name": "turns", "states": ["rotate_left"], "parameters": [], "targets": {}, "flags": []}
        answer = lab.say(**{**ARENA_GOTO, **other, "features": ["distance_to(red_flag)"], "discard": True})
        assert "error" not in answer
        lab.wait(0.3)
        assert not lab.moves()  # armed, and in its start state
        assert lab.list_robots()[0]["armed"]
        lab.say(do="press", state="rotate_left")
        lab.wait(0.3)
        assert lab.moves()
        lab.studio.host.close()
    recording = read_recording(path)
    assert recording.head.ran.binding == {}
    presses = list_recorded_presses(recording)
    assert [(each.does, each.state) for each in presses] == [("press", "rotate_left")]


def test_where_one_of_two_robots_falls_silent_the_other_goes_on(tmp_path: Path) -> None:
    lab = teach_armed(Lab(tmp_path, names=("one", "two")))
    for _ in range(80):
        lab.wall.now += 0.01
        lab.rig.now += 0.01
        lab.rig.hear(0, lab.rig.last)
        lab.studio.host.robots.refresh_heartbeat(holding=False)
        lab.studio.run_due_ticks()
    assert [each["armed"] for each in lab.list_robots()] == [True, False]
    assert lab.moves()
    assert "stays disarmed" in lab.say(do="arm")["error"]  # all, or none
    assert [each["armed"] for each in lab.list_robots()] == [False, False]
    lab.studio.host.close()


def test_a_place_beyond_all_places_breaks_nothing(lab: Lab) -> None:
    teach_armed(lab)
    lab.rig.hear(0, lab.rig.odometry(1e308))
    lab.wait(0.2)
    assert lab.list_robots() == [{"name": "one", "armed": False, "stopped": "outside its geofence"}]
    assert "broke" not in lab.studio.host.status.text


def test_where_the_recording_cannot_go_on_it_stops(tmp_path: Path) -> None:
    with RunRecorder(tmp_path / "one.mcap") as recorder:
        lab = teach_armed(Lab(tmp_path / "library", recorder))
        recorder._writer.problem = "no space left"
        lab.wait(0.2)
        assert not lab.moves()
        assert not lab.list_robots()[0]["armed"]
        assert "recording ended: no space left; free space" in lab.studio.host.status.text
        lab.studio.host.close()
        recorder._writer.problem = ""


def test_a_coordinator_of_real_robots_is_taught(tmp_path: Path) -> None:
    """Paper section 5.1, on four robots: who leads them is pressed from one order to the next."""
    lab = Lab(tmp_path, names=("one", "two", "three", "four"), world="patrol")
    assert "error" not in lab.say(do="select_agent", sort="patrol", agent=0)
    opened = lab.say(
        do="new",
        name="lead",
        states=["forwards", "left"],
        features=["none_sees(intruder)"],
        parameters=[],
        flags=[],
        targets={},
    )
    assert "error" not in opened, opened
    assert "error" not in lab.say(do="arm")
    lab.say(do="pause", paused=False)
    lab.wait(0.2)
    assert [lab.rig.sent(agent) for agent in range(4)] == [(0.0, 0.0)] * 4
    lab.say(do="press", state=lab.studio.host.active_trainer.session.automaton.state_names[1])
    lab.wait(0.3)
    assert [lab.rig.sent(agent) for agent in range(4)] == [(0.4, 0.0)] * 4
    lab.studio.host.close()
