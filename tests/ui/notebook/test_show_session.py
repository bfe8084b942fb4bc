"""`show_session` in a kernel's event loop, without a browser: what a widget sends and receives."""

from __future__ import annotations

import asyncio
import json
import re
import struct
import sys
from collections.abc import Callable, Coroutine
from functools import wraps
from typing import TYPE_CHECKING, Any

import pytest
from tests.ui.notebook.sessions import VIEW, make_goto_session

import understudy.ui.notebook
from understudy.errors import SessionError
from understudy.extras import ExtraMissing
from understudy.ui.notebook import show_session

if TYPE_CHECKING:
    from understudy.ui.notebook.session_widget import SessionWidget


def in_loop(test: Callable[[], Coroutine[Any, Any, None]]) -> Callable[[], None]:
    """Run a test in an event loop, as a kernel runs cells."""

    @wraps(test)
    def run() -> None:
        pytest.importorskip("anywidget", reason="needs the extra notebook")
        asyncio.run(test())

    return run


async def until(widget: SessionWidget, condition: Callable[[], bool]) -> None:
    """Wait until something holds, which changes what is sent to the page."""
    changed = asyncio.Event()
    widget.observe(lambda _: changed.set())
    async with asyncio.timeout(60):
        while not condition():
            await changed.wait()
            changed.clear()


def send(widget: SessionWidget, **content: str) -> None:
    """Send what a page sends, as it arrives."""
    widget._handle_custom_msg(content, [])


@in_loop
async def test_a_press_in_the_page_reaches_the_session_and_comes_back() -> None:
    session = make_goto_session()
    widget = show_session(session, speed=16.0)
    send(widget, **VIEW)
    send(widget, action="press", state="rotate_left")
    await until(widget, lambda: len(session.examples) == 2)
    await until(widget, lambda: bool(widget.moment["state"] == "rotate_left"))
    assert widget.panel["examples"] == 2
    assert widget.panel["status"]["tone"] == "recorded"
    assert [each["name"] for each in widget.lesson["states"]][:3] == ["start", "forward", "rotate_left"]
    assert [each["key"] for each in widget.lesson["states"]] == ["0", "1", "2", "3", "4"]
    widget.close()


@in_loop
async def test_what_is_sent_is_plain() -> None:
    widget = show_session(make_goto_session())
    for data in (widget.arena, widget.lesson, widget.panel, widget.moment, widget.objects):
        json.dumps(data, allow_nan=False)
    x, y, heading, stored = struct.unpack("<4f", widget.robots)
    robot = widget.session.body.state.robots[0]  # type: ignore[attr-defined]
    assert (x, y, heading) == pytest.approx((robot["x"], robot["y"], robot["heading"]), rel=1e-6)
    assert stored == 0.0
    assert widget.trail == b""
    widget.close()


@in_loop
async def test_conditions_are_numbered_as_in_the_picture() -> None:
    session = make_goto_session()
    widget = show_session(session)
    for state in ("rotate_left", "forward", "rotate_left", "forward", "done"):
        session.direct(state)
        session.run_for(0.5)
    await until(widget, lambda: len(widget.lesson["transitions"]) == 4)
    transitions = widget.lesson["transitions"]
    drawn = re.search(r"Transitions: (.*)\.</desc>", widget.lesson["svg"])
    assert drawn is not None
    ways = [part.partition(" when ")[0] for part in drawn[1].split("; ")]
    assert ways == [f"from {each['from']} to {each['to']}" for each in transitions]
    for each in transitions:
        assert f'fill="{each["color"]}">{each["number"]}</text>' in widget.lesson["svg"]
    for state in session.automaton.state_names:
        assert f'data-state="{state}"' in widget.lesson["svg"]
    widget.close()


@in_loop
async def test_a_session_has_one_widget() -> None:
    """Two would run its world twice as fast."""
    session = make_goto_session()
    widget = show_session(session)
    assert show_session(session) is widget
    assert show_session(make_goto_session()) is not widget
    widget.close()
    send(widget, **VIEW)
    again = show_session(session)
    assert again is not widget
    again.close()


@in_loop
async def test_a_closed_widget_leaves_the_session_alone() -> None:
    session = make_goto_session()
    widget = show_session(session, speed=16.0)
    send(widget, **VIEW)
    await until(widget, lambda: session.body.time_s > 0)
    widget.close()
    time_s = session.body.time_s
    async with asyncio.timeout(60):
        await asyncio.gather(*asyncio.all_tasks() - {asyncio.current_task()}, return_exceptions=True)
    assert session.body.time_s == time_s
    session.direct("forward")
    session.run_for(0.2)
    assert len(session.examples) == 2


def test_outside_a_notebook_it_says_so() -> None:
    pytest.importorskip("anywidget", reason="needs the extra notebook")
    with pytest.raises(SessionError, match="works in a cell of a notebook only"):
        show_session(make_goto_session())


def test_without_anywidget_it_names_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "understudy.ui.notebook.session_widget", raising=False)
    monkeypatch.delattr(understudy.ui.notebook, "session_widget", raising=False)
    monkeypatch.setitem(sys.modules, "anywidget", None)
    with pytest.raises(
        ExtraMissing, match=r"a session in a notebook needs .*'understudy-robots\[notebook\]'"
    ):
        show_session(make_goto_session())
