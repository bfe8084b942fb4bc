"""Live teaching: what each press records and what the robot does next, as tables (docs/semantics.md, "Live teaching").

The ball is 100 m away at first, and one meter nearer each tick of 0.1 s.
"""

from __future__ import annotations

from dataclasses import replace
from math import nan
from pathlib import Path
from typing import Any

import pytest
from tests.bodies import RANGE, Scripted, kit
from tests.make.sessions import ROBOT, WITH_GO, list_rows, make_session, play, ticks

from understudy.model.features import ReadingsView, feature
from understudy.model.learner_options import LearnerOptions
from understudy.model.library import Library
from understudy.model.value_kinds import Column, Continuous
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session
from understudy.training.trainee import Mode


def live(*steps: str | int, **choice: Any) -> Session:
    """A session in live teaching, after some steps."""
    taught = make_session(flags=["done"], **choice)
    taught.teach()
    return play(taught, *steps)


PRESSES: list[tuple[list[Any], list[tuple[Any, ...]], str]] = [
    ([3], [], "start"),  # nothing was shown: it does nothing
    (  # a press acts at the next tick, and ends nothing
        ["forward", 3],
        [("start", 100, "forward", "directive"), ("forward", 100, "forward", "default")],
        "forward",
    ),
    (  # one example leads to forward at once after a restart, without a press
        ["forward", 3, "restart", 1],
        [("start", 100, "forward", "directive"), ("forward", 100, "forward", "default")],
        "forward",
    ),
    (  # what it would do anyway is kept as evidence
        ["forward", 3, "restart", "forward", 1],
        [
            ("start", 100, "forward", "directive"),
            ("forward", 100, "forward", "default"),
            ("start", 97, "forward", "directive"),
            ("forward", 97, "forward", "default"),
        ],
        "forward",
    ),
    (  # a press for the state in which it is confirms it
        ["forward", 2, "forward", 1],
        [
            ("start", 100, "forward", "directive"),
            ("forward", 100, "forward", "default"),
            ("forward", 98, "forward", "confirmation"),
        ],
        "forward",
    ),
]


@pytest.mark.parametrize(("steps", "expected", "state"), PRESSES)
def test_presses(steps: list[Any], expected: list[tuple[Any, ...]], state: str) -> None:
    taught = live(*steps)
    assert list_rows(taught) == expected
    assert taught.view().state == state
    assert taught.mode is Mode.LIVE


def turn_once() -> Session:
    """Forward from the start, left at 95 m, and again at 100 m: it turns left by itself at 95 m. Now at 94 m."""
    taught = live("forward", 5, "left", 2)
    taught.reset(1)
    ticks(taught, 7)
    assert taught.view().state == "left"
    return taught


def corrections(taught: Session) -> list[bool]:
    return [example.correction for example in taught.examples]


def test_taking_back_a_switch_says_that_it_should_not_have_switched() -> None:
    taught = turn_once()
    play(taught, 10, "forward", 1)  # within 2 s
    assert list_rows(taught)[4:] == [("forward", 95, "forward", "confirmation")]
    assert corrections(taught)[4:] == [True]
    assert taught.view().state == "forward"


def test_a_press_long_after_a_switch_is_about_the_present_state() -> None:
    taught = turn_once()
    play(taught, 25, "forward", 1)
    state, _, following, kind = list_rows(taught)[4]
    assert (state, following, kind) == ("left", "forward", "directive")


def test_a_press_soon_after_a_switch_names_the_right_one() -> None:
    taught = turn_once()
    play(taught, 1, "right", 1)
    assert list_rows(taught)[4:] == [("forward", 95, "right", "directive"), ("right", 95, "right", "default")]
    assert corrections(taught)[4:] == [True, True]


THROUGH = [  # ticks in left, a press 2 ticks after that, the example that it makes
    (1, "forward", ("forward", 95, "forward", "confirmation")),  # nobody saw left
    (2, "forward", ("forward", 95, "forward", "confirmation")),
    (3, "left", ("left", 92, "left", "confirmation")),
    (1, "left", ("forward", 95, "left", "directive")),  # it should have gone there
]


@pytest.mark.parametrize(("lasted", "pressed", "example"), THROUGH)
def test_a_switch_through_states_that_nobody_sees_is_judged_where_it_began(
    lasted: int, pressed: str, example: tuple[Any, ...]
) -> None:
    taught = live("forward", 5, "left", lasted, "right", 1)
    taught.reset(1)
    ticks(taught, 6 + lasted)
    assert taught.view().state == "right"
    before = len(taught.examples)
    play(taught, 2, pressed, 1)
    assert list_rows(taught)[before] == example


def turn_back() -> Session:
    """As `turn_once`, and left to forward was directed once, at 80 m. Now at 94 m, in left."""
    taught = live("forward", 5, "left", 15, "forward", 2)
    taught.reset(1)
    ticks(taught, 7)
    assert taught.view().state == "left"
    return taught


def test_a_switch_that_was_shown_from_here_is_meant_from_here_unless_it_comes_soon() -> None:
    for waited, judged in ((2, "forward"), (4, "left")):
        taught = turn_back()
        play(taught, waited, "forward", 1)
        assert list_rows(taught)[6][0] == judged


def test_another_state_that_was_shown_from_here_only_is_meant_from_here() -> None:
    for shown, judged in ((("forward", 5, "left", 5, "right"), "left"), (("forward", 5, "left"), "forward")):
        taught = live(*shown, 1)
        taught.reset(1)
        ticks(taught, 7)
        assert taught.view().state == "left"
        play(taught, "right", 1)
        assert list_rows(taught)[2 * len([step for step in shown if isinstance(step, str)])][0] == judged


@pytest.mark.parametrize(
    ("shown", "waited", "judged"),
    [
        (("forward", 6, "go", 1), 10, "go"),  # go is done there, and was directed: what it did was right
        (("forward", 6, "go", 1), 1, "forward"),  # too soon to be about that
        (("forward", 3, "go", 1), 1, "forward"),  # go is not done yet
        (("forward", 3, "go", 1), 10, "go"),
    ],
)
def test_a_press_back_from_where_a_flag_was_raised_is_meant_from_there(
    shown: tuple[str | int, ...], waited: int, judged: str
) -> None:
    taught = make_session(states=["forward", "go"], features=["range_of(ball)", "done"], library=WITH_GO)
    taught.teach()
    play(taught, *shown)
    taught.reset(1)
    while taught.view().state != "go":
        taught.tick()
    assert len(list_rows(taught)) == 4
    play(taught, waited, "forward", 1)
    assert list_rows(taught)[4][0] == judged


def test_soon_depends_on_the_reaction_time() -> None:
    for reaction_s, judged in ((0.0, "left"), (0.5, "forward")):
        taught = turn_once()
        taught.change_design(options=LearnerOptions(reaction_s=reaction_s))
        play(taught, 4, "right", 1)
        assert list_rows(taught)[4][0] == judged


def test_a_paused_press_is_about_the_present_state_unless_it_takes_a_switch_back() -> None:
    for wanted, judged in (("right", "left"), ("forward", "forward")):
        taught = turn_once()
        taught.paused = True
        taught.direct(wanted)
        taught.paused = False
        ticks(taught, 1)
        assert list_rows(taught)[4][0] == judged


def test_a_flag_that_it_raised_is_corrected_where_it_was_raised() -> None:
    taught = live("forward", 5, "done", 2)
    taught.reset(1)
    ticks(taught, 9)
    assert taught.view().flag == "done"
    play(taught, "forward", 1)
    assert list_rows(taught)[-1] == ("forward", 95, "forward", "confirmation")
    assert corrections(taught)[-1]
    assert taught.view().state == "forward"


def test_a_flag_that_it_raised_rightly_is_kept_as_evidence() -> None:
    taught = live("forward", 5, "done", 2)
    taught.reset(1)
    ticks(taught, 9)
    play(taught, "done", 1)
    assert list_rows(taught)[-1] == ("forward", 95, "done", "directive")
    assert not corrections(taught)[-1]
    assert taught.view().flag == "done"


DIRECTED_FLAGS: list[tuple[list[Any], tuple[Any, ...]]] = [
    # what follows "done" at 95 m, and what the example of that press says then
    ([2, "forward", 1], ("forward", 95, "forward", "confirmation")),  # it was a slip: go on
    ([2, "left", 1], ("forward", 95, "left", "directive")),  # it was a slip: the button beside it was meant
    ([17, "left", 1], ("forward", 95, "left", "directive")),
    ([25, "left", 1], ("forward", 95, "done", "directive")),  # another demonstration begins
    ([2, "done", 1], ("forward", 95, "done", "directive")),  # the same again
    ([2, "restart", "left", 1], ("forward", 95, "done", "directive")),  # it is no longer there
]


@pytest.mark.parametrize(("steps", "expected"), DIRECTED_FLAGS)
def test_a_press_that_soon_leads_out_of_a_directed_flag_says_that_it_was_a_slip(
    steps: list[Any], expected: tuple[Any, ...]
) -> None:
    taught = live("forward", 5, "done", *steps)
    assert list_rows(taught)[:3] == [
        ("start", 100, "forward", "directive"),
        ("forward", 100, "forward", "default"),
        expected,
    ]
    assert taught.mode is Mode.LIVE


def test_a_slip_to_a_flag_can_be_undone_and_is_in_the_journal(tmp_path: Path) -> None:
    taught = make_session(flags=["done"], journal=tmp_path / "a.journal")
    taught.teach()
    play(taught, "forward", 5, "done", 2, "left", 1)
    mended = list_rows(taught)
    taught.close()
    resumed = Session.resume(tmp_path / "a.journal", Scripted(), WITH_GO)
    assert list_rows(resumed) == mended
    assert resumed.undo() == "mend example 3"
    assert list_rows(resumed)[2] == ("forward", 95, "done", "directive")
    resumed.close()


def test_a_press_that_agrees_is_no_correction_and_one_that_disagrees_is() -> None:
    taught = live("forward", 5, "left", 2)
    assert corrections(taught) == [False, False, True, True]  # it would have stayed in forward
    taught.reset(1)
    play(taught, "forward", 1)
    assert corrections(taught)[4:] == [False, False]  # it would have gone forward


def test_watched_ticks_after_a_switch_that_is_taken_back_teach_nothing() -> None:
    taught = make_session(flags=["done"], options=LearnerOptions(watched=True))
    taught.teach()
    play(taught, "forward", 5, "left", 2)
    taught.reset(1)
    before = [row for row in list_rows(taught) if row[0] == "left"]
    play(taught, 12, "forward", 1)
    assert [row[0] for row in list_rows(taught) if row[3] == "confirmation"] == ["forward"]
    assert [row for row in list_rows(taught) if row[0] == "left"] == before


def test_any_recorded_press_ends_that_it_switched_by_itself() -> None:
    taught = turn_once()
    play(taught, 1, "left", 1, "right", 1)  # 0.4 s after the switch
    assert [each[0] for each in list_rows(taught)[4:]] == ["left", "left", "right"]


def test_a_switch_made_in_testing_counts_after_it() -> None:
    taught = live("forward", 5, "left", 2)
    taught.test()
    taught.reset(1)
    ticks(taught, 7)
    taught.teach()
    play(taught, "forward", 1)
    assert list_rows(taught)[4:] == [("forward", 95, "forward", "confirmation")]


@pytest.mark.parametrize(("waited", "shown"), [(10, "left"), (18, "left"), (19, "failed")])
def test_a_slip_that_is_mended_by_another_flag_may_be_mended_within_2_s_of_the_first(
    waited: int, shown: str
) -> None:
    taught = make_session(flags=["done", "failed"])
    taught.teach()
    play(taught, "forward", 5, "done", 2, "failed", waited, "left", 1)
    assert list_rows(taught)[2] == ("forward", 95, shown, "directive")


def test_the_default_of_a_press_soon_after_a_switch_has_the_counters_of_now() -> None:
    """Lap counts once when it starts, so that the robot has counted one lap when left is pressed."""
    taught = make_session(states=["forward", "lap", "left"], features=["range_of(ball)", "laps"])
    taught.teach()
    play(taught, "forward", 5, "lap", 2)
    taught.reset(1)
    ticks(taught, 7)
    assert taught.view().state == "lap"
    play(taught, "left", 1)
    assert list_rows(taught)[4:] == [
        ("forward", 95, 0, "left", "directive"),
        ("left", 95, 1, "left", "default"),
    ]


def test_after_a_kill_watched_stays_need_no_distance_from_those_before(tmp_path: Path) -> None:
    """Stays at 99 and 96 m; the next would come at 93 m, but it is killed at 95 m."""
    taught = make_session(
        flags=["done"], options=LearnerOptions(watched=True), journal=tmp_path / "a.journal"
    )
    taught.teach()
    play(taught, "forward", 5)
    taught.teach()  # what was watched so far counts
    taught.close()
    body = Scripted()
    resumed = Session.resume(tmp_path / "a.journal", body, WITH_GO)
    body.tick = 5
    play(resumed, 1)
    watched = [each[1] for each in list_rows(resumed.lesson) if each[-1] == "watched"]
    resumed.close()
    assert watched == [99, 96, 95]


def test_undo_learns_again_and_goes_on_live() -> None:
    taught = live("forward", 5, "left", 2)
    taught.undo()
    assert taught.mode is Mode.LIVE
    taught.reset(1)
    ticks(taught, 12)
    assert taught.view().state == "forward"  # it no longer knows left
    taught.redo()
    taught.reset(1)
    ticks(taught, 12)
    assert taught.view().state == "left"


def test_undo_of_a_press_that_waits_keeps_the_mode_and_the_lesson() -> None:
    taught = live("forward", 5)
    taught.paused = True
    taught.direct("left")
    taught.undo()
    assert (taught.mode, len(taught.examples)) == (Mode.LIVE, 2)
    ticks(taught, 2)
    assert taught.view().state == "forward"


def test_from_live_to_the_modes_of_the_paper_and_back() -> None:
    taught = live("forward", 5)
    taught.train()
    taught.restart()
    ticks(taught, 2)
    assert taught.view().state == "start"
    taught.teach()
    ticks(taught, 1)
    assert taught.view().state == "forward"
    taught.test()
    play(taught, 3, "left", 1)
    assert taught.mode is Mode.TRAINING
    assert corrections(taught)[-1]


def test_the_body_of_a_live_session_is_decided_by_what_was_just_shown() -> None:
    body = Scripted()
    taught = live("forward", 5, "left", 1, body=body)
    assert taught.trainee.taught.automaton.transitions.keys() == {"start", "forward", "left"}


def test_a_lesson_that_is_taught_live_begins_live_and_goes_back_to_it() -> None:
    taught = make_session(flags=["done"], options=LearnerOptions(live=True))
    modes = [taught.mode]
    play(taught, "forward", 5)
    taught.test()
    play(taught, "left", 1)
    modes.append(taught.mode)
    taught.change_design(options=LearnerOptions())
    modes.append(taught.mode)
    taught.undo()
    assert [*modes, taught.mode] == [Mode.LIVE, Mode.LIVE, Mode.TRAINING, Mode.LIVE]


def test_a_new_lesson_is_taught_live_unless_it_says_otherwise() -> None:
    assert new_lesson(ROBOT, "taught", states=["forward"], features=[]).options.live
    assert not new_lesson(ROBOT, "taught", states=["forward"], features=[], live=False).options.live


APPEARED = [  # distance when it switched, and at a press back 1 s later; the state that the press is about
    (94.0, 80.0, "forward"),
    (nan, nan, "forward"),
    (nan, 80.0, "left"),
    (94.0, nan, "left"),
]


@feature(Continuous())
def twice_the_range(_: ReadingsView, thing: ReadingsView) -> Column:
    """Twice how far it is to a thing."""
    return 2.0 * thing.range


WITH_FUNCTION = Library(replace(kit, features={**kit.features, "twice_the_range": twice_the_range}))


@pytest.mark.parametrize("decides_on", ["range_of(ball)", "twice_the_range(ball)"])
@pytest.mark.parametrize(("then", "now", "judged"), APPEARED)
def test_a_press_back_after_something_has_appeared_is_meant_from_here(
    then: float, now: float, judged: str, decides_on: str
) -> None:
    """Forward at once, and left from tick 5 on, as shown before; the press comes at tick 15."""
    distances = [100.0] * 5 + [then] * 5 + [now] * 20
    script = {**RANGE, ("range", "ball"): lambda tick: distances[tick]}
    taught = make_session(
        flags=["done"], features=[decides_on], library=WITH_FUNCTION, body=Scripted(script=script)
    )
    taught.teach()
    play(taught, "forward", 5, "left", 2)
    taught.reset(1)
    ticks(taught, 15)
    assert taught.view().state == "left"
    play(taught, "forward", 1)
    assert list_rows(taught)[4][0] == judged


def test_a_press_after_a_parameter_was_added_is_meant_from_here() -> None:
    """Forward at once, as shown; what the robot sensed of the new target before it switched is not known."""
    taught = make_session(parameters=["A"], features=["range_of(A)"], targets={"A": "ball"})
    taught.teach()
    play(taught, "forward", 2, "restart", 1)
    assert taught.view().state == "forward"
    taught.change_design(
        parameters=["A", "B"], features=["range_of(A)", "range_of(B)"], targets={"B": "goal"}
    )
    play(taught, "left", 1)
    assert [example.state for example in taught.examples[2:]] == ["forward", "left"]


@pytest.mark.parametrize(
    ("waited", "pressed", "judged"),
    [
        (4, "right", "forward"),  # 0.4 s: soon
        (5, "right", "left"),
        (20, "forward", "forward"),  # 2 s
        (21, "forward", "left"),
    ],
)
def test_when_a_lesson_begins_changes_nothing(waited: int, pressed: str, judged: str) -> None:
    """Times of the clock such as 0.1, 0.2 and 0.3 are not exactly as far apart: 0.4 s is soon at each of them."""
    seen = set()
    for idle in range(200):
        taught = make_session(flags=["done"], body=Scripted(script=begin_after(idle)))
        taught.teach()
        play(taught, idle, "forward", 5, "left", 2, "restart", 7)
        assert taught.view().state == "left"
        play(taught, waited - 2, pressed, 1)
        seen.add(list_rows(taught)[4][0])
    assert seen == {judged}


def begin_after(idle: int) -> dict[Any, Any]:
    """The ball is 100 m away after so many ticks and again 7 ticks later, and meanwhile a meter nearer each tick."""
    return {
        **RANGE,
        ("range", "ball"): lambda tick: 100.0 - (tick - idle if tick < idle + 7 else tick - idle - 7),
    }
