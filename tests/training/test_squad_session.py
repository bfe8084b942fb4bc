"""A coordinator is trained as a robot is: the same session, with a squad for a body."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest
from tests.sim.patrollers import ROBOTS, SCENARIO

from understudy.errors import FileError, SettingError, UnknownName
from understudy.model.lesson import ExampleKind
from understudy.model.library import Library
from understudy.runtime.team.coordinator_body import CoordinatorBody
from understudy.runtime.team.squad_body import list_squad_readings
from understudy.runtime.team.squad_kit import make_squad_kit
from understudy.sim.scenario.squad_schema import CommsSpec
from understudy.sim.team.assignment import assign_team_members
from understudy.sim.team.libraries import collect_libraries, make_coordinator_body
from understudy.sim.world import World
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session

LIBRARIES = collect_libraries(SCENARIO, ROBOTS)
SQUAD = LIBRARIES["patrol"]
LESSON = new_lesson(
    SQUAD,
    "lead",
    states=["out=wander", "attack=servo(intruder)", "home=servo(home)"],
    features=["all_done", "someone_done", "someone_sees(intruder)"],
    live=False,
)


def coordinator_body(seed: int = 5) -> CoordinatorBody:
    """The four robots of the patrol, and nobody above their coordinator."""
    return make_coordinator_body(SCENARIO, "patrol", LIBRARIES, seed=seed)


def list_activities(body: CoordinatorBody) -> list[tuple[str, ...]]:
    return body.team.paths


def teach_patrol(session: Session, seconds: float) -> None:
    """Press what a person would."""
    while session.body.time_s < seconds:
        view = session.view()
        seen = view.features
        if view.state == "start":
            session.direct("out")
        elif view.state == "out" and seen["someone_sees(intruder)"]:
            session.direct("attack")
        elif view.state == "attack" and seen["someone_done"]:
            session.direct("home")
        elif view.state == "home" and seen["all_done"]:
            session.direct("out")
        session.tick()


def test_directing_the_coordinator_moves_the_whole_squad() -> None:
    session = Session(coordinator_body(), SQUAD, LESSON)
    assert isinstance(session.body, CoordinatorBody)
    session.direct("out")
    session.tick()
    assert [path[0] for path in list_activities(session.body)] == ["wander"] * 4
    session.direct("attack")
    session.tick()
    assert [path[0] for path in list_activities(session.body)] == ["servo(intruder)"] * 4


def test_a_default_after_a_switch_has_the_flags_down() -> None:
    """Directing restarts the members, so the automatic default sees nobody done; what they see is as it was."""
    session = Session(coordinator_body(), SQUAD, LESSON)
    teach_patrol(session, 120.0)
    labels = [str(bound) for bound in session.automaton.features]
    someone, all_there = labels.index("someone_done"), labels.index("all_done")
    shown = {(example.state, example.next): example for example in session.examples}
    assert shown["attack", "home"].values[someone] == 1.0
    after = shown["home", "home"]
    assert after.kind is ExampleKind.DEFAULT
    assert (after.values[someone], after.values[all_there]) == (0.0, 0.0)
    assert after.values[2] == shown["attack", "home"].values[2]


def test_what_was_learned_leads() -> None:
    session = Session(coordinator_body(), SQUAD, LESSON)
    teach_patrol(session, 200.0)
    session.reset(11)
    session.test()
    states = set()
    while session.body.time_s < 120.0:
        session.tick()
        states.add(session.view().state)
    assert {"out", "attack", "home"} <= states


def test_a_troop_is_rewound() -> None:
    """World, orders, what everybody does and what is remembered; and it goes on as it did."""
    session = Session(coordinator_body(), SQUAD, LESSON)
    assert isinstance(session.body, CoordinatorBody)
    teach_patrol(session, 40.0)
    instant, before = session.capture(), list_activities(session.body)
    teach_patrol(session, 60.0)
    after, there = list_activities(session.body), session.body.ground.sense([("blob_size", "home")])
    examples = session.examples
    session.rewind(instant)
    assert list_activities(session.body) == before
    assert session.examples == examples
    teach_patrol(session, 60.0)
    assert list_activities(session.body) == after
    again = session.body.ground.sense([("blob_size", "home")])
    assert again["blob_size", "home"].tolist() == pytest.approx(
        there["blob_size", "home"].tolist(), nan_ok=True
    )


@pytest.mark.parametrize(
    "snapshot", [b"\x81\xa4more" + b"\x91" * 3000 + b"\x90", b"\x81\xa1\xff\xc0", b"no snapshot"]
)
def test_a_damaged_snapshot_is_refused(snapshot: bytes) -> None:
    with pytest.raises(FileError, match="is not a snapshot of a squad"):
        coordinator_body().restore(snapshot)


def test_going_back_restarts_nobody_whose_messages_are_delayed() -> None:
    """What was in the air is lost, but who has an order goes on with it."""
    slow = msgspec.structs.replace(SCENARIO, radio=CommsSpec(delay_s=0.3))
    body = make_coordinator_body(slow, "patrol", LIBRARIES, seed=5)
    session = Session(body, SQUAD, LESSON)
    teach_patrol(session, 3.0)
    assert session.view().state == "out"
    instant, began = session.capture(), body.squads.ordering.answering.tolist()
    assert not any(each != each for each in began)
    teach_patrol(session, 3.5)
    session.rewind(instant)
    starts: list[object] = []
    body.team.layers[0].runner.begin = lambda agents, program: starts.append(agents)  # type: ignore[method-assign]
    teach_patrol(session, 3.5)
    assert starts == []
    assert body.squads.ordering.answering.tolist() == began


def test_a_killed_session_of_a_squad_goes_on(tmp_path: Path) -> None:
    journal = tmp_path / "lead.journal"
    session = Session(coordinator_body(), SQUAD, LESSON, journal=journal)
    assert isinstance(session.body, CoordinatorBody)
    teach_patrol(session, 60.0)
    examples, path, robots = session.examples, session.view().path, list_activities(session.body)
    session.close()
    body = coordinator_body()
    resumed = Session.resume(journal, body, SQUAD)
    assert resumed.examples == examples
    assert resumed.view().path == path
    assert [each[0] for each in list_activities(body)] == [each[0] for each in robots]
    resumed.close()


def test_what_members_do_not_know_cannot_be_chosen() -> None:
    """What a lesson names, members must know before anything runs."""
    kit = make_squad_kit(
        assign_team_members(SCENARIO).squads[0][0],
        World(SCENARIO, [0]).readings,
        {"pioneer": Library(ROBOTS.kit)},
    )
    assert "servo" not in kit.behaviors
    assert {
        reading.name
        for reading in list_squad_readings(
            assign_team_members(SCENARIO).squads[0][0], World(SCENARIO, [0]).readings
        )
    }


def test_a_squad_refuses_readings_that_it_does_not_have() -> None:
    body = coordinator_body()
    with pytest.raises(UnknownName, match="squad 'patrol' has no reading 'all_gone'"):
        body.sense([("all_gone", None)])
    with pytest.raises(SettingError, match="reading 'someone_sees' needs a target; give one of "):
        body.sense([("someone_sees", None)])
    with pytest.raises(SettingError, match="reading 'all_done' takes no target, and 'home' is given"):
        body.sense([("all_done", "home")])
