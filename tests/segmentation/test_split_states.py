"""Splits of states: a state that ends in two ways for a reason that no feature tells is found, and split in two."""

from __future__ import annotations

import numpy as np
import pytest
from tests.segmentation.drives import follow, make_drive

from understudy.addons.recordings.drive_kit import make_candidates, make_drive_kit
from understudy.addons.recordings.lesson_from_drive import DriveLesson, to_lesson
from understudy.addons.recordings.segment import Segmentation, segment
from understudy.addons.recordings.split_states import propose_splits, split_state
from understudy.errors import DefinitionError, UnknownName
from understudy.learning.fit import learn_automaton
from understudy.learning.report import learn_and_report
from understudy.model.library import Library

MOVES = {"forward": {"drive": 0.8}, "back": {"drive": -0.4}, "left": {"turn": 0.7}}
AIMS = {name: (each.get("drive", 0.0), each.get("turn", 0.0)) for name, each in MOVES.items()}


def drive_along_walls(seed: int, *, by_chance: bool = False) -> tuple[Segmentation, DriveLesson]:
    """A driver who backs off from a wall and then turns, or, after a turn to a near wall, drives on.

    The reading is the range of the wall ahead, which is near or far after a turn. If it goes `by_chance`, what follows
    on backing off does not depend on what was before.
    """
    random = np.random.default_rng(seed)
    state, former, since, wall, ranges, aims = "forward", "start", 0, 3.0, list[float](), []
    for tick in range(2000):
        age, after = tick - since, state
        if state == "forward" and wall < 1.0:
            after = "back"
        elif state == "back" and wall > 1.5:
            turns = random.random() < 0.5 if by_chance else former == "forward"
            after = "left" if turns else "forward"
        elif state == "left" and age == 5:
            wall = float(random.choice([0.8, 3.0]))
        elif state == "left" and age > 12:
            after = "forward" if wall > 2.0 else "back"
        if after != state:
            former, state, since = state, after, tick
        aims.append(AIMS[state])
        ranges.append(wall + 0.01 * random.standard_normal())
        wall -= 0.1 * AIMS[state][0]
    drive = make_drive(follow(aims, seed=seed), {("range", None): np.array(ranges)})
    library = Library(make_drive_kit(drive, MOVES))
    found = segment(drive, make_candidates(library, drive))
    return found, to_lesson(found, library=library, reaction_s=0.0)


def test_the_state_that_needs_a_second_one_is_found() -> None:
    found, made = drive_along_walls(1)
    (proposal,) = propose_splits(made.lesson)
    assert (proposal.state, proposal.entered_from) in [("back", ("left",)), ("back", ("forward",))]
    assert proposal.wrong_together >= 0.25 * proposal.stays
    assert proposal.wrong_apart <= 0.1 * proposal.stays
    assert "no feature tells why" in str(proposal)
    split = split_state(found, proposal.state, proposal.entered_from)
    again = to_lesson(split, library=made.library, reaction_s=0.0)
    automaton = learn_automaton(again.lesson)
    assert [(state.name, state.behavior) for state in automaton.states][-1] == ("back_2", "back")
    assert propose_splits(again.lesson) == (), "no further split is needed"
    before, after = (
        sum(state.nodes for state in learn_and_report(each.lesson).states.values()) for each in (made, again)
    )
    assert after < before, "what contradicted itself needs no cells any more"


@pytest.mark.parametrize("seed", range(8))
def test_what_is_chance_is_not_split(seed: int) -> None:
    _found, made = drive_along_walls(seed, by_chance=True)
    assert propose_splits(made.lesson) == ()


def test_a_split_by_hand() -> None:
    """Labels 0 1 0 2 1 0 in spans of 30 ticks: the label 1 after 2 becomes another one, 3; what is unexplained is 4."""
    aims = [
        AIMS[name] for name in ("forward", "back", "forward", "left", "back", "forward") for _ in range(30)
    ]
    drive = make_drive(follow(aims, gain=1.0), {("range", None): np.ones(180)}, lengths=(150, 30))
    library = Library(make_drive_kit(drive, MOVES))
    found = segment(drive, make_candidates(library, drive))
    assert found.labels[15::30].tolist() == [0, 1, 0, 2, 1, 0]
    split = split_state(found, "back", ["left"])
    assert split.names == ("forward", "back", "left", "back_2", "unexplained")
    assert split.labels[15::30].tolist() == [0, 1, 0, 2, 3, 0]
    assert split.certainties.tolist() == found.certainties.tolist()
    assert split_state(split, "forward", ["start"]).labels[15::30].tolist() == [4, 1, 0, 2, 3, 4]
    with pytest.raises(DefinitionError, match="never entered from back"):
        split_state(found, "left", ["back"])
    with pytest.raises(DefinitionError, match="always entered from forward and left"):
        split_state(found, "back", ["left", "forward"])
    with pytest.raises(UnknownName, match="no state 'right'; it has forward, back and left"):
        split_state(found, "back", ["right"])
