"""One hand of the experiment on recordings beside what was published, and its drivers by hand."""

import numpy as np
import pytest

from understudy.addons.recordings.drive_kit import make_candidates
from understudy.addons.recordings.segment import segment
from understudy.model.features import Percept
from understudy.model.library import Library
from understudy.model.value_kinds import NO, YES
from understudy_lab.recordings import driven_foraging as forager
from understudy_lab.recordings import driven_foraging as foraging
from understudy_lab.recordings import driven_servoing as servoing
from understudy_lab.recordings import driven_walls as walls
from understudy_lab.recordings import study
from understudy_lab.recordings.drive_recording import Stick, StickSettings, draw_stick_settings, judge_labels
from understudy_lab.recordings.driven_goto import FORWARD, LEFT, RIGHT, WAIT, intend
from understudy_lab.results import differences, load_published
from understudy_lab.runner import row_of
from understudy_lab.tasks.soccer import SIZE, X, kit

STEADY = StickSettings(gain=0.8, noise=0.02, dead_ticks=0, overshoot=0.0, slowest=0.7)


@pytest.mark.retrains
@pytest.mark.parametrize("behavior", study.BEHAVIORS)
def test_the_first_is_as_published(behavior: str) -> None:
    known = load_published("recordings")
    assert known is not None
    seed = study.SEEDS[0] + study.BEHAVIORS[behavior].first_seed
    row = row_of(study.EXPERIMENT, {"behavior": behavior, "seed": seed})
    assert differences([row], known, study.EXPERIMENT) == []


INTENTS = [  # meant before, distance, bearing, meant after
    (WAIT, 3.0, 0.0, FORWARD),
    (WAIT, 3.0, 1.0, LEFT),
    (FORWARD, 3.0, -0.6, RIGHT),
    (FORWARD, 3.0, 0.4, FORWARD),
    (LEFT, 3.0, 0.4, LEFT),
    (LEFT, 3.0, 0.1, FORWARD),
    (RIGHT, 3.0, -0.1, FORWARD),
    (FORWARD, 0.3, 0.0, WAIT),
]


@pytest.mark.parametrize(("before", "distance", "bearing", "after"), INTENTS)
def test_the_driver(before: int, distance: float, bearing: float, after: int) -> None:
    intent = np.array([before])
    intend(intent, np.array([distance]), np.array([bearing]))
    assert intent.tolist() == [after]


ALONG_WALLS = [  # meant before, distance ahead, distance beside, meant after
    (walls.FORWARD, 2.0, 2.0, walls.FORWARD),  # no wall is near
    (walls.FORWARD, 2.0, 0.5, walls.FORWARD),
    (walls.FORWARD, 2.0, 0.6, walls.NEARER),
    (walls.FORWARD, 0.4, 0.6, walls.AWAY),
    (walls.AWAY, 0.7, 0.6, walls.AWAY),
    (walls.AWAY, 0.9, 0.6, walls.FORWARD),
    (walls.NEARER, 2.0, 0.5, walls.NEARER),
    (walls.NEARER, 2.0, 0.4, walls.FORWARD),
]


@pytest.mark.parametrize(("before", "ahead", "beside", "after"), ALONG_WALLS)
def test_the_driver_along_walls(before: int, ahead: float, beside: float, after: int) -> None:
    assert walls.choose_move(before, ahead, beside) == after


TO_THE_BALL = [  # meant before, x of the ball in px, turn that finds it out of sight, meant after
    (servoing.WALK, 80.0, servoing.RIGHT, servoing.WALK),
    (servoing.WALK, 40.0, servoing.RIGHT, servoing.WALK),
    (servoing.WALK, 20.0, servoing.RIGHT, servoing.LEFT),
    (servoing.WALK, 140.0, servoing.LEFT, servoing.RIGHT),
    (servoing.LEFT, 40.0, servoing.LEFT, servoing.LEFT),
    (servoing.LEFT, 60.0, servoing.LEFT, servoing.WALK),
    (servoing.WALK, np.nan, servoing.RIGHT, servoing.RIGHT),
]


@pytest.mark.parametrize(("before", "x", "lost", "after"), TO_THE_BALL)
def test_the_driver_to_the_ball(before: int, x: float, lost: int, after: int) -> None:
    assert servoing.choose_turn(before, x, lost) == after


def test_the_driver_to_the_ball_keeps_to_a_decision() -> None:
    """The ball jumps from the middle to an edge and back: the driver turns, and walks again after half a second."""
    driver = servoing.ServoDriver(1, "left", 0.1)
    meant = []
    for x in (80.0, *[10.0] * 2, *[80.0] * 8):
        percept: Percept = {X: np.array([x]), SIZE: np.array([100.0])}
        meant.append(int(driver.decide(percept).meant[0]))
    assert meant == [servoing.WALK, *[servoing.LEFT] * 6, *[servoing.WALK] * 4]


ON_THE_WAY = [  # aimed at before, bearing, aimed at after
    (forager.FORWARD, 0.4, forager.FORWARD),
    (forager.FORWARD, 0.6, forager.LEFT),
    (forager.FORWARD, -0.6, forager.RIGHT),
    (forager.LOAD, 3.0, forager.LEFT),
    (forager.LEFT, 0.2, forager.LEFT),
    (forager.LEFT, 0.1, forager.FORWARD),
    (forager.RIGHT, 2 * np.pi - 0.2, forager.RIGHT),
    (forager.RIGHT, 0.0, forager.FORWARD),
]


@pytest.mark.parametrize(("before", "bearing", "after"), ON_THE_WAY)
def test_the_driver_on_the_way_to_food(before: int, bearing: float, after: int) -> None:
    assert forager.choose_move(before, bearing) == after


HOMING = [  # level, deposits already, units stored, food left, deposits
    (forager.HARVEST, False, 12.0, YES, False),
    (forager.DEPOSIT, False, 0.0, YES, True),
    (forager.FORAGE, False, 11.0, YES, False),
    (forager.FORAGE, False, 12.0, YES, True),
    (forager.FORAGE, True, 5.0, YES, True),
    (forager.FORAGE, True, 0.0, YES, False),
    (forager.FORAGE, False, 3.0, NO, True),
]


@pytest.mark.parametrize(("level", "before", "stored", "left", "after"), HOMING)
def test_the_driver_deposits(level: str, before: bool, stored: float, left: float, after: bool) -> None:
    assert forager.is_homing(level, before, stored, left) is after


OVER = [  # level, units stored, food left, at the target, over
    (forager.GOTO, np.nan, np.nan, True, True),
    (forager.HARVEST, 12.0, YES, True, True),
    (forager.HARVEST, 3.0, YES, True, False),
    (forager.HARVEST, 3.0, NO, False, True),
    (forager.DEPOSIT, 0.0, np.nan, True, True),
    (forager.FORAGE, 0.0, YES, True, False),
    (forager.FORAGE, 2.0, NO, True, False),
    (forager.FORAGE, 0.0, NO, True, True),
]


@pytest.mark.parametrize(("level", "stored", "left", "there", "over"), OVER)
def test_a_drive_of_a_level_is_over(level: str, stored: float, left: float, there: bool, over: bool) -> None:
    assert forager.is_over(level, stored, left, there=there) is over


def test_buttons_are_pressed_without_the_stick() -> None:
    hand = StickSettings(gain=0.5, noise=0.0, dead_ticks=1, overshoot=0.0, slowest=1.0)
    stick = Stick(hand, 1, 2, np.random.default_rng(0), buttons=[1])
    aims = [[1.0, 0.0]] * 3 + [[0.0, 1.0]] * 2 + [[1.0, 0.0]] * 2
    found = [stick.move(np.array([aim]))[0].tolist() for aim in aims]
    assert found == [[0.0, 0.0], [0.5, 0.0], [0.75, 0.0], [0.875, 0.0], [0.0, 1.0], [0.0, 1.0], [0.5, 0.0]]


def test_pushes_turn_robots_and_are_not_recorded() -> None:
    pushes = foraging.draw_pushes(np.random.default_rng(0), 100, 4, 0.1, ["drive", "turn"])
    assert not pushes[:, :, 0].any()
    assert set(np.unique(pushes[:, :, 1])) == {-1.0, 0.0, 1.0}
    still = StickSettings(gain=1.0, noise=0.0, dead_ticks=0, overshoot=0.0, slowest=1.0)
    drive = foraging.drive_level(forager.GOTO, still, 0).recording
    turning = np.abs(drive.commands[:, 1]) > 0.0
    bearing = drive.values["bearing", "station"]
    jumps = np.abs((np.diff(bearing) + np.pi) % (2 * np.pi) - np.pi) > 0.1
    assert (jumps & ~turning[:-1]).any()


def test_a_drive_along_walls_is_labelled_right() -> None:
    drive = walls.drive_along_walls(STEADY, range(2), "left")
    library = Library(walls.find_wall_task(0).kit)
    candidates = make_candidates(library, drive.recording, walls.list_moves("left"))
    found = judge_labels(segment(drive.recording, candidates), drive.meant, STEADY).score()
    assert found["ticks"] >= 0.97
    assert found["switches"] >= 0.95


def test_a_drive_to_the_ball_is_labelled_right() -> None:
    drive = servoing.drive_to_ball(STEADY, range(2), "left")
    candidates = make_candidates(Library(kit), drive.recording, servoing.MOVES)
    found = judge_labels(segment(drive.recording, candidates), drive.meant, STEADY).score()
    assert found["ticks"] >= 0.97
    assert found["switches"] >= 0.95


def test_the_hand_is_late_and_overshoots() -> None:
    hand = StickSettings(gain=0.5, noise=0.0, dead_ticks=1, overshoot=0.2, slowest=1.0)
    stick = Stick(hand, 1, 1, np.random.default_rng(0))
    places = [float(stick.move(np.array([[0.5]]))[0, 0]) for _ in range(4)]
    assert places == pytest.approx([0.0, 0.3, 0.45, 0.475])


@pytest.mark.retrains
def test_the_dead_time_of_a_hand_is_told_from_its_slowness() -> None:
    """Its reaction time is estimated a tick too long; then drivers would have gone on at the readings of switches."""
    lesson = walls.learn_walls_from_drives(4).library.taught["wall_left"].lesson
    assert lesson is not None
    assert draw_stick_settings(4).dead_ticks == 0
    assert lesson.options.reaction_s == 0.0
