"""Labels by hand, questions about doubtful spans, and automata run over a drive: tables to check by hand."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.segmentation.test_drive import make_drive, write

from understudy.addons.recordings.drive_kit import make_candidates, make_drive_kit
from understudy.addons.recordings.drive_table import read_recorded_drive
from understudy.addons.recordings.lesson_from_drive import to_lesson
from understudy.addons.recordings.relabel import list_label_questions, relabel
from understudy.addons.recordings.rerun_drive import OTHER, count_repeated, run_over_drive
from understudy.addons.recordings.segment import Segmentation, segment
from understudy.errors import DefinitionError, UnknownName
from understudy.learning.fit import learn_automaton
from understudy.model.library import Library, TrainedAutomaton

MOVES = {"forward": {"drive": 0.8}, "back": {"drive": -0.5}}


@pytest.fixture(scope="module")
def segmentation(tmp_path_factory: pytest.TempPathFactory) -> Segmentation:
    """A drive in two files: forward from 3 m to 1 m, then back, over and over."""
    folder: Path = tmp_path_factory.mktemp("drive")
    rows = make_drive()
    write(folder / "one.csv", rows[:191])
    write(folder / "two.csv", [rows[0], *rows[191:]])
    drives = [read_recorded_drive(folder / name) for name in ("one.csv", "two.csv")]
    library = Library(make_drive_kit(drives[0], MOVES))
    return segment(drives, make_candidates(library, drives[0]))


def test_a_span_by_hand(segmentation: Segmentation) -> None:
    """Ticks 5 to 9 become back, and certain; all others stay as they are."""
    changed = relabel(segmentation, 5, 10, "back")
    assert changed.labels[4:11].tolist() == [0, 1, 1, 1, 1, 1, 0]
    assert changed.certainties[5:10].tolist() == [1.0] * 5
    assert changed.posteriors[5].tolist() == [0.0, 1.0, 0.0]
    rest = np.r_[0:5, 10 : segmentation.drive.ticks]
    assert (changed.labels[rest] == segmentation.labels[rest]).all()
    assert (changed.posteriors[rest] == segmentation.posteriors[rest]).all()
    assert segmentation.labels[5] == 0, "the former one is unchanged"
    first = changed.list_spans(changed.drive.episodes[0])[:3]
    assert [(span.label, span.first, span.end) for span in first] == [
        ("forward", 0, 5), ("back", 5, 10), ("forward", 10, 25),
    ]  # fmt: skip


WRONG = [  # first, end, label, error, what is said
    (5, 10, "sideways", UnknownName, "has no behavior 'sideways'; it has forward, back and unexplained"),
    (10, 10, "back", DefinitionError, "no part of an episode"),
    (-1, 3, "back", DefinitionError, "no part of an episode"),
    (185, 210, "back", DefinitionError, "name ticks of one episode"),
    (290, 301, "back", DefinitionError, "no part of an episode of the 300 ticks"),
]


@pytest.mark.parametrize(("first", "end", "label", "error", "said"), WRONG)
def test_what_is_no_span(
    segmentation: Segmentation, first: int, end: int, label: str, error: type[Exception], said: str
) -> None:
    with pytest.raises(error, match=said):
        relabel(segmentation, first, end, label)


def test_questions_about_what_is_in_doubt(segmentation: Segmentation) -> None:
    """Two spans of back are in doubt: 10 ticks with 60 %, and 25 ticks with 70 %.

    Wrong with them are 10 * 0.4 * 0.1 s = 0.4 s and 25 * 0.3 * 0.1 s = 0.75 s, so the second one is asked first.
    """
    sure = relabel(relabel(relabel(segmentation, 0, 190, "forward"), 10, 20, "back"), 30, 55, "back")
    posteriors = sure.posteriors.copy()
    posteriors[10:20], posteriors[30:55] = [0.39, 0.6, 0.01], [0.0, 0.7, 0.3]
    asked = list_label_questions(replace(sure, posteriors=posteriors))
    assert [(each.first, each.end, each.labels) for each in asked] == [
        (30, 55, ("back", "unexplained")),
        (10, 20, ("back", "forward")),
    ]
    assert [each.seconds_in_doubt for each in asked] == pytest.approx([0.75, 0.4])
    assert asked[1].chances == pytest.approx((0.6, 0.39))
    assert len(list_label_questions(replace(sure, posteriors=posteriors), most=1)) == 1


def test_nothing_to_ask(segmentation: Segmentation) -> None:
    assert list_label_questions(segmentation) == []


def learn_library(found: Segmentation) -> Library:
    made = to_lesson(found, reaction_s=0.0)
    return made.library.with_automaton(TrainedAutomaton(learn_automaton(made.lesson), made.lesson))


def test_an_automaton_does_as_the_drive(segmentation: Segmentation) -> None:
    states = run_over_drive(learn_library(segmentation), "driven", segmentation.drive, ("forward", "back"))
    assert set(states.tolist()) == {0, 1}
    assert count_repeated(segmentation, states).share > 0.97


def test_agreement_by_hand(segmentation: Segmentation) -> None:
    """Of 10 ticks, 2 are unexplained and do not count; of the other 8, 6 agree."""
    labels = np.array([0, 0, 0, 1, 1, 2, 2, 1, 0, 0])
    states = np.array([0, 0, 1, 1, 1, 0, OTHER, OTHER, 0, 0])
    counted = count_repeated(replace(segmentation, labels=labels), states)
    assert (counted.same_ticks, counted.ticks, counted.share) == (6, 8, 0.75)
    assert count_repeated(replace(segmentation, labels=np.full(10, 2)), states).share == 1.0
