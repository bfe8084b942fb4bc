"""The page on scenarios: its example is one, and its tables are those of the code."""

from __future__ import annotations

import tomllib

import numpy as np
from tests.docs.pages import blocks
from tests.docs.renew import between
from tests.docs.scenario_keys import KEYS, PAGE, PARTS, own_fields, table

from understudy.sim.kit import kit_of
from understudy.sim.layout.placement import lay_out
from understudy.sim.params import rules_of
from understudy.sim.scenario.files import parse_scenario, scenario_text
from understudy.sim.scenario.squad_schema import Part
from understudy.sim.team.assignment import deal

RENEW = "the keys changed; bring the page up to date with: python -m tests.docs.scenario_keys"


def test_the_example_is_a_scenario() -> None:
    example, *_ = (block for block in blocks(PAGE) if block.language == "toml")
    scenario = parse_scenario(example.text)
    assert scenario.name == tomllib.loads(example.text)["name"]
    kit_of(scenario)
    lay_out(scenario, rules_of(scenario), np.arange(1000))


def test_the_squads_shown_are_those_of_the_patrol_and_can_be() -> None:
    """First those that ship, then others for the same robots."""
    _, shipped, others, _ = (block.text for block in blocks(PAGE) if block.language == "toml")
    whole = scenario_text("patrol")
    assert shipped in whole
    deal(parse_scenario(whole.replace("count = 4", "count = 13").replace(shipped, others)))


def test_the_boxes_shown_are_those_that_ship() -> None:
    """Line by line, but for what the targets are in words; their headings too."""
    *_, shown = (block.text for block in blocks(PAGE) if block.language == "toml")
    whole = scenario_text("boxes").splitlines()
    for line in filter(None, shown.splitlines()):
        assert any(each.startswith(line.removesuffix(" }")) for each in whole), line


def test_the_tables_are_those_of_the_code() -> None:
    assert between(PAGE, KEYS) == table(), RENEW


def test_every_key_is_described() -> None:
    def sorts(part: type[Part]) -> list[type[Part]]:
        return [part, *(sort for below in part.__subclasses__() for sort in sorts(below))]

    # Robot files are made of such parts too.
    of_worlds = {part for part in sorts(Part) if part.__module__.startswith("understudy.sim.")}
    assert set(PARTS) == of_worlds - {Part}
    for part, (_, rows) in PARTS.items():
        assert list(rows) == [field.encode_name for field in own_fields(part)]
