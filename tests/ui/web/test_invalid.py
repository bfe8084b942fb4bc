"""A message that cannot be obeyed changes nothing, and its answer says what was wrong."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.make.studios import GOTO, make_studio

from understudy.addons.robots.twin import find_drawn_world
from understudy.ui.web.actions.handler_table import HANDLERS
from understudy.ui.web.clients import Client
from understudy.ui.web.messages import session as m
from understudy.ui.web.messages.base import Message
from understudy.ui.web.server import StudioServer


class Room:
    """A studio with a lesson begun and a page that directs, without a network between them."""

    def __init__(self, folder: Path) -> None:
        self.studio: StudioServer = make_studio(folder)
        self.viewer: Client = self.studio.connect(None)
        self.say(GOTO)
        self.say({"do": "pause", "paused": True})
        for state in ("forward", "rotate_left", "forward"):
            self.say({"do": "press", "state": state})
            self.say({"do": "step"})
        self.say({"do": "save"})

    def say(self, message: Any, *, number: int = 1) -> dict[str, Any]:
        answer = self.hear(json.dumps({"id": number, **message}))
        assert answer.get("ok"), answer
        return answer

    def hear(self, text: str | bytes) -> dict[str, Any]:
        while self.viewer.next():
            pass
        self.studio.handle_text(self.viewer, text)
        found = self.viewer.next()
        assert found is not None
        answer: dict[str, Any] = json.loads(found[0])
        assert "re" in answer
        return answer

    def state(self) -> tuple[object, ...]:
        """Everything that a message could change."""
        host = self.studio.host
        session = host.active_trainer.session
        files = {path: path.stat().st_size for path in sorted(host.library_view.folder.rglob("*"))}
        return (
            find_drawn_world(host.world).snapshot(),
            session.lesson.record,
            repr((session.automaton, session.examples)),  # absent values are not equal to themselves
            repr(session.view()),
            session.mode,
            session.run_state,
            host.paused,
            host.speed,
            host.status,
            session.is_watching,
            host.library(),
            self.studio.viewers.director,
            files,
        )


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Room]:
    made = Room(tmp_path_factory.mktemp("library"))
    yield made
    made.studio.host.close()


LONG = "x" * 151
BAD = [
    '{"do": "press"}',
    '{"id": 1}',
    '{"id": -1, "do": "undo"}',
    '{"id": 1.5, "do": "undo"}',
    '{"id": 1, "do": "undo", "extra": 1}',
    '{"id": 1, "do": "Undo"}',
    '{"id": 1, "do": ["undo"]}',
    "[]",
    "null",
    "",
    "{",
    '"\\ud800"',
    "[" * 10_000,
    '{"id": 1, "do": "press"}',
    '{"id": 1, "do": "press", "state": 3}',
    '{"id": 1, "do": "press", "state": ""}',
    '{"id": 1, "do": "press", "state": "nowhere"}',
    '{"id": 1, "do": "press", "state": "for\\nward"}',
    '{"id": 1, "do": "press", "state": "\\ud800"}',
    '{"id": 1, "do": "pause", "paused": 1}',
    '{"id": 1, "do": "speed", "speed": 3}',
    '{"id": 1, "do": "speed", "speed": 1e999}',
    '{"id": 1, "do": "speed", "speed": NaN}',
    '{"id": 1, "do": "reset", "seed": -1}',
    '{"id": 1, "do": "reset", "seed": 1e30}',
    '{"id": 1, "do": "bind_targets", "targets": {"B": "station"}}',
    '{"id": 1, "do": "bind_targets", "targets": {"A": "moon"}}',
    '{"id": 1, "do": "open", "name": "nobody", "discard": true}',
    '{"id": 1, "do": "open", "name": "../../secret", "discard": true}',
    '{"id": 1, "do": "new", "name": "goto", "states": ["forward"], "features": ["distance_to(station)"]}',
    '{"id": 1, "do": "new", "name": "GOTO", "states": ["forward"], "features": ["distance_to(station)"]}',
    '{"id": 1, "do": "new", "name": "forward", "states": ["forward"], "features": ["distance_to(station)"]}',
    '{"id": 1, "do": "new", "name": "a", "states": ["fly"], "features": ["distance_to(station)"]}',
    '{"id": 1, "do": "new", "name": "a", "states": ["a"], "features": ["distance_to(station)"]}',
    '{"id": 1, "do": "new", "name": "a", "states": ["forward"], "features": ["distance_to(A)"]}',
    '{"id": 1, "do": "new", "name": "a", "states": [], "features": []}',
    '{"id": 1, "do": "new", "name": "a", "states": ["forward", "forward"], "features": ["done"]}',
    '{"id": 1, "do": "change_design", "states": ["fly"], "features": []}',
    '{"id": 1, "do": "change_design", "states": ["forward"], "features": ["done"], "reaction_s": 7}',
    '{"id": 1, "do": "change_design", "states": ["forward"], "features": ["done"], "flags": ["forward"]}',
    '{"id": 1, "do": "delete", "number": 999}',
    '{"id": 1, "do": "edit", "number": 1, "next": "nowhere"}',
    '{"id": 1, "do": "edit", "number": 1, "state": "done"}',
    '{"id": 1, "do": "edit", "number": 1, "values": {"height": "3"}}',
    '{"id": 1, "do": "edit", "number": 1, "values": {"distance_to(A)": "far"}}',
    '{"id": 1, "do": "edit", "number": 1, "values": {"distance_to(A)": "inf"}}',
    '{"id": 1, "do": "save", "name": "../goto2\\u0000"}',
    '{"id": 1, "do": "save", "name": "forward"}',
    f'{{"id": 1, "do": "save", "name": "{LONG}"}}',
    '{"id": 1, "do": "remove", "name": "goto"}',
    '{"id": 1, "do": "remove", "name": "../library/goto"}',
    '{"id": 1, "do": "restore", "name": "nothing"}',
    '{"id": 1, "do": "discard", "name": "goto"}',
    '{"id": 1, "do": "recall", "name": "../goto"}',
    '{"id": 1, "do": "rename", "name": "goto", "to": "Goto"}',
    '{"id": 1, "do": "rename", "name": "goto", "to": "forward"}',
    '{"id": 1, "do": "rename", "name": "../library/goto", "to": "a"}',
    '{"id": 1, "do": "duplicate", "name": "goto", "to": "goto"}',
    '{"id": 1, "do": "duplicate", "name": "nobody", "to": "a"}',
    '{"id": 1, "do": "list_versions", "name": "../goto"}',
    '{"id": 1, "do": "diff_versions", "name": "goto", "version": 9}',
    '{"id": 1, "do": "diff_versions", "name": "goto", "version": 1, "to": 9}',
    '{"id": 1, "do": "add_property", "flag": "failed", "within_s": 5}',
    '{"id": 1, "do": "add_property", "flag": "done", "within_s": 0}',
    '{"id": 1, "do": "add_property", "flag": "done", "within_s": 1e9}',
    '{"id": 1, "do": "remove_property", "property": 0}',
    '{"id": 1, "do": "go_to_property", "property": 3}',
    '{"id": 1, "do": "test", "name": "../goto"}',
    '{"id": 1, "do": "simplify", "pruning": -1}',
    '{"id": 1, "do": "prune", "pruning": 1e400}',
    '{"id": 1, "do": "go_back", "name": "goto", "version": 9}',
    '{"id": 1, "do": "select_agent", "agent": 9}',
    '{"id": 1, "do": "select_agent", "agent": -1}',
    '{"id": 1, "do": "set_other_agents", "behavior": "forward"}',
    '{"id": 1, "do": "set_other_agents", "behavior": "goto", "targets": {"A": "moon"}}',
    '{"id": 1, "do": "toggle_watching"}',
    '{"id": 1, "do": "move_robot", "agent": 9, "x": 1, "y": 1}',
    '{"id": 1, "do": "move_robot", "agent": 0, "x": -1, "y": 1}',
    '{"id": 1, "do": "move_robot", "agent": 0, "x": 1, "y": "1"}',
    '{"id": 1, "do": "move_robot", "agent": 0, "x": 1, "y": 1, "heading": 1e400}',
    '{"id": 1, "do": "move_object", "slot": 200, "x": 1, "y": 1}',
    '{"id": 1, "do": "move_object", "slot": 0, "x": 100, "y": 1}',
    '{"id": 1, "do": "add_object", "kind": "cake", "x": 1, "y": 1}',
    '{"id": 1, "do": "remove_object", "slot": 77}',
    '{"id": 1, "do": "add_obstacle", "x": 1, "y": 1, "radius": 0}',
    '{"id": 1, "do": "add_obstacle", "x": 6, "y": 6, "radius": 40}',
    '{"id": 1, "do": "set_up", "sentence": "Show me how to fly."}',
    '{"id": 1, "do": "set_up", "sentence": ""}',
    '{"id": 1, "do": "set_query_policy", "policy": "always"}',
    '{"id": 1, "do": "go_to_mark", "number": 1}',
    '{"id": 1, "do": "set_reaction_time", "reaction_s": 7}',
    '{"id": 1, "do": "set_reaction_time", "reaction_s": -0.1}',
    '{"id": 1, "do": "change_design", "states": ["forward"], "features": ["done"], "unlearning": 1}',
    '{"id": 1, "do": "redo"}',
    '{"id": 1, "do": "undo"' + " " * 70_000 + "}",
    b'{"id": 1, "do": "undo"}',
    b"\xff\xfe",
]


@pytest.mark.parametrize("text", BAD, ids=lambda text: repr(text[:60]))
def test_it_changes_nothing(room: Room, text: str | bytes) -> None:
    before = room.state()
    answer = room.hear(text)
    assert room.state() == before
    assert "ok" not in answer
    assert 10 < len(answer["error"]) < 1_000
    assert "Understudy:" not in answer["error"]  # no fault of the program


NEW = '{"id": 1, "do": "new", "name": "a", "states": ["forward"], "features": ["done"], '
TYPED = [
    (f'{NEW} "flags": ["done", "{LONG}"]}}', "Flag 2 has more than 150 characters"),
    (f'{NEW} "parameters": ["{LONG}"]}}', "Parameter 1 has more than 150 characters"),
    (f'{NEW} "flags": {json.dumps(["x"] * 201)}}}', "The flags must be at most 200"),
    (f'{NEW} "targets": {{"{LONG}": "station"}}}}', "A parameter has more than 150 characters"),
    (
        f'{{"id": 1, "do": "rename", "name": "goto", "to": "{LONG}"}}',
        "The new name has more than 150 characters",
    ),
    ('{"id": 1, "do": "save", "name": ""}', "The name is empty"),
    ('{"id": 1, "do": "save", "name": "a\\nb"}', "The name has a character that cannot be printed"),
    ('{"id": 1, "do": "add_property", "flag": "done", "within_s": 0}', "The time must be above 0"),
    ('{"id": 1, "do": "add_property", "flag": "done", "within_s": 1e9}', "The time is more than 86400"),
    ('{"id": 1, "do": "add_property", "flag": "done", "within_s": "soon"}', "The time is not a number"),
    ('{"id": 1, "do": "reset", "seed": 1e30}', "The seed is not a whole number"),
    ('{"id": 1, "do": "reset", "seed": 9007199254740993}', "The seed is more than 9007199254740991"),
    (
        f'{{"id": 1, "do": "edit", "number": 1, "values": {{"done": "{LONG}"}}}}',
        "A value has more than 150 characters",
    ),
]


@pytest.mark.parametrize(("text", "sentence"), TYPED)
def test_what_a_person_can_type_is_refused_in_a_sentence(room: Room, text: str, sentence: str) -> None:
    assert room.hear(text)["error"].startswith(sentence)


def test_its_answer_says_which_it_was(room: Room) -> None:
    assert room.hear('{"id": 71, "do": "press"}')["re"] == 71
    assert room.hear('{"id": "71", "do": "press"}')["re"] is None


def test_every_message_has_an_action() -> None:
    tags = {kind.__struct_config__.tag for kind in Message.__subclasses__()}
    assert {kind.__struct_config__.tag for kind in HANDLERS} | {"take_control", "release_control"} == tags
    assert set(m.REQUESTS) == set(Message.__subclasses__())


VALID: list[dict[str, Any]] = [
    GOTO,
    *(
        {"do": do}
        for do in (
            "confirm",
            "toggle_mode",
            "undo",
            "redo",
            "step",
            "restart",
            "why",
            "take_control",
            "reset",
            "save",
        )
    ),
    {"do": "press", "state": "forward"},
    {"do": "pause", "paused": True},
    {"do": "speed", "speed": 2},
    {"do": "reset", "seed": 4},
    {"do": "bind_targets", "targets": {"A": "nearest_food"}},
    {"do": "open", "name": "goto", "discard": True},
    {"do": "change_design", "states": ["forward"], "features": ["done"], "flags": [], "watched": True},
    {"do": "delete", "number": 1},
    {"do": "edit", "number": 1, "next": "rotate_left"},
    {"do": "edit", "number": 1, "values": {"distance_to(A)": "3.5 m"}},
    {"do": "remove", "name": "goto"},
    {"do": "restore", "name": "goto"},
    {"do": "rename", "name": "goto", "to": "goto 2"},
    {"do": "duplicate", "name": "goto", "to": "goto 2"},
    {"do": "list_versions", "name": "goto"},
    {"do": "diff_versions", "name": "goto", "version": 1, "to": 2},
    {"do": "add_property", "flag": "done", "within_s": 2},
    {"do": "remove_property", "property": 0},
    {"do": "go_to_property", "property": 0},
    {"do": "test", "name": "goto"},
    {"do": "simplify", "pruning": 1},
    {"do": "prune", "pruning": 1},
    {"do": "go_back", "name": "goto", "version": 1},
    {"do": "select_agent", "agent": 0},
    {"do": "set_other_agents", "behavior": "goto", "targets": {"A": "station"}},
    {"do": "toggle_watching"},
    {"do": "move_robot", "agent": 0, "x": 3, "y": 3, "heading": 0},
    {"do": "move_object", "slot": 0, "x": 5, "y": 5},
    {"do": "add_object", "kind": "food", "x": 5, "y": 5},
    {"do": "remove_object", "slot": 0},
    {"do": "add_obstacle", "x": 2, "y": 2, "radius": 0.2},
    {"do": "move_obstacle", "index": 0, "x": 3, "y": 2},
    {"do": "remove_obstacle", "index": 0},
    {"do": "request_advice"},
    {"do": "set_query_policy", "policy": "pause"},
    {"do": "set_reaction_time", "reaction_s": 0.2},
]
ODD = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(2**70), 2**70),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(max_size=200),
    st.sampled_from(["../..", "/etc/passwd", "goto", "done", "A", "\x00", "start", "."]),
    st.lists(st.text(max_size=5), max_size=3),
    st.dictionaries(st.text(max_size=5), st.text(max_size=5), max_size=2),
)


@st.composite
def draw_mutated(draw: st.DrawFn) -> str:
    """A valid message with a field changed, added or taken away, or its text cut or changed."""
    message = {"id": 1, **draw(st.sampled_from(VALID))}
    for _ in range(draw(st.integers(1, 2))):
        way = draw(st.sampled_from(["change", "add", "drop", "none"]))
        key = draw(st.sampled_from(sorted(message))) if message else "id"
        if way == "change":
            message[key] = draw(ODD)
        elif way == "add":
            message[
                draw(st.one_of(st.sampled_from(["name", "state", "x", "discard"]), st.text(max_size=8)))
            ] = draw(ODD)
        elif way == "drop":
            message.pop(key, None)
    text = json.dumps(message)
    if draw(st.booleans()):
        at = draw(st.integers(0, len(text)))
        text = text[:at] + draw(st.text(max_size=3)) + text[at + draw(st.integers(0, 5)) :]
    return text


@pytest.mark.long
@settings(max_examples=300, suppress_health_check=list(HealthCheck))
@given(text=draw_mutated())
def test_mutated_messages(room: Room, text: str) -> None:
    check_answer(room, text)


@pytest.mark.soak
@settings(max_examples=10_000, suppress_health_check=list(HealthCheck))
@given(text=draw_mutated())
def test_ten_thousand_mutated_messages(room: Room, text: str) -> None:
    check_answer(room, text)


def check_answer(room: Room, text: str) -> None:
    """Obeyed, or refused without a trace; never an internal error."""
    before = room.state()
    outside = sorted(room.studio.host.library_view.folder.parent.iterdir())
    answer = room.hear(text)
    if "ok" not in answer:
        assert room.state() == before
        assert "Understudy:" not in answer["error"]
    assert sorted(room.studio.host.library_view.folder.parent.iterdir()) == outside
    if room.studio.host.trainer is None:
        room.say({**GOTO, "discard": True})


def test_messages_of_a_length_are_refused_before_they_are_read() -> None:
    with pytest.raises(m.InvalidMessage, match="longer"):
        m.parse_message(json.dumps({"id": 1, "do": "undo", "x": "é" * 40_000}))
    assert isinstance(m.parse_message(msgspec.json.encode({"id": 1, "do": "undo"})), m.Undo)
