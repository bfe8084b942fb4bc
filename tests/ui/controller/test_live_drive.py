"""Drives under way: a scripted stick drives simulated robots, labels appear, and an automaton is learned."""

from __future__ import annotations

import json
from collections.abc import Callable
from math import pi
from pathlib import Path

import numpy as np
import pytest
from tests.inline_executor import InlineExecutor
from tests.own_worlds import NAME
from tests.ui.cli.commands import run_json

from understudy.addons.recordings.run_drives import choose_agent
from understudy.addons.recordings.segment import UNEXPLAINED
from understudy.errors import SessionError
from understudy.model.library import Library
from understudy.records.record import Record, find_places
from understudy.records.trace_reader import read_trace_records
from understudy.runtime.link import link
from understudy.runtime.run_loop import Run
from understudy.ui.cli.commands.studio_drive import make_drive_server
from understudy.ui.cli.studio_options import DrivingOptions
from understudy.ui.controller import live_drive
from understudy.ui.controller.live_drive import LiveDrive
from understudy.ui.controller.stick import AT_REST, StickPosition

AHEAD, BACK = StickPosition(0, 1), StickPosition(0, -1)
RIGHT, LEFT = StickPosition(1, 0), StickPosition(-1, 0)
Driver = Callable[[LiveDrive], StickPosition]


class Wall:
    """A clock that a test moves."""

    def __init__(self) -> None:
        self.now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


class Scripted:
    """A drive in a world, which a script advances by pictures of 1/60 s."""

    def __init__(self, folder: Path, *, world: str = "forage", features: str | None = None) -> None:
        options = DrivingOptions(scenario=world, seed=3, library=folder / "library", features=features)
        self.wall = Wall()
        server, self.files = make_drive_server(options, wall=self.wall)
        self.live = server.live

    def drive(self, driver: Driver, seconds: float) -> None:
        """Let a driver steer for some seconds, as a page does."""
        for _ in range(round(seconds * 60)):
            self.wall.now_s += 1 / 60
            self.live.steer(driver(self.live))
            self.live.advance()

    def be_silent(self, seconds: float) -> None:
        """Let time go on without a message of the page."""
        for _ in range(round(seconds * 60)):
            self.wall.now_s += 1 / 60
            self.live.advance()

    def pause(self) -> None:
        """Pause, and let the labels be found."""
        self.live.pause()
        for _ in range(3):
            self.live.advance()
        assert self.live.is_current

    @property
    def spans(self) -> list[tuple[str, int, int]]:
        found = self.live.find_review().segmentation
        return [
            (each.label, each.first, each.end)
            for episode in found.drive.episodes
            for each in found.list_spans(episode)
        ]


@pytest.fixture(autouse=True)
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Labels are found at once, in the same thread."""
    monkeypatch.setattr(live_drive, "ThreadPoolExecutor", InlineExecutor)


@pytest.fixture
def scripted_drive(tmp_path: Path) -> Scripted:
    return Scripted(tmp_path)


def hold(stick: StickPosition) -> Driver:
    return lambda _: stick


class FoodDriver:
    """A driver who turns to the nearest food and goes there, a little to the left, which has to be corrected."""

    turns = True

    def __call__(self, live: LiveDrive) -> StickPosition:
        angle = float(live.percept["bearing", "nearest_food"][0])
        angle = (angle + pi) % (2 * pi) - pi
        if float(live.percept["range", "nearest_food"][0]) < 0.4:
            return AT_REST
        self.turns = abs(angle) > (0.08 if self.turns else 0.25)
        if self.turns:
            return LEFT if angle > 0 else RIGHT
        return StickPosition(-0.1, 0.95)


def test_labels_of_what_the_stick_did(scripted_drive: Scripted) -> None:
    """At 10 Hz, seconds of 10 ticks each."""
    scripted_drive.live.drive()
    for stick, seconds in ((AHEAD, 2), (RIGHT, 1), (AHEAD, 1.5), (LEFT, 1)):
        scripted_drive.drive(hold(stick), seconds)
    scripted_drive.pause()
    assert [label for label, _, _ in scripted_drive.spans] == [
        "forward",
        "rotate_right",
        "forward",
        "rotate_left",
    ]
    assert [first for _, first, _ in scripted_drive.spans] == pytest.approx([0, 20, 30, 45], abs=1)


def test_labels_appear_while_somebody_drives(scripted_drive: Scripted) -> None:
    scripted_drive.live.drive()
    scripted_drive.drive(hold(AHEAD), 5)
    assert scripted_drive.live.version >= 3
    assert scripted_drive.live.driving
    assert [label for label, _, _ in scripted_drive.spans] == ["forward"]
    with pytest.raises(SessionError, match="pause it"):
        scripted_drive.live.check_change()


def test_when_the_driver_switches_is_learned_at_a_pause(tmp_path: Path) -> None:
    """The features tell nothing while somebody drives, when labels are to come quickly."""
    scripted = Scripted(tmp_path, features="angle_to(nearest_food)")
    live = scripted.live
    live.drive()
    scripted.drive(FoodDriver(), 5)
    assert live.version >= 2
    assert live.find_review().segmentation.switches is None
    assert not live.is_current
    scripted.pause()
    assert live.find_review().segmentation.switches is not None


def test_behaviors_are_proposed_at_a_pause_only(scripted_drive: Scripted) -> None:
    """An arc is no behavior of the forager: half the turn and half the speed are unexplained, and proposed."""
    live = scripted_drive.live
    live.drive()
    scripted_drive.drive(hold(StickPosition(0.5, 0.5)), 2)
    assert live.find_review().list_proposals() == ()
    scripted_drive.drive(hold(StickPosition(0.5, 0.5)), 2)
    scripted_drive.pause()
    (proposal,) = live.find_review().list_proposals()
    assert set(proposal.command) == {"drive", "turn"}
    live.find_review().define_behavior("arc", proposal.command)
    live.drive()
    scripted_drive.drive(hold(AHEAD), 2)
    scripted_drive.pause()
    assert [label for label, _, _ in scripted_drive.spans] == ["arc", "forward"]


def test_the_world_waits_for_the_stick(scripted_drive: Scripted) -> None:
    live = scripted_drive.live
    live.drive()
    scripted_drive.drive(hold(StickPosition(0.05, 0.05)), 2)  # within the dead zone
    assert (live.waiting, live.ticks, live.world.time_s) == (True, 0, 0.0)
    scripted_drive.drive(hold(AHEAD), 1)
    assert not live.waiting
    assert live.ticks in (10, 11)


def test_at_rest_when_nothing_is_heard(tmp_path: Path) -> None:
    """The last message counts for 0.3 s: three ticks, or four of which one begins at once; patrol has a stop."""
    scripted = Scripted(tmp_path, world="patrol")
    scripted.live.drive()
    scripted.live.steer(AHEAD)
    scripted.be_silent(2)
    scripted.pause()
    drive = scripted.live.find_review().segmentation.drive
    moved = int((drive.commands[:, 0] != 0).sum())
    assert moved in (3, 4)
    assert drive.ticks >= 19
    assert not drive.commands[moved:].any()
    assert [label for label, _, _ in scripted.spans] == ["forwards", "stop"]


def test_the_world_waits_at_rest_where_no_behavior_rests(scripted_drive: Scripted) -> None:
    """Foragers have no stop: what nothing could explain is not driven."""
    live = scripted_drive.live
    live.drive()
    scripted_drive.drive(hold(AHEAD), 1)
    before = live.ticks
    scripted_drive.drive(hold(AT_REST), 3)
    assert (live.waiting, live.ticks) == (True, before)
    scripted_drive.drive(hold(BACK), 1)  # nor do they drive back
    assert (live.waiting, live.ticks) == (True, before)
    scripted_drive.drive(hold(RIGHT), 1)
    scripted_drive.pause()
    assert [label for label, _, _ in scripted_drive.spans] == ["forward", "rotate_right"]
    drive = live.find_review().segmentation.drive
    assert drive.commands.any(axis=1).all()
    assert np.diff(drive.times) == pytest.approx(0.1)


def test_what_was_set_by_hand_stays_when_the_drive_goes_on(scripted_drive: Scripted) -> None:
    live = scripted_drive.live
    live.drive()
    scripted_drive.drive(hold(AHEAD), 2)
    scripted_drive.pause()
    review = live.find_review()
    review.set_label(5, 8, "load_food")
    review.set_label(8, 12, UNEXPLAINED)
    live.drive()
    scripted_drive.drive(hold(RIGHT), 2)
    scripted_drive.pause()
    assert live.find_review() is review
    assert scripted_drive.spans == [
        ("forward", 0, 5), ("load_food", 5, 8), (UNEXPLAINED, 8, 12), ("forward", 12, 20),
        ("rotate_right", 20, live.ticks),
    ]  # fmt: skip
    assert np.flatnonzero(review.by_hand).tolist() == [*range(5, 12)]
    assert not review.can_undo


def test_another_world_is_another_episode(scripted_drive: Scripted) -> None:
    live = scripted_drive.live
    live.begin_world(4)  # nothing was driven in the first one
    live.drive()
    scripted_drive.drive(hold(AHEAD), 1)
    with pytest.raises(SessionError, match="pause first"):
        live.begin_world(5)
    scripted_drive.pause()
    first = live.ticks
    live.begin_world(5)
    live.drive()
    scripted_drive.drive(hold(LEFT), 1)
    scripted_drive.pause()
    episodes = live.find_review().segmentation.drive.episodes
    assert [(each.source, each.first, each.end) for each in episodes] == [
        ("seed 4", 0, first), ("seed 5", first, live.ticks),
    ]  # fmt: skip
    assert [label for label, _, _ in scripted_drive.spans] == ["forward", "rotate_left"]
    assert len(live.list_places()) == live.ticks


def test_a_body_of_ones_own(tmp_path: Path) -> None:
    """A cart at 3 m of a slope of 10 m: it is driven back and ahead, until its episode is over."""
    scripted = Scripted(tmp_path, world=f"{NAME}:make_slope")
    live = scripted.live
    assert live.layout.right is None
    live.drive()
    scripted.drive(hold(BACK), 1.9)
    scripted.drive(hold(AHEAD), 12)
    assert not live.driving
    assert "the episode is over" in live.error
    scripted.pause()
    assert [label for label, _, _ in scripted.spans] == ["back", "ahead"]
    assert np.isnan(live.list_places()).all()
    with pytest.raises(SessionError, match="begin a new world"):
        live.drive()
    live.begin_world(5)
    live.drive()
    assert live.error == ""
    scripted.drive(hold(AHEAD), 1.9)
    scripted.drive(hold(BACK), 2)
    scripted.pause()
    assert [label for label, _, _ in scripted.spans] == ["back", "ahead", "ahead", "back"]
    assert scripted.files.paths[0].name.startswith("tests.own_worlds-make_slope-")
    first, second = (read_kept(path) for path in scripted.files.paths)
    assert first.ticks + second.ticks == live.ticks
    assert second.values["x", None][0] == 5.0


def read_kept(path: Path) -> Record:
    return choose_agent(read_trace_records(path)[1], path)


def test_what_is_kept_is_what_was_driven(scripted_drive: Scripted, tmp_path: Path) -> None:
    """Each world has a trace of its own, from which `understudy learn` learns the same."""
    for seed in (3, 4):
        if seed != 3:
            scripted_drive.live.begin_world(seed)
        scripted_drive.live.drive()
        scripted_drive.drive(FoodDriver(), 12)
        scripted_drive.pause()
    drive = scripted_drive.live.find_review().segmentation.drive
    paths = scripted_drive.files.paths
    assert {*(tmp_path / "recordings").iterdir()} == {*paths}
    assert len(paths) == len(drive.episodes) == 2
    for path, episode in zip(paths, drive.episodes, strict=True):
        kept = read_kept(path)
        ticks = episode.ticks
        assert f"seed {kept.seed}" == episode.source
        np.testing.assert_allclose(kept.times, drive.times[ticks], atol=1e-6)
        np.testing.assert_array_equal(kept.commands, drive.commands[ticks])
        for key, column in drive.values.items():
            np.testing.assert_array_equal(kept.values[key], column[ticks])
        places = find_places(kept)
        assert places is not None
        np.testing.assert_allclose(places, scripted_drive.live.list_places()[ticks], atol=1e-6)
        assert [each.name for each in kept.channels] == [each.name for each in drive.channels]
        assert {each.name: (each.kind, each.unit) for each in kept.readings} == {
            each.name: (each.kind, each.unit) for each in drive.readings
        }
    found = run_json("learn", "--recording", paths[0], "--features", "angle_to(nearest_food)")
    assert {"forward"} < {each["label"] for each in found["drive"]["spans"]}
    assert json.loads(paths[0].read_text().splitlines()[0])["run"]["scenario"] == "forage"


def test_what_was_driven_is_learned(tmp_path: Path) -> None:
    """Driven to the food in four worlds, the automaton finds it in others, too."""
    scripted = Scripted(tmp_path, features="distance_to(nearest_food),angle_to(nearest_food)")
    live = scripted.live
    for seed in range(4):
        live.begin_world(seed)
        live.drive()
        scripted.drive(FoodDriver(), 25)
        scripted.pause()
    learned = live.find_review().learn()
    assert learned.agreement.share > 0.9
    near = 0
    for seed in range(100, 110):
        live.world.reset([seed])
        library: Library = learned.drive.library.with_automaton(learned.taught)
        near += go_by_itself(live, library)
    assert near >= 8


def go_by_itself(live: LiveDrive, library: Library) -> bool:
    """Run the learned automaton for 40 s; whether it comes to the food."""
    run = Run.from_program(live.world, link(library, "driven"))
    for _ in range(400):
        run.tick()
        if float(live.world.sense([("range", "nearest_food")])["range", "nearest_food"][0]) < 0.6:
            return True
    return False


def learn_to_find_food(scripted: Scripted) -> LiveDrive:
    """Drive to the food in three worlds, and learn from it."""
    live = scripted.live
    for seed in range(3):
        live.begin_world(seed)
        live.drive()
        scripted.drive(FoodDriver(), 25)
        scripted.pause()
    live.find_review().learn()
    return live


def test_the_automaton_drives_until_the_stick_is_moved(tmp_path: Path) -> None:
    """What it does by itself is not recorded; what follows a movement of the stick is another episode."""
    scripted = Scripted(tmp_path, features="distance_to(nearest_food),angle_to(nearest_food)")
    live = learn_to_find_food(scripted)
    live.begin_world(100)
    before, far = live.ticks, float(live.percept["range", "nearest_food"][0])
    live.let_automaton_drive()
    assert (live.automatic, live.driving) == (True, False)
    scripted.drive(hold(AT_REST), 8)
    assert float(live.percept["range", "nearest_food"][0]) < far - 1
    assert live.find_automaton_state() in ("forward", "rotate_left", "rotate_right")
    assert live.ticks == before
    for refused in (live.check_change, lambda: live.begin_world(101)):
        with pytest.raises(SessionError, match="pause"):
            refused()
    scripted.drive(hold(StickPosition(0.05, 0.05)), 1)  # within the dead zone
    assert live.automatic
    scripted.drive(hold(RIGHT), 2)
    assert (live.automatic, live.driving, live.find_automaton_state()) == (False, True, "")
    scripted.drive(hold(AHEAD), 1)
    scripted.pause()
    drive = live.find_review().segmentation.drive
    assert drive.ticks == live.ticks == pytest.approx(before + 30, abs=1)
    last = drive.episodes[-1]
    assert (last.source, last.first) == ("seed 100 from 9.0 s", before)
    assert drive.times[last.first] == pytest.approx(9.1)
    assert [label for label, first, _ in scripted.spans if first >= before] == ["rotate_right", "forward"]
    kept = read_kept(scripted.files.paths[-1])
    assert kept.ticks == live.ticks - before


def test_the_automaton_is_paused_and_driven_on(tmp_path: Path) -> None:
    scripted = Scripted(tmp_path, features="distance_to(nearest_food),angle_to(nearest_food)")
    with pytest.raises(SessionError, match="learn first"):
        scripted.live.let_automaton_drive()
    live = learn_to_find_food(scripted)
    live.let_automaton_drive()
    scripted.drive(hold(AT_REST), 1)
    live.pause()
    at = live.world.time_s
    scripted.drive(hold(AT_REST), 1)
    assert (live.automatic, live.world.time_s) == (False, at)
    count = len(live.find_review().segmentation.drive.episodes)
    live.drive()
    with pytest.raises(SessionError, match="pause first"):
        live.let_automaton_drive()
    scripted.drive(hold(LEFT), 1)
    scripted.pause()
    assert len(live.find_review().segmentation.drive.episodes) == count + 1
    with pytest.raises(SessionError, match="learn first"):
        live.let_automaton_drive()  # the labels are others now
