"""The layout for Foxglove names only topics and fields that a recording of these robots has."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

pytest.importorskip("rosbags", reason="needs the extra ros2")
pytest.importorskip("mcap", reason="needs the extra ros2")

from tests.robots.rovers import Wire
from tests.robots.twins import ARENA

from understudy.addons.robots.fleet import Fleet
from understudy.addons.robots.foxglove_layout import make_layout
from understudy.addons.robots.recording_transport import RecordingTransport
from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import parse_robot
from understudy.addons.robots.twin import DigitalTwin
from understudy.records.header import RunInfo
from understudy.records.messages import list_message_fields
from understudy.records.recorder import RunRecorder
from understudy.runtime.body import list_reading_keys
from understudy.ui.cli.main import make_command_line

MORE = "[frames]\n[diagnostics]\npublish = true\n[commands]"
TEXT = re.sub(r"\[readings\].*?\n\n", "", ARENA, flags=re.DOTALL).replace("[commands]", MORE)
FILES = [parse_robot(TEXT.format(name=name, world="arena")) for name in ("one", "two")]


def record(path: Path) -> dict[str, str]:
    """Record a tick of both robots; return the type of each topic of the recording."""
    with RunRecorder(path) as recorder:
        robots = [Robot(file, RecordingTransport(Wire(), recorder)) for file in FILES]
        twin = DigitalTwin(Fleet(robots), recorder=recorder)
        twin.follow(lambda: [("go", "forward"), ()])
        twin.record(RunInfo())
        twin.sense(list_reading_keys(twin))
        twin.act({"drive": np.zeros(2)})
    from mcap.reader import make_reader

    with path.open("rb") as file:
        summary: Any = make_reader(file).get_summary()
    return {each.topic: summary.schemas[each.schema_id].name for each in summary.channels.values()}


def list_values(part: Any) -> Iterator[str]:
    """List all texts of a layout that begin with a slash, and keys that do: topics and paths in messages."""
    if isinstance(part, dict):
        for key, value in part.items():
            yield from list_values(key)
            yield from list_values(value)
    elif isinstance(part, list):
        for value in part:
            yield from list_values(value)
    elif isinstance(part, str) and part.startswith("/"):
        yield part


def find_element(of: Any) -> str:
    """Find the type of what is in a field, or of each in a row of them; nothing for numbers and texts."""
    inner = of[0][1] if isinstance(of, tuple) and isinstance(of[0], tuple) else of
    return inner if isinstance(inner, str) else ""


def test_every_topic_and_field_is_in_a_recording(tmp_path: Path) -> None:
    topics = record(tmp_path / "run.mcap")
    named = set(list_values(make_layout(FILES)))
    for value in named:
        topic, *fields = re.sub(r"\[.*?\]|\{.*?\}", "", value).split(".")
        assert topic in topics, value
        of = topics[topic]
        for field in fields:
            inside = list_message_fields(of)
            assert field in inside, value
            of = find_element(inside[field][1])
    assert {"/tf", "/tf_static", "/diagnostics", "/one/understudy/stopped.data"} <= named
    assert '/two/understudy/readings.readings[:]{name=="y"}.value' in named


def test_every_panel_is_shown_once() -> None:
    layout = make_layout(FILES)
    shown = re.findall(r'"([\w]+![\w]+)"', json.dumps(layout["layout"]))
    assert sorted(shown) == sorted(layout["configById"])
    assert {panel.partition("!")[0] for panel in shown} == {
        "3D",
        "Plot",
        "StateTransitions",
        "RawMessages",
        "DiagnosticSummary",
    }


def test_the_command_prints_it(tmp_path: Path) -> None:
    file = tmp_path / "one.toml"
    file.write_text(TEXT.format(name="one", world="arena"))
    done = CliRunner().invoke(make_command_line(), ["robots", "layout", str(file)])
    assert json.loads(done.stdout) == json.loads(json.dumps(make_layout(FILES[:1])))
