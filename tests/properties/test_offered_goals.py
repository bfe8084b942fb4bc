"""Goals that are offered for a behavior without a flag: a table of what was shown, and what fits it."""

from __future__ import annotations

from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import structs

from understudy.judging.behavior_run import ProgramRun
from understudy.judging.properties.condition import parse_condition
from understudy.judging.properties.monitor import monitor_property
from understudy.judging.properties.offered_goals import describe_goal, find_behavior_success, offer_goals
from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import NOTHING_BOUND, Binding
from understudy.model.features import BoundFeature, Feature
from understudy.model.lesson import Example, ExampleKind, Lesson, ReadingLog
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.property import PropertyKind
from understudy.model.value_kinds import Continuous
from understudy.runtime.link import link
from understudy.sim.catalog import find_scenario
from understudy.sim.scenario.schema import RobotGroup
from understudy.sim.world import World

ARENA = find_scenario("arena")
WORLD = World(ARENA, [0])
EMPTY = structs.replace(
    ARENA,
    obstacles=(),
    objects=(),
    regions={},
    targets={},
    goal=None,
    robots=(structs.replace(ARENA.robots[0], within=None),),
)
STATES = (START, State("along", "forward"), State("veer_left", "veer_left"))


def make_lesson(
    *values: float,
    name: str = "sonar_left",
    times: tuple[float, ...] = (),
    flags: tuple[str, ...] = (),
    binding: Binding = NOTHING_BOUND,
) -> Lesson:
    """Return a lesson with one watched example every two seconds, or at these times."""
    feature = Feature(name, Continuous(), parameters=tuple(binding), unit="m", reading=name)
    states = (*STATES, *(State(flag, flag=flag) for flag in flags))
    automaton = Automaton(
        "walls", states, (BoundFeature(feature, binding),), parameters=tuple(binding.values())
    )
    examples = tuple(
        Example(number + 1, "along", (value,), "along", ExampleKind.WATCHED, moment=number)
        for number, value in enumerate(values)
    )
    seconds = np.array(times or [2.0 * each for each in range(len(values))])
    log = ReadingLog(((name, None),), np.array(values)[:, np.newaxis], seconds)
    return Lesson(automaton, examples, record=log)


KEPT = [  # what the sonar on the left read every 2 s -> what was kept, and for how long it was left
    ("all the time but for 4 s", (3.0, 3.0, 0.5, 0.4, 0.5, 0.4, 0.45, 0.5, 0.4, 0.5),
     "keeps sonar_left between 0.4 and 0.5 m, touches nothing and moves on, but for at most 6 s at a time",
     "sonar_left is below 0.4 m or above 0.5 m"),
    ("where it was absent, it was not kept", (nan, nan, nan, 3.0, *(0.5, 0.4) * 8),
     "keeps sonar_left between 0.4 and 0.5 m, touches nothing and moves on, but for at most 12 s at a time",
     "sonar_left is below 0.4 m or above 0.5 m or absent"),
    ("a lower limit, where values are spread", (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 0.6, 1.1, 1.6, 2.1),
     "keeps sonar_left at 0.5 m or more, touches nothing and moves on, but for at most 5 s at a time",
     "sonar_left is below 0.5 m"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("values", "name", "what"), [each[1:] for each in KEPT], ids=[each[0] for each in KEPT]
)
def test_what_was_kept_is_offered_first(values: tuple[float, ...], name: str, what: str) -> None:
    offered = offer_goals(make_lesson(*values), WORLD)[0]
    what = f"{what} or clearance is below 5 mm or covered(12 s) is below 0.75 m²"
    assert (offered.name, offered.what, offered.kind) == (name, what, PropertyKind.NEVER_LONGER)
    parse_condition(offered.what)


STANDS = "covered(12 s) is below 0.75 m²"
MOVING = [  # states at the moments, forward or turning -> whether the goal demands that it moves on
    (("along",) * 10, True),
    (("along", "turn") * 5, True),
    (("along", "turn", "turn") * 4, False),
    (("wait",) * 10, False),  # it stands beside a wall
    (("follow",) * 10, True),  # an automaton
]


@pytest.mark.parametrize(("states", "moves"), MOVING)
def test_what_drives_has_to_move_on(states: tuple[str, ...], moves: bool) -> None:
    lesson = make_lesson(3.0, 0.5, *(0.5, 0.4) * 4)
    ways = (State("turn", "rotate_left"), State("wait"), State("follow", "follow_wall"))
    automaton = replace(lesson.automaton, states=(*STATES, *ways))
    moments = zip(lesson.examples, states, strict=False)
    examples = tuple(replace(each, state=state, next=state) for each, state in moments)
    offered = offer_goals(Lesson(automaton, examples, record=lesson.record), WORLD)[0]
    assert (" and moves on, " in offered.name, STANDS in offered.what) == (moves, moves)


SPEEDS = [  # m/s -> the time in which it covers twelve squares straight ahead, if that is at most half a minute
    (0.5, "covered(12 s)"), (1.0, "covered(6 s)"), (0.2, "covered(30 s)"), (0.19, None),
]  # fmt: skip


@pytest.mark.parametrize(("speed", "lately"), SPEEDS)
def test_a_slow_robot_is_given_time_to_move_on(speed: float, lately: str | None) -> None:
    rover = structs.replace(ARENA.types["rover"], speed=speed)
    world = World(structs.replace(ARENA, types={"rover": rover}), [0])
    what = offer_goals(make_lesson(3.0, *(0.5, 0.4) * 5), world)[0].what
    assert what.endswith("clearance is below 5 mm" if lately is None else f"{lately} is below 0.75 m²")


def test_what_turns_on_the_spot_does_not_move_on() -> None:
    """Nothing is near it, and what it reads is far away, as it was shown."""
    goal = offer_goals(make_lesson(0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 0.6, 1.1), WORLD)[0]
    failed = {}
    for behavior in ("rotate_left", "veer_left"):
        world = World(EMPTY, [0])
        world.state.robots["x"], world.state.robots["y"] = 6.0, 5.0
        run = ProgramRun(world, link(Library(WORLD.kit), behavior, {}), Library(WORLD.kit), {})
        failed[behavior] = monitor_property(goal, run, (), limit_s=20.0).failed_s[0]
    assert failed == {"rotate_left": pytest.approx(5.1), "veer_left": pytest.approx(nan, nan_ok=True)}


NOT_KEPT = [
    ("too few moments", {"values": (3.0, 0.5, 0.5, 0.5)}),
    ("always the same", {"values": (0.5,) * 10}),
    ("left for most of the time", {"values": (*(2.9,) * 20, 3.0, *(0.5, 0.4) * 46)}),
    ("a lower limit that nothing can miss", {"values": (0.02, 0.3, 0.9, 1.4, 2.0, 2.5, 3.0, 3.9, 4.5, 5.0)}),
    ("not from examples without a record", {"values": (3.0, 0.5, 0.4, 0.5, 0.4, 0.5), "record": False}),
]  # fmt: skip


@pytest.mark.parametrize("given", [each[1] for each in NOT_KEPT], ids=[each[0] for each in NOT_KEPT])
def test_what_was_not_kept_is_not_offered(given: dict[str, object]) -> None:
    lesson = make_lesson(*given["values"], times=given.get("times", ()))  # type: ignore[misc, arg-type]
    if "record" in given:
        lesson = Lesson(lesson.automaton, lesson.examples)
    assert [each.name for each in offer_goals(lesson, WORLD)] == [TOUCHES, COVERS]


TOUCHES, COVERS = "never touches anything", "covers at least 3.75 m² of ground in 60 s"


def test_goals_of_a_coordinator_are_about_its_robots() -> None:
    lesson = make_lesson(*KEPT[0][1], name="share")
    assert [each.name for each in offer_goals(lesson, WORLD, of_coordinator=True)] == [
        "keeps share between 0.4 and 0.5 m and lets its robots touch nothing, but for at most 6 s at a time",
        "never lets its robots touch anything",
        f"{COVERS} with each of its robots",
    ]


def test_goals_are_about_the_robots_that_count() -> None:
    """The first of two robots is slower, and runs into nothing."""
    rover = ARENA.types["rover"]
    slow = structs.replace(rover, speed=rover.speed / 2, collides=False)
    groups = tuple(RobotGroup(type=name, count=1) for name in ("slow", "rover"))
    scenario = structs.replace(ARENA, types={"slow": slow, "rover": rover}, robots=groups)
    names = [
        [each.name for each in offer_goals(make_lesson(), World(scenario, [0]), robots=np.array(robots))]
        for robots in ([True, False], [False, True])
    ]
    assert names == [["covers at least 1.75 m² of ground in 60 s"], [TOUCHES, COVERS]]


def test_far_from_a_target_is_no_free_space() -> None:
    """The distance to a target has no lower limit, but it can be kept, as in circling."""
    binding = Binding({"target": "A"})
    spread = make_lesson(0.5, 1.0, 1.5, 2.0, 2.5, 3.0, name="range", binding=binding)
    assert [each.name for each in offer_goals(spread, WORLD)] == [TOUCHES, COVERS]
    kept = make_lesson(3.0, *(1.0, 1.1) * 6, name="range", binding=binding)
    assert offer_goals(kept, WORLD)[0].name.startswith("keeps range(A) between 1 and 1.1 m")


GROUND = [  # width and height of the arena, m, speed, m/s -> demanded area: a quarter of what is possible
    ((12.0, 10.0), 0.5, "3.75 m²"),  # 60 squares straight ahead
    ((4.0, 2.0), 0.5, "2 m²"),  # 32 squares in all
    ((12.0, 10.0), 0.01, None),  # one square
]


@pytest.mark.parametrize(("size", "speed", "area"), GROUND)
def test_ground_that_a_robot_can_cover(size: tuple[float, float], speed: float, area: str | None) -> None:
    rover = structs.replace(ARENA.types["rover"], speed=speed)
    scenario = structs.replace(EMPTY, size=size, types={"rover": rover})
    offered = [each.what for each in offer_goals(make_lesson(), World(scenario, [0]))]
    assert offered == ["clearance is below 5 mm", *([f"covered is at least {area}"] if area else [])]


@given(st.lists(st.floats(0.01, 9.0) | st.just(nan), min_size=0, max_size=40))
def test_what_is_offered_can_be_measured_and_holds_where_it_was_kept(values: list[float]) -> None:
    for each in offer_goals(make_lesson(*values), WORLD):
        condition = parse_condition(each.what)
        assert str(condition)
        if each.kind is PropertyKind.NEVER_LONGER:
            clauses = [clause for (clause,) in condition.alternatives]
            assert [str(each) for each in clauses[-2:]] == ["clearance is below 5 mm", STANDS]
            clauses = clauses[:-2]
            high = clauses[1].number if len(clauses) > 1 and clauses[1].unit else inf
            inside = [clauses[0].number <= value <= high for value in values]
            assert sum(inside) >= 0.8 * len(values)
            assert each.seconds is not None
            assert 5.0 <= each.seconds <= 30.0


MEANINGS = [  # flags, whether one was chosen, whether the world has a goal -> what success means
    ((), False, False, ""),
    ((), False, True, "the goal of the world is reached"),
    (("done",), False, True, "done is raised, wherever that is"),
    ((), True, True, TOUCHES),
    (("done",), True, True, TOUCHES),
    (("here", "there"), False, False, ""),
]


@pytest.mark.parametrize(("flags", "chosen", "of_world", "said"), MEANINGS)
def test_what_success_means(flags: tuple[str, ...], chosen: bool, of_world: bool, said: str) -> None:
    lesson = make_lesson(flags=flags)
    goal = offer_goals(lesson, WORLD)[0] if chosen else None
    assert describe_goal(Lesson(lesson.automaton, goal=goal), of_world=of_world) == said


def test_success_of_a_behavior_of_a_library() -> None:
    """An automaton that was written by hand has no lesson, but flags; a basic behavior has neither."""
    library, automaton = Library(WORLD.kit), make_lesson(flags=("done",)).automaton
    goal = offer_goals(make_lesson(), WORLD)[0]
    for taught, success in (
        (TrainedAutomaton(automaton), "done"),
        (TrainedAutomaton(automaton, Lesson(automaton)), "done"),
        (TrainedAutomaton(automaton, Lesson(automaton, goal=goal)), goal),
        (TrainedAutomaton(make_lesson().automaton), None),
    ):
        assert find_behavior_success(library.with_automaton(taught), "walls") == success
    assert find_behavior_success(library, "forward") is None
