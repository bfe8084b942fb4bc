"""A world while it runs: robots driven into position, objects moved, added and removed; nonsense changes nothing."""

from __future__ import annotations

from collections.abc import Callable
from math import nan, pi, tau
from typing import Any

import numpy as np
import pytest
from tests.sim.test_world_laws import states

from understudy.errors import (
    DefinitionError,
    FileError,
    KindError,
    SettingError,
    UnderstudyError,
    UnknownName,
)
from understudy.model.automaton import START, Automaton, State
from understudy.model.behaviors import Behavior, Command, behavior
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, feature
from understudy.model.library import Kit, Library
from understudy.model.tree import Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import BOOLEAN, Column, Continuous
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import Program, link
from understudy.runtime.run_loop import Run
from understudy.sim.scenario.schema import (
    ObjectClass,
    Obstacle,
    PoseSensor,
    RobotGroup,
    RobotType,
    Scenario,
    Sonar,
    TargetLocator,
    TargetSpec,
    Wall,
)
from understudy.sim.world import World

SQUARE = ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))
SCENARIO = Scenario(
    size=(10.0, 8.0),
    types={
        "rover": RobotType(
            radius=0.2,
            capacity=3,
            sensors=(PoseSensor(), TargetLocator(), Sonar(sectors={"ahead": (0, 0)}, range=9.0)),
        )
    },
    robots=(RobotGroup(type="rover", at=((5.0, 4.0, 0.0), (5.0, 6.0, 0.0))),),
    walls=(Wall(points=((2.0, 0.0), (2.0, 4.0))),),
    obstacles=(Obstacle(radius=0.5, at=((8.0, 4.0),)), Obstacle(points=SQUARE, at=((8.0, 7.0),))),
    objects=(
        ObjectClass(name="food", amount=4, at=((5.0, 2.0),)),
        ObjectClass(name="pillar", solid=True, radius=0.3, at=((3.0, 7.0),)),
        ObjectClass(name="flag", at=((1.0, 1.0),)),
    ),
    targets={
        "food": TargetSpec(nearest="food"),
        "flag": TargetSpec(object="flag"),
        "mouse": TargetSpec(object="mouse"),
    },
    spare_objects=1,
)
FOOD, FOOD_SPARE, PILLAR, FLAG = 0, 1, 2, 4
"""Slots."""


def world(seeds: tuple[int, ...] = (0,)) -> World:
    return World(SCENARIO, seeds)


def read(body: World, name: str, target: str | None = None, agent: int = 0) -> float:
    return float(body.sense([(name, target)])[name, target][agent])


def test_a_robot_is_put_somewhere() -> None:
    body = world((0, 1))
    body.act({"drive": np.ones(4)})
    body.place(3, 7.0, 1.0, -pi / 2)
    row = body.state.robots[3]
    assert (row["x"], row["y"], row["speed"]) == (7.0, 1.0, 0.0)
    assert row["heading"] == pytest.approx(3 * pi / 2)
    body.place(3, 7.0, 1.0, -1e-20)
    assert 0 <= body.state.robots["heading"][3] < tau
    body.place(0, 4.6, 6.0, 0.0)  # rim to rim with the other one
    body.place(0, 7.5 - 0.2, 4.0, 0.0)


@pytest.mark.parametrize("number", [np.float64, np.float32, np.int64])
def test_numbers_of_numpy_put_a_robot_where_plain_ones_do(number: type[np.float64]) -> None:
    body, plain = world(), world()
    body.place(0, number(9), number(7), number(1))  # level with the polygon, on its right
    plain.place(0, 9.0, 7.0, 1.0)
    assert body.snapshot() == plain.snapshot()
    with pytest.raises(SettingError, match="overlaps an obstacle"):
        body.place(0, number(8), number(7), number(0))


def test_objects_are_moved_added_and_removed() -> None:
    body = world((0, 1))
    body.move_object(FOOD, 5.0, 3.0)
    assert read(body, "range", "food") == 1.0
    assert read(body, "range", "food", agent=2) == 2.0  # the other world is as it was
    assert body.add_object("food", 5.5, 4.0, amount=2) == FOOD_SPARE
    assert read(body, "range", "food") == 0.5
    body.remove_object(FOOD_SPARE)
    assert read(body, "range", "food") == 1.0
    body.remove_object(FOOD)
    assert np.isnan(read(body, "range", "food"))
    for _ in range(50):
        body.act({})
    assert np.isnan(read(body, "range", "food"))
    body.move_object(FLAG, 5.0, 4.0)  # not solid: anywhere
    assert read(body, "range", "flag") == 0.0


def test_what_is_solid_is_solid_at_once() -> None:
    body = world()
    body.move_object(PILLAR, 6.0, 4.0)
    assert read(body, "ahead") == pytest.approx(0.5)
    for _ in range(50):
        body.act({"drive": np.ones(2)})
    assert body.state.robots["x"][0] == pytest.approx(5.5, abs=1e-8)
    body.remove_object(PILLAR)
    body.add_obstacle(6.5, 4.0, 0.1)
    assert read(body, "ahead") == pytest.approx(6.4 - 5.5 - 0.2)
    for _ in range(50):
        body.act({"drive": np.ones(2)})
    assert body.state.robots["x"][0] == pytest.approx(6.2, abs=1e-8)


def test_a_snapshot_from_before_an_obstacle_and_one_from_after() -> None:
    body, other = world((0, 1)), world((0, 1))
    before = body.snapshot()
    body.add_obstacle(6.5, 4.0, 0.1, world=1)
    after = body.snapshot()
    assert read(body, "ahead", agent=0) == pytest.approx(2.3)
    assert read(body, "ahead", agent=2) == pytest.approx(1.2)
    body.restore(before)
    assert read(body, "ahead", agent=2) == pytest.approx(2.3)
    assert body.snapshot() == before
    other.restore(after)
    assert read(other, "ahead", agent=2) == pytest.approx(1.2)
    assert other.snapshot() == after


def test_an_obstacle_is_moved_and_removed() -> None:
    body = world((0, 1))
    empty = body.view(1).discs.x.tolist()
    body.add_obstacle(6.5, 4.0, 0.1, world=1)
    body.add_obstacle(9.0, 7.0, 0.1, world=1)
    first = len(empty)
    body.move_obstacle(first, 7.0, 4.0, world=1)
    assert read(body, "ahead", agent=2) == pytest.approx(1.7)
    assert read(body, "ahead", agent=0) == pytest.approx(2.3)
    body.remove_obstacle(first, world=1)
    assert read(body, "ahead", agent=2) == pytest.approx(2.3)
    assert body.view(1).discs.x.tolist() == [*empty, 9.0]
    body.remove_obstacle(first, world=1)
    assert body.view(1).discs.x.tolist() == empty


NONSENSE: list[tuple[str, str, Callable[[World], Any]]] = [
    ("agent", "is 2; give one from 0 to 1", lambda body: body.place(2, 1.0, 1.0, 0.0)),
    ("agent", "is -1", lambda body: body.place(-1, 1.0, 1.0, 0.0)),
    ("agent", "is 0.5", lambda body: body.place(0.5, 1.0, 1.0, 0.0)),  # type: ignore[arg-type]
    ("agent", "is 7", lambda body: body.freeze(7)),
    ("agent", "is -1", lambda body: body.freeze(-1)),
    ("place of robot 0", "nan", lambda body: body.place(0, nan, 1.0, 0.0)),
    ("place of robot 0", "inf", lambda body: body.place(0, 1.0, 1.0, np.inf)),
    ("place of robot 0", "10.5", lambda body: body.place(0, 10.5, 1.0, 0.0)),
    ("place of robot 0", "here", lambda body: body.place(0, "here", 1.0, 0.0)),  # type: ignore[arg-type]
    ("place of robot 0", "the outer wall", lambda body: body.place(0, 9.9, 1.0, 0.0)),
    ("place of robot 0", "a wall", lambda body: body.place(0, 2.1, 1.0, 0.0)),
    ("place of robot 0", "an obstacle", lambda body: body.place(0, 7.4, 4.0, 0.0)),
    ("place of robot 0", "an obstacle", lambda body: body.place(0, 8.0, 6.4, 0.0)),
    ("place of robot 0", "an obstacle", lambda body: body.place(0, 8.0, 7.01, 0.0)),  # inside the polygon
    ("place of robot 0", "object 2, of class 'pillar'", lambda body: body.place(0, 3.4, 7.0, 0.0)),
    ("place of robot 0", "robot 1", lambda body: body.place(0, 5.0, 5.7, 0.0)),
    ("place of object 0", "nan", lambda body: body.move_object(FOOD, nan, 1.0)),
    ("place of object 0", "-1.0", lambda body: body.move_object(FOOD, 1.0, -1.0)),
    ("place of object 2", "robot 0", lambda body: body.move_object(PILLAR, 5.1, 4.0)),
    ("slot", "is 99", lambda body: body.move_object(99, 1.0, 1.0)),
    (
        "slot",
        "is 1, but there is no object with this index",
        lambda body: body.move_object(FOOD_SPARE, 1.0, 1.0),
    ),
    ("slot", "is -1", lambda body: body.remove_object(-1)),
    ("slot", "is 1, but there is no object with this index", lambda body: body.remove_object(FOOD_SPARE)),
    ("world", "is 1", lambda body: body.move_object(FOOD, 1.0, 1.0, world=1)),
    ("world", "is -1", lambda body: body.remove_object(FOOD, world=-1)),
    ("world", "is 3", lambda body: body.add_object("flag", 1.0, 1.0, world=3)),
    ("world", "is 3", lambda body: body.add_obstacle(1.0, 1.0, 0.2, world=3)),
    ("world", "is 3", lambda body: body.place_pointer(1.0, 1.0, world=3)),
    ("place of 'flag'", "nan", lambda body: body.add_object("flag", nan, 1.0)),
    ("place of 'pillar'", "robot 0", lambda body: body.add_object("pillar", 5.0, 4.0)),
    ("amount of 'food'", "is -1", lambda body: body.add_object("food", 1.0, 1.0, amount=-1)),
    ("amount of 'food'", "is 1.5", lambda body: body.add_object("food", 1.0, 1.0, amount=1.5)),  # type: ignore[arg-type]
    ("amount of 'flag'", "it is not food", lambda body: body.add_object("flag", 1.0, 1.0, amount=1)),
    ("place of an obstacle", "nan", lambda body: body.add_obstacle(nan, 1.0, 0.2)),
    ("place of an obstacle", "robot 0", lambda body: body.add_obstacle(5.0, 4.3, 0.2)),
    ("place of an obstacle", "inf", lambda body: body.add_obstacle(1.0, 1.0, np.inf)),
    ("radius of an obstacle", "is -0.2", lambda body: body.add_obstacle(1.0, 1.0, -0.2)),
    ("radius of an obstacle", "is 0", lambda body: body.add_obstacle(1.0, 1.0, 0.0)),
    ("obstacle", "is 9", lambda body: body.remove_obstacle(9)),
    ("obstacle", "is -1", lambda body: body.move_obstacle(-1, 1.0, 1.0)),
    ("place of an obstacle", "nan", lambda body: body.move_obstacle(0, nan, 1.0)),
    ("place of an obstacle", "robot 0", lambda body: body.move_obstacle(0, 5.0, 4.0)),
    ("world", "is 3", lambda body: body.remove_obstacle(0, world=3)),
    ("pointer", "nan", lambda body: body.place_pointer(nan, 1.0)),
    ("pointer", "nan", lambda body: body.place_pointer(1.0)),
    ("pointer", "nan", lambda body: body.place_pointer(None, 1.0)),
    ("pointer", "11.0", lambda body: body.place_pointer(11.0, 1.0)),
    ("seeds", "are [-1]", lambda body: body.reset([-1])),
    ("seeds", "are [1.5]", lambda body: body.reset([1.5])),  # type: ignore[list-item]
    ("seeds", "are ['a']", lambda body: body.reset(["a"])),  # type: ignore[list-item]
    ("seeds", "are [0, 1]", lambda body: body.reset([0, 1])),
    ("seeds", "are 5; give a list", lambda body: body.reset(5)),  # type: ignore[arg-type]
    ("seeds", "are 5; give a list", lambda body: World(body.scenario, 5)),  # type: ignore[arg-type]
    ("seeds", "are None; give a list", lambda body: World(body.scenario, None)),  # type: ignore[arg-type]
]


@pytest.mark.parametrize(("setting", "problem", "attempt"), NONSENSE)
def test_nonsense_is_refused_and_changes_nothing(
    setting: str, problem: str, attempt: Callable[[World], Any]
) -> None:
    body = world()
    before = states(body)
    with pytest.raises(SettingError) as refusal:
        attempt(body)
    assert refusal.value.setting == setting
    assert problem in str(refusal.value)
    assert states(body) == before


def test_unknown_names() -> None:
    body = world()
    before = states(body)
    attempts: dict[str, Callable[[], Any]] = {
        "stones": lambda: body.add_object("stones", 1.0, 1.0),
        "smell": lambda: body.sense([("smell", None)]),
        "nobody": lambda: body.sense([("range", "nobody")]),
        "jump": lambda: body.act({"drive": np.ones(2), "jump": np.ones(2)}),
    }
    for name, attempt in attempts.items():
        with pytest.raises(UnknownName, match=name):
            attempt()
    assert states(body) == before


def test_targets_that_are_missing_or_too_many() -> None:
    body = world()
    for name, key in {"range": ("range", None), "ahead": ("ahead", "food")}.items():
        with pytest.raises(UnderstudyError, match=f"{name}.*target"):
            body.sense([key])


def test_commands_that_are_none() -> None:
    body = world()
    before = states(body)
    for column in (np.ones(3), np.ones((2, 1)), np.array([1.0, nan]), np.array([np.inf, 1.0])):
        with pytest.raises(DefinitionError, match="drive"):
            body.act({"turn": np.ones(2), "drive": column})
    assert states(body) == before


def test_no_room_for_more() -> None:
    body = world()
    body.add_object("flag", 1.0, 2.0)
    with pytest.raises(SettingError, match="spare_objects"):
        body.add_object("flag", 1.0, 3.0)


def test_bad_snapshots() -> None:
    body = world()
    good = body.snapshot()
    line, _, rest = good.partition(b"\n")
    other = World(SCENARIO, (0, 1)).snapshot()
    ids = body.state.robots["type"].copy()
    body.state.robots["type"] = 9
    of_no_type = body.snapshot()
    body.state.robots["type"] = ids
    huge = line.replace(b"[1, 1]", b"[1, 99999999]") + b"\n" + rest
    strange = line.replace(b'"arrays"', b'"arrows"') + b"\n" + rest
    for bad in (b"", b"{}", b"[" * 100_000, good[:-1], good + b"x", rest, other, of_no_type, huge, strange):
        with pytest.raises(FileError):
            body.restore(bad)
        assert body.snapshot() == good


# Functions of somebody's own, by the interpreter and by the engine.


@feature(BOOLEAN)
def two(robot: Any) -> Column:
    return np.asarray(robot.x * 0 + 2.0)


@feature(Continuous())
def too_short(robot: Any) -> Column:
    return np.asarray(robot.x[1:])


@feature(Continuous())
def words(robot: Any) -> Any:
    return ["a", "b"]


@feature(Continuous())
def breaks(robot: Any) -> Any:
    return robot.no_such_reading


@feature(Continuous())
def fine(robot: Any) -> Column:
    return np.asarray(robot.x)


@behavior
def dizzy(robot: Any) -> dict[str, Column]:
    """Turns by NaN where it is at y = 6: the second robot."""
    return {"turn": np.where(robot.y > 5, nan, 0.5)}


@behavior
def jumps(robot: Any) -> dict[str, Column]:
    return {"jump": np.ones_like(robot.x)}


@behavior
def says(robot: Any) -> Any:
    return "forward"


STILL = Behavior("still", Command())


def program(asked: Any, does: Behavior) -> Program:
    kit = Kit.from_parts(asked, does, Behavior("ahead", Command(drive=1.0)))
    node = Node(TestKind.ABSENT, 0, yes=1, no=1)
    if asked.kind == BOOLEAN:
        node = Node(TestKind.LABEL, 0, absent=1, branches=(1, 1))
    tree = Tree((node, make_leaf(1)))
    states_ = (START, State("s", does.name, Binding({})))
    automaton = Automaton(
        "own", states_, (BoundFeature(asked, Binding({})),), (), True, {"start": tree, "s": tree}
    )
    return link(Library.from_automata(kit, automaton), "own")


BROKEN: list[tuple[Any, Behavior, type[UnderstudyError], tuple[str, ...]]] = [
    (two, STILL, KindError, ("two", "agent 0", "2")),
    (too_short, STILL, DefinitionError, ("too_short", "(1,)")),
    (words, STILL, DefinitionError, ("words",)),
    (breaks, STILL, UnderstudyError, ("breaks", "no_such_reading")),
    (fine, dizzy, DefinitionError, ("dizzy", "turn", "agent 1", "nan")),
    (fine, jumps, UnknownName, ("jumps", "jump")),
    (fine, says, DefinitionError, ("says", "forward")),
]


WAYS: dict[str, Callable[[World, Program], Any]] = {
    "interpreter": lambda body, program: Run.from_program(body, program).tick(),
    "engine by ticks": lambda body, program: Engine.from_program(body, program).tick(),
    "engine": lambda body, program: Engine.from_program(body, program).run(3),
}


@pytest.mark.parametrize(("asked", "does", "error", "named"), BROKEN)
@pytest.mark.parametrize("how", WAYS)
def test_functions_that_are_wrong_are_named(
    asked: Any, does: Behavior, error: type[UnderstudyError], named: tuple[str, ...], how: str
) -> None:
    body = world()
    before, run = states(body), WAYS[how]
    with pytest.raises(error) as refusal:
        run(body, program(asked, does))
    assert all(word in str(refusal.value) for word in named), str(refusal.value)
    assert states(body) == before


def test_a_command_of_words_is_refused_by_its_name() -> None:
    body = world()
    before = states(body)
    with pytest.raises(DefinitionError, match="command 'drive': it is 'fast'"):
        body.act({"drive": "fast"})  # type: ignore[dict-item]
    assert states(body) == before


@pytest.mark.parametrize("nothing", ["a", None, 3])
def test_what_is_no_bytes_is_no_snapshot(nothing: Any) -> None:
    with pytest.raises(FileError, match="is not a snapshot"):
        world().restore(nothing)
