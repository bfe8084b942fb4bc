"""Skills of a robot in simulated time: its servers accept, succeed, abort, reject, are silent, or die."""

from __future__ import annotations

import json
from collections.abc import Callable
from math import isnan
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.rigs import CMD, Rig
from tests.robots.rovers import TWIST, Wire
from tests.robots.skill_rigs import OUTCOMES, TABLES, TICK_S, Conduct, SkillRig, write_skill_robot
from tests.sim.test_skills import SCENARIO, SCENARIO_FILE, change_skill

from understudy.addons.robots.diagnostics import diagnose_connection
from understudy.addons.robots.fleet import Fleet
from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import parse_robot
from understudy.addons.robots.ros.interfaces import CANCEL, Interfaces
from understudy.addons.robots.ros.transport import Publisher, WireType
from understudy.addons.robots.safety.guard import ArmingRefused
from understudy.addons.robots.twin import DigitalTwin
from understudy.errors import FileError, SettingError, UnknownName
from understudy.model.binding import Binding
from understudy.model.library import Library, TrainedAutomaton
from understudy.records.messages import decode_message
from understudy.records.recorder import RunRecorder
from understudy.sim.kit import make_scenario_kit
from understudy.sim.world import World
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session
from understudy.ui.cli.commands.run_robot import LiveRun

ENDS: list[tuple[Conduct, str]] = [
    ("succeed", "succeeded"),
    ("abort", "aborted"),
    ("reject", "rejected"),
]


@pytest.mark.parametrize(("conduct", "outcome"), ENDS)
def test_a_goal_ends_as_its_server_says(conduct: Conduct, outcome: str) -> None:
    """One goal while the state lasts, with the place of its target; another one when it is entered anew."""
    rig = SkillRig(conduct).ready()
    assert rig.outcomes() == []
    rig.tick("go_to", anew=True)
    rig.run_until(rig.outcomes)
    assert rig.outcomes() == [outcome]
    for _ in range(3):
        rig.tick("go_to")
    pose = rig.wire.goals[0].goal.pose
    assert (pose.header.frame_id, pose.pose.position.x, pose.pose.position.y) == ("map", 1.5, -2.0)
    assert pose.pose.orientation.w == 1.0
    assert (len(rig.wire.goals), rig.wire.cancelled) == (1, [])
    rig.tick("go_to", anew=True, to="home")
    rig.run_until(lambda: len(rig.wire.goals) == 2 and rig.outcomes())
    assert rig.wire.goals[1].goal.pose.pose.position.y == 0.5


def test_feedback_is_a_reading_that_is_absent_before() -> None:
    rig = SkillRig("run").ready()
    assert isnan(rig.read("go_to_distance_remaining"))
    rig.tick("go_to", anew=True)
    rig.run_until(lambda: rig.read("go_to_distance_remaining") == 1.0)


def test_what_is_asked_and_answered_is_recorded(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with RunRecorder(path) as recorder:
        rig = SkillRig("run", recorder=recorder).ready()
        rig.tick("go_to", anew=True)
        rig.run_until(lambda: rig.read("go_to_distance_remaining") == 1.0)
        rig.wire.conduct = "succeed"
        rig.tick("go_to", anew=True, to="home")
        rig.run_until(rig.outcomes)
        rig.tick("beep", anew=True)
        rig.run_until(lambda: rig.outcomes("beep"), "beep")
        rig.robot.close()
    found = [record for record in read_skill_records(path) if record["step"] != "feedback"]
    assert [(record["skill"], record["step"]) for record in found] == [
        ("go_to", "goal"),
        ("go_to", "cancelled"),
        ("go_to", "goal"),
        ("go_to", "succeeded"),
        ("beep", "goal"),
        ("beep", "succeeded"),
    ]
    assert found[0]["values"]["pose"]["pose"]["position"]["x"] == 1.5
    assert found[1]["problem"] == "its state was left"
    assert found[5]["values"]["success"] is True
    values = [record["values"] for record in read_skill_records(path) if record["step"] == "feedback"]
    assert {"go_to_distance_remaining": 1.0} in values


def read_skill_records(path: Path) -> list[dict[str, Any]]:
    from mcap.reader import make_reader

    with path.open("rb") as file:
        found = [
            message.data for _, _, message in make_reader(file).iter_messages(["/rover/understudy/skills"])
        ]
    return [json.loads(decode_message("std_msgs/msg/String", data).data) for data in found]


def test_leaving_the_state_cancels_the_goal_in_that_tick() -> None:
    rig = SkillRig("run").ready()
    rig.tick("go_to", anew=True)
    rig.run_until(lambda: not isnan(rig.read("go_to_distance_remaining")))
    assert rig.wire.cancelled == []
    rig.tick(anew=True, drive=1.0)
    assert rig.wire.cancelled == [bytes(goal.goal_id.uuid) for goal in rig.wire.goals]
    rig.tick(drive=1.0)
    assert rig.outcomes() == []
    assert rig.heard[-1][0] > 0


def test_a_goal_is_cancelled_that_the_robot_had_not_heard_of_yet() -> None:
    rig = SkillRig("run").ready()
    rig.act("go_to", anew=True)
    rig.act(anew=True)
    assert (rig.wire.goals, len(rig.wire.cancelled)) == ([], 1)
    rig.pass_tick()
    assert {*rig.wire.cancelled} == {bytes(goal.goal_id.uuid) for goal in rig.wire.goals}
    assert len(rig.wire.goals) == 1


@pytest.mark.parametrize("skill", ["go_to", "beep"])
def test_a_silent_server_times_out(skill: str) -> None:
    rig = SkillRig("silent").ready()
    began_s = rig.clock()
    rig.tick(skill, anew=True)
    rig.run_until(lambda: rig.outcomes(skill), skill)
    assert rig.outcomes(skill) == ["timed_out"]
    assert rig.clock() - began_s == pytest.approx(30.0, abs=TICK_S)


def test_a_server_that_dies_aborts_the_goal_and_rejects_the_next() -> None:
    rig = SkillRig("run").ready()
    rig.tick("go_to", anew=True)
    rig.run_until(lambda: not isnan(rig.read("go_to_distance_remaining")))
    rig.wire.leave()
    rig.tick("go_to")
    assert rig.outcomes() == ["aborted"]
    assert set(rig.robot.skills.find_problems()) == {"go_to", "beep"}
    rig.tick("go_to", anew=True)
    assert rig.outcomes() == ["rejected"]
    assert "nobody offers /rover/navigate_to_pose" in rig.robot.skills.skills["go_to"].last.problem


@pytest.mark.parametrize(("conduct", "outcome"), [("succeed", "succeeded"), ("abort", "aborted")])
def test_a_service_is_called_once_and_answers(conduct: Conduct, outcome: str) -> None:
    rig = SkillRig(conduct).ready()
    rig.tick("beep", anew=True)
    rig.run_until(lambda: rig.outcomes("beep"), "beep")
    assert (rig.outcomes("beep"), rig.wire.requests) == ([outcome], 1)


STOPS: list[Callable[[SkillRig], object]] = [
    lambda rig: rig.robot.disarm("Ada said so"),
    lambda rig: rig.robot.emergency_stop("Ada said so"),
    lambda rig: rig.robot.guard.stop_until_next_command("a test"),
    lambda rig: rig.robot.close(),
]


@pytest.mark.parametrize("stop", STOPS)
def test_what_stops_the_robot_cancels_its_goal(stop: Callable[[SkillRig], object]) -> None:
    """It is sent a stop, too, and nothing while its skill drives it; the goal is not sent again."""
    rig = SkillRig("run").ready()
    rig.tick(drive=1.0)
    rig.tick("go_to", anew=True)
    rig.run_until(lambda: not isnan(rig.read("go_to_distance_remaining")))
    sent = len(rig.heard)
    assert rig.heard[-1] == (0.0, 0.0)
    rig.robot.guard.check()
    rig.tick("go_to")
    assert len(rig.heard) == sent
    stop(rig)
    assert rig.wire.cancelled
    assert len(rig.heard) > sent
    assert rig.heard[-1] == (0.0, 0.0)
    if rig.robot.armed:
        for _ in range(3):
            rig.tick("go_to")
        assert rig.outcomes() == ["aborted"]
    assert len(rig.wire.goals) == 1


def test_a_program_that_decides_no_more_has_its_goal_cancelled_by_the_guard() -> None:
    rig = SkillRig("run").ready()
    rig.tick("go_to", anew=True)
    rig.run_until(lambda: not isnan(rig.read("go_to_distance_remaining")))
    left_s = rig.robot.tick_s + rig.robot.file.safety.deadline_s
    while rig.clock() - rig.decided_s < left_s - 1e-6:
        assert rig.wire.cancelled == []
        rig.pass_check()
    rig.pass_check()
    assert rig.wire.cancelled == [bytes(goal.goal_id.uuid) for goal in rig.wire.goals]
    assert rig.heard[-1] == (0.0, 0.0)
    assert "no command came" in rig.robot.stop_cause


def test_nothing_is_started_before_it_is_armed() -> None:
    rig = SkillRig().ready()
    rig.robot.disarm()
    for _ in range(3):
        rig.tick("go_to")
    assert (rig.wire.goals, rig.outcomes()) == ([], [])
    rig.robot.arm("Ada")
    rig.tick("go_to")
    assert len(rig.wire.goals) == 1


TAUGHT: list[tuple[Conduct, str]] = [("succeed", "beep"), ("abort", "home"), ("reject", "home")]


@pytest.mark.parametrize(("conduct", "next_state"), TAUGHT)
def test_a_behavior_taught_in_the_stand_in_runs_on_the_robot(
    tmp_path: Path, conduct: Conduct, next_state: str
) -> None:
    """Taught in simulation: from the dock, beep; where the goal was aborted or rejected, go home instead."""
    library = Library(make_scenario_kit(SCENARIO)).with_automaton(teach_round())
    recorder = RunRecorder(tmp_path / "run.mcap")  # which every run on a real robot has
    (tmp_path / "skilled.toml").write_text(SCENARIO_FILE.read_text())
    text = write_skill_robot(
        TABLES.replace('["distance_remaining"]', '["distance_remaining", "number_of_recoveries"]')
    )
    text = text.replace('name = "rover"', 'name = "rover"\nworld = "skilled.toml"', 1)
    rig = SkillRig(conduct, text, path=tmp_path / "rover.toml", recorder=recorder)
    twin = DigitalTwin(Fleet([rig.robot]))
    live = LiveRun(twin, {"rover": library}, {"rover": ("round", {})})
    rig.ready()
    seen = dict[str, None]()
    for _ in range(20):
        live.team.tick()
        rig.pass_tick()
        seen.update(dict.fromkeys(live.team.paths[0]))
    assert [each for each in seen if each != "start"] == ["dock", next_state]
    assert rig.wire.requests > 0 if next_state == "beep" else len(rig.wire.goals) > 1
    twin.close()
    recorder.close()


def teach_round() -> TrainedAutomaton:
    """Teach it in two worlds: one in which the skill succeeds, and one in which it fails."""
    library = Library(make_scenario_kit(SCENARIO))
    lesson = new_lesson(
        library, "round", states=["dock=go_to(dock)", "home=go_to(home)", "beep"], live=False,
        features=[f"go_to_{each}" for each in OUTCOMES],
    )  # fmt: skip
    for outcome, changes in (("succeeded", {}), ("aborted", {"success": 0.0}), ("rejected", {})):
        world = World(change_skill("go_to", **changes))
        if outcome == "rejected":
            world.remove_object(0)
        session = Session(world, library, lesson)
        session.direct("dock")
        while not world.sense([(f"go_to_{outcome}", None)])[f"go_to_{outcome}", None][0]:
            session.run_for(0.1)
        session.direct("beep" if outcome == "succeeded" else "home")
        session.run_for(0.3)
        lesson = session.make_trained_automaton().lesson or lesson
    session = Session(World(SCENARIO), library, lesson)
    return session.make_trained_automaton()


FIBONACCI = "action_tutorials_interfaces/action/Fibonacci"
PUBLISHED = [  # as ROS 2 Jazzy has them
    ("action_msgs/srv/CancelGoal", "573d8b0a534451d7bc2ac8c5ffde8ac14b8593b7001175d0cd6516dcbeb8689a"),
    (f"{FIBONACCI}_SendGoal", "a0603060ed69fe2dfbd1a6f3b982a1749957ef346e4a4d2b311a05e305ec37bb"),
    (f"{FIBONACCI}_GetResult", "8b47e383f1e31f6d8df6417ab54957e7d5ea24dad315646ad711ac3fdea81d58"),
    (f"{FIBONACCI}_FeedbackMessage", "50fc26b9cac313652ecbeab3adf9b5414d59fd4d4d5f9058ddcc7525169927f1"),
]


def test_hashes_of_the_types_of_actions_are_those_published(tmp_path: Path) -> None:
    path = tmp_path / "action_tutorials_interfaces" / "action" / "Fibonacci.action"
    path.parent.mkdir(parents=True)
    path.write_text("int32 order\n---\nint32[] sequence\n---\nint32[] partial_sequence\n")
    interfaces = Interfaces(tmp_path)
    action = interfaces.find_action(FIBONACCI)
    wires = (
        interfaces.find_service(CANCEL).wire,
        action.send_goal.wire,
        action.get_result.wire,
        action.feedback_message,
    )
    assert [tuple(wire) for wire in wires] == [(name, f"RIHS01_{hash}") for name, hash in PUBLISHED]


BROKEN = [  # a definition, and what is said
    ("int32 order\n---\nint32[] sequence\n", "has 2 parts instead of 3"),
    (
        "Order order\n---\n---\n",
        "is of type fib/msg/Order, which no file defines; put fib/msg/Order.msg into",
    ),
    ("int32 = order\n---\n---\n", "cannot be read"),
]


@pytest.mark.parametrize(("text", "said"), BROKEN)
def test_a_broken_definition_is_one_sentence(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "fib" / "action" / "Fibonacci.action"
    path.parent.mkdir(parents=True)
    path.write_text(text)
    with pytest.raises(FileError, match=said):
        Interfaces(tmp_path)


WRONG = [  # what is written instead, and what is said
    (
        "nav2_msgs/action/NavigateToPose",
        "nav2_msgs/action/Navigate",
        "'nav2_msgs/action/Navigate', which is unknown",
    ),
    ("nav2_msgs/action/NavigateToPose", "nav2_msgs/srv/Navigate", "which is not the type of an action"),
    ("position.x", "position.q", "no 'q'; give one of x, y, z"),
    ("pose.header.frame_id", "pose.header", "is not a single number or text"),
    ('"map"', "3", "is 3, and the field is a string; give a text"),
    ('"A.x"', '"left"', "is 'left', and the field is a float64"),
    ('"A.x"', '"A.z"', "a target has no z; give A.x or A.y"),
    ('"distance_remaining"', '"distance"', "there is no 'distance'"),
    ('action = "navigate_to_pose"', "", "has to have either `action` or `service`"),
    ("timeout_s = 30", "timeout_s = 0", "skills.go_to.timeout_s: is 0"),
]


@pytest.mark.parametrize(("before", "after", "said"), WRONG)
def test_a_wrong_skill_is_one_sentence(before: str, after: str, said: str) -> None:
    with pytest.raises(FileError) as caught:
        Robot(parse_robot(write_skill_robot(TABLES.replace(before, after, 1))), Wire())
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_those_who_command_it_before_it_is_armed_are_its_own_if_a_skill_drives() -> None:
    """Nav2 publishes commands all the time; whoever comes later stops the robot, as any other robot."""
    nav2 = Publisher(CMD, TWIST)
    rig = Rig(write_skill_robot(), wire=Wire([nav2])).ready()
    rig.move(1.0)
    rig.wait(0.3)
    assert (rig.robot.armed, rig.robot.stop_cause) == (True, "no command came for 0.30 s")
    rig.wire.others.append(nav2)
    rig.wait(0.3)
    assert (rig.robot.armed, rig.robot.stop_cause) == (False, f"somebody else publishes on {CMD}")
    with pytest.raises(ArmingRefused, match="somebody else publishes"):
        Rig(write_skill_robot(TABLES.replace("moves = true", "")), wire=Wire([nav2])).ready()


def test_a_survey_says_which_skills_are_not_there() -> None:
    class Empty(Wire):
        def find_service_problem(self, service: str, type: WireType) -> str:
            return f"nobody offers {service}"

    problems = diagnose_connection(Rig(write_skill_robot(), wire=Empty()).robot, seconds=0.0).problems
    said = "beep: nobody offers /rover/beep; start it, or correct `skills.beep` in the robot's file"
    assert [each for each in problems if "beep" in each] == [said]


def test_while_a_skill_drives_nothing_is_sent_and_all_checks_go_on() -> None:
    """One stop before it; then none until the sonar is absent: the goal is cancelled, and stops are sent."""
    rig = Rig(write_skill_robot(), wire=Wire()).ready()
    rig.move(1.0)
    columns = {"skill": rig.robot.index_skill("go_to", {"A": "dock"}), "issued": 0.0}
    for _ in range(5):
        rig.robot.act({name: np.array([float(value)]) for name, value in columns.items()})
        rig.wait(0.1)
    sent = [topic for topic, _ in rig.wire.sent]
    assert sent[-2:] == [CMD, "/rover/navigate_to_pose/_action/send_goal"]
    assert rig.robot.stop_cause == ""
    rig.wait(0.54, deaf=True)
    sent = [topic for topic, _ in rig.wire.sent][len(sent) :]
    assert sent.count("/rover/navigate_to_pose/_action/cancel_goal") == 1
    assert (rig.robot.armed, rig.robot.stop_cause, rig.sent) == (False, "sonar_ahead is absent", (0.0, 0.0))


def test_a_target_without_a_place_is_refused_when_it_is_bound() -> None:
    rig = SkillRig().ready()
    with pytest.raises(SettingError, match=r"targets\.ball is missing, and the skill go_to needs its place"):
        rig.robot.index_skill("go_to", Binding(A="ball"))
    with pytest.raises(UnknownName, match="no skill 'dance'"):
        rig.robot.index_skill("dance", {})
    assert rig.wire.goals == []
