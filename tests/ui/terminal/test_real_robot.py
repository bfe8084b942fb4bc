"""A real robot in the trainer, over a wire in memory: y arms it, Esc stops it, and keys teach it as ever."""

from __future__ import annotations

from asyncio import timeout, to_thread
from dataclasses import replace
from pathlib import Path
from threading import Event

import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.twins import Rig
from tests.ui.terminal.desks import GOTO, Hand, make_trainer
from tests.ui.terminal.test_main_screen import run

from understudy.addons.robots.safety.guard import ArmingRefused
from understudy.model.library import Library
from understudy.sim.kit import make_scenario_kit
from understudy.ui.controller.training_plan import TrainingPlan
from understudy.ui.terminal.main_screen import TeachingScreen

LONGEST_S = 60.0
"""How long is waited for threads at most."""


def plan(rig: Rig, folder: Path) -> TrainingPlan:
    """GoTo in the robot's world."""
    kit = make_scenario_kit(rig.twin.scenario)
    choices = replace(GOTO, targets={"A": "red_flag"})
    return TrainingPlan("goto", folder, rig.twin.scenario, Library(kit), choices)


async def wait(hand: Hand, rig: Rig, seconds: float) -> None:
    """So much time passes, with odometry."""
    for _ in range(round(seconds / 0.1)):
        rig.now += 0.1
        rig.send_odometry()
        await hand.wait(0.1)


async def end_of_arming(hand: Hand, before: str = "Arming…") -> None:
    """Wait until the thread that arms has ended, and something else is said than `before`."""
    async with timeout(LONGEST_S):
        while hand.status_text == before:
            await hand.pilot.pause(0.01)


@run
async def test_a_real_robot_is_armed_taught_and_stopped(tmp_path: Path) -> None:
    rig = Rig(("one",))
    rig.send_odometry()
    async with make_trainer(plan(rig, tmp_path), ground=rig.twin) as hand:
        await wait(hand, rig, 0.2)
        assert hand.teach_screen.query_one("#world").border_title == "one: not armed (y)"
        await hand.press("y")
        await end_of_arming(hand)
        await hand.press("up")
        await wait(hand, rig, 0.3)
        assert rig.sent(0) == (0.4, 0.0)
        assert hand.teach_screen.query_one("#world").border_title == "one: armed (Esc)"
        assert [str(example.kind) for example in hand.trainer.session.examples] == ["directive", "default"]
        await hand.press("space")  # paused it stands, and stays armed
        await wait(hand, rig, 0.3)
        assert rig.sent(0) == (0.0, 0.0)
        assert rig.robots[0].armed
        await hand.press("space")
        await wait(hand, rig, 0.2)
        assert rig.sent(0) == (0.4, 0.0)
        await hand.press("escape")
        assert rig.sent(0) == (0.0, 0.0)
        assert not rig.robots[0].armed
        assert hand.status_text == "Stopped. y arms it again"
        await hand.press("n")
        assert "cannot be reset" in hand.status_text


@run
async def test_time_goes_on_while_it_is_armed_and_a_stop_wins(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Such as over a network, where an agent may take its time to answer."""
    rig, answered = Rig(("one",)), Event()
    rig.send_odometry()
    monkeypatch.setattr(rig.robots[0], "prepare", lambda: answered.wait(LONGEST_S))
    async with make_trainer(plan(rig, tmp_path), ground=rig.twin) as hand:
        await hand.press("y")
        assert hand.status_text == "Arming…"
        before = hand.trainer.session.body.time_s
        await wait(hand, rig, 0.3)
        assert hand.trainer.session.body.time_s > before
        await hand.press("escape", "y")
        assert "has not ended yet" in hand.status_text
        before_end = hand.status_text
        answered.set()
        await end_of_arming(hand, before_end)
        assert "it was stopped meanwhile" in hand.status_text
        assert not rig.robots[0].armed


@run
async def test_who_leaves_while_it_is_armed_leaves_it_disarmed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig, left, ended, armings = Rig(("one",)), Event(), Event(), list[str]()
    rig.send_odometry()
    robot = rig.robots[0]
    arm = robot.arm

    def arm_and_note(by: str, *, stop_count: int | None = None) -> None:
        try:
            arm(by, stop_count=stop_count)
            armings.append("armed")
        except ArmingRefused:
            armings.append("refused")
            raise
        finally:
            ended.set()

    unmount = TeachingScreen.on_unmount

    def leave(screen: TeachingScreen) -> None:
        unmount(screen)
        left.set()

    monkeypatch.setattr(TeachingScreen, "on_unmount", leave)
    monkeypatch.setattr(robot, "prepare", lambda: left.wait(LONGEST_S))
    monkeypatch.setattr(robot, "arm", arm_and_note)
    async with make_trainer(plan(rig, tmp_path), ground=rig.twin) as hand:
        await hand.press("y", "q")
    assert await to_thread(ended.wait, LONGEST_S)
    assert armings == ["refused"]
    assert not robot.armed


@run
async def test_help_and_questions_stop_it_not(tmp_path: Path) -> None:
    """Another screen on top lets time stand still: the robot rests, and is armed still."""
    rig = Rig(("one",))
    rig.send_odometry()
    async with make_trainer(plan(rig, tmp_path), ground=rig.twin) as hand:
        await hand.press("y")
        await end_of_arming(hand)
        await hand.press("up")
        await wait(hand, rig, 0.2)
        teaching = hand.teach_screen
        await hand.press("h")
        for _ in range(3):
            rig.now += 0.1
            rig.send_odometry()
            teaching.run_due_ticks()
        assert rig.sent(0) == (0.0, 0.0)
        assert rig.robots[0].armed


@run
async def test_escape_stops_it_whatever_lies_on_top(tmp_path: Path) -> None:
    """Without that, it would close the help, and the robot would go on."""
    rig = Rig(("one",))
    rig.send_odometry()
    async with make_trainer(plan(rig, tmp_path), ground=rig.twin) as hand:
        for key in ("h", "l", "c"):
            await hand.press("y")
            await end_of_arming(hand)
            await hand.press("up", key, "escape")
            await wait(hand, rig, 0.2)
            assert rig.sent(0) == (0.0, 0.0)
            assert [stop.cause for stop in rig.robots[0].stops] == ["emergency: stopped in the terminal"]
            rig.robots[0].guard.log.stops.clear()
