"""The swarm: many platoons are like a few, and what is written by hand pulls boxes together."""

from __future__ import annotations

from understudy.worlds.swarm import of_platoons, scenario


def test_eight_platoons_are_the_swarm_that_ships() -> None:
    assert of_platoons(8) == scenario()
