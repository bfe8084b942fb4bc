"""As fast as possible: the world runs ahead, and pages are heard, moments kept and presses journaled all the same."""

from __future__ import annotations

import asyncio
import json
from itertools import pairwise
from pathlib import Path

import pytest
from tests.make.studios import GOTO, Wall, make_studio, open_page, serve_studio
from tests.ui.web.simulated_pages import LONGEST_S, SimulatedPage, SimulatedTime, connect_pages

from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.training.journal import TicksLogged, read_journal
from understudy.ui.controller.clock import BUSY_S
from understudy.ui.web.rewind import EVERY_S
from understudy.ui.web.server import StudioServer
from understudy.ui.web.session_host import SessionHost

MOST_BEATS = 2
"""How many beats of about 1/60 s may begin before a press is answered: well within 50 ms."""
TICKS = 20
"""What fits into a beat by the wall of these tests."""
BEATS = 12


def test_ticks_fill_the_beat_and_all_of_them_are_kept(tmp_path: Path) -> None:
    made = make_studio(tmp_path, wall=Wall(glance=BUSY_S / TICKS / 2))
    viewer = made.connect(None)

    def say(do: str, **fields: object) -> None:
        made.handle_text(viewer, json.dumps({"id": 1, "do": do, **fields}))
        sent = [json.loads(text) for text, binary in iter(viewer.next, None) if not binary]
        assert {"re": 1, "ok": True}.items() <= sent[0].items(), sent

    made.handle_text(viewer, json.dumps({"id": 1, **GOTO}))
    while viewer.next() is not None:
        pass
    say("press", state="forward")
    say("speed", speed="fastest")
    world, opened = made.host.world, made.host.open_session
    assert opened is not None
    ticks = [0]
    for _ in range(BEATS):
        made.run_due_ticks()
        ticks.append(int(world.state.tick[0]))
    assert all(abs(after - before - TICKS) <= 1 for before, after in pairwise(ticks)), ticks
    now = world.time_s
    say("rewind", time_s=now - 4.2)
    assert now - 4.2 - EVERY_S <= world.time_s <= now - 4.2 + 1e-6
    made.host.open_session = None
    opened.close()
    written = [entry.rows.count for entry in read_journal(opened.journal) if isinstance(entry, TicksLogged)]
    assert sum(written) == ticks[-1]


def test_pages_are_told_in_a_word(tmp_path: Path) -> None:
    with serve_studio(make_studio(tmp_path)) as client, open_page(client) as somebody:
        somebody.done("speed", speed="fastest")
        while somebody.news["speed"] != "fastest":
            somebody.hear()


@pytest.mark.parametrize("speed", ["faster", 17.0, -1.0, True, None])
def test_other_speeds_are_refused(tmp_path: Path, speed: object) -> None:
    with serve_studio(make_studio(tmp_path)) as client, open_page(client) as somebody:
        assert "error" in somebody.say("speed", speed=speed)


@pytest.mark.parametrize("world", ["forage", "soccer"])
def test_a_press_is_heard_between_beats(tmp_path: Path, world: str) -> None:
    scenario, time = find_scenario(world), SimulatedTime(glance=BUSY_S / TICKS / 2)
    kit = make_scenario_kit(scenario)
    behavior = next(iter(kit.behaviors))

    async def press() -> list[int]:
        made = StudioServer(SessionHost(scenario, tmp_path, kit, wall=time), wall=time, wait=time.wait)
        person = SimulatedPage(time)
        async with connect_pages(made, person):
            await person.say("new", name="a", states=[behavior], features=["time_in_state"])
            await person.say("press", state=behavior)
            await person.say("speed", speed="fastest")
            waits = []
            for _ in range(BEATS):
                waits.append((await person.say("confirm"))[1])
                await person.hear_frame()
            assert made.host.world.state.tick[0] > (BEATS - 1) * TICKS / 2
            return waits

    waits = asyncio.run(asyncio.wait_for(press(), LONGEST_S))
    assert max(waits) <= MOST_BEATS, waits
