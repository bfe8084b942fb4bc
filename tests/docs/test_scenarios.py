"""The page on scenarios: its example is one, and its tables are those of the code."""

from __future__ import annotations

import tomllib

import numpy as np
from tests.docs.pages import ROOT, blocks
from tests.docs.renew import between
from tests.docs.scenario_keys import KEYS, PAGE, PARTS, own_fields, table

from understudy.sim.kit import make_scenario_kit
from understudy.sim.layout.breakdowns import draw_failure_ticks
from understudy.sim.layout.placement import lay_out_worlds
from understudy.sim.params import make_world_params
from understudy.sim.scenario.files import parse_scenario, read_scenario_text
from understudy.sim.scenario.squad_schema import StrictStruct
from understudy.sim.team.assignment import assign_team_members

EXAMPLES = ROOT / "docs" / "scenarios.md"
RENEW = "the keys changed; bring the page up to date with: python -m tests.docs.scenario_keys"


def test_the_example_is_a_scenario() -> None:
    example, *_ = (block for block in blocks(EXAMPLES) if block.language == "toml")
    scenario = parse_scenario(example.text)
    assert scenario.name == tomllib.loads(example.text)["name"]
    make_scenario_kit(scenario)
    lay_out_worlds(scenario, make_world_params(scenario), np.arange(1000))


def test_the_squads_shown_are_those_of_the_patrol_and_can_be() -> None:
    """First those that ship, then others for the same robots."""
    _, shipped, others, *_ = (block.text for block in blocks(EXAMPLES) if block.language == "toml")
    whole = read_scenario_text("patrol")
    assert shipped in whole
    assign_team_members(parse_scenario(whole.replace("count = 4", "count = 13").replace(shipped, others)))


def test_the_boxes_shown_are_those_that_ship() -> None:
    """Line by line, but for what the targets are in words; their headings too."""
    *_, shown = (block.text for block in blocks(EXAMPLES) if block.language == "toml")
    whole = read_scenario_text("boxes").splitlines()
    for line in filter(None, shown.splitlines()):
        assert any(each.startswith(line.removesuffix(" }")) for each in whole), line


def test_the_tables_are_those_of_the_code() -> None:
    assert between(PAGE, KEYS) == table(), RENEW


def test_every_key_is_described() -> None:
    def sorts(part: type[StrictStruct]) -> list[type[StrictStruct]]:
        return [part, *(sort for below in part.__subclasses__() for sort in sorts(below))]

    # Robot files are made of such parts too.
    of_worlds = {part for part in sorts(StrictStruct) if part.__module__.startswith("understudy.sim.")}
    assert set(PARTS) == of_worlds - {StrictStruct}
    for part, (_, rows) in PARTS.items():
        assert list(rows) == [field.encode_name for field in own_fields(part)]


def test_the_breakdowns_shown_are_drawn_as_the_page_says() -> None:
    (shown,) = (
        block.text for block in blocks(EXAMPLES) if block.language == "toml" and "fails" in block.text
    )
    head = 'understudy = "scenario"\nversion = 1\nname = "shown"\nsize = [10.0, 10.0]\n\n[types.scout]\n\n'
    scenario = parse_scenario(head + shown)
    ticks = draw_failure_ticks(scenario, np.arange(200))
    assert ((ticks[:, 2] >= 0) & (ticks[:, 2] <= 1200)).all()
    others = ticks[:, [0, 1, 3]]
    assert (others >= 0).sum(axis=1).max() == 1
    assert others[others >= 0].min() >= 200
    assert others[others >= 0].max() <= 900
