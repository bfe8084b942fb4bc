"""The page on teams: what it shows of scenarios is theirs, and what is sent is as it says."""

from __future__ import annotations

import pytest
from tests.docs.pages import blocks
from tests.docs.renew import between
from tests.docs.traffic import LEVELS, PAGE, SIZE, TRAFFIC, measure_traffic, table

from understudy.runtime.team.comms import FLAG_BYTES, ORDER_BYTES, READING_BYTES, REPORT_BYTES
from understudy.sim.scenario.files import read_scenario_text

MEMBER_BYTES = ORDER_BYTES + REPORT_BYTES + READING_BYTES + FLAG_BYTES
RENEW = "what is sent changed; bring the page up to date with: python -m tests.docs.traffic"


def test_the_squads_shown_are_those_that_ship() -> None:
    garrison, crew = (block.text for block in blocks(PAGE) if block.language == "toml")
    assert garrison in read_scenario_text("regions")
    assert all(line in read_scenario_text("salvage") for line in crew.splitlines())


def test_the_table_of_what_is_sent() -> None:
    assert between(PAGE, TRAFFIC) == table(), RENEW


@pytest.mark.parametrize("levels", range(1, LEVELS + 1))
def test_what_is_sent_has_a_closed_form(levels: int) -> None:
    """Everybody but the topmost is somebody's member: of N robots in squads of s, s(N - 1)/(s - 1)."""
    found = measure_traffic(levels)
    robots = SIZE**levels
    members = SIZE * (robots - 1) // (SIZE - 1)
    assert sum(each.messages for each in found) == 2 * members
    assert sum(each.bytes for each in found) == MEMBER_BYTES * members
    assert (found[-1].messages, found[-1].bytes) == (2 * SIZE, MEMBER_BYTES * SIZE)
