"""How many situations in a row needed no press, as a table of what happens in them."""

from __future__ import annotations

import pytest

from understudy.coaching.quiet_situations import QuietSituations

QUIET, SHORT, FLAG, PRESS = "12 s without a press", "a glance of 3 s", "a flag after 3 s", "a press"

ROWS: list[tuple[tuple[str, ...], str]] = [
    ((), ""),
    ((QUIET,), "1 in a row without a press"),
    ((QUIET, QUIET, QUIET), "3 in a row without a press"),
    ((QUIET, SHORT, QUIET), "2 in a row without a press"),  # too short to say anything
    ((FLAG, QUIET), "2 in a row without a press"),  # that was all of it
    ((QUIET, PRESS), ""),
    ((QUIET, PRESS, QUIET), "1 in a row without a press"),
]


@pytest.mark.parametrize(("situations", "sentence"), ROWS)
def test_situations_in_a_row(situations: tuple[str, ...], sentence: str) -> None:
    quiet = QuietSituations()
    for what in situations:
        for _ in range(30 if what in (SHORT, FLAG) else 120):
            quiet.note_tick(0.1, flag=None)
        if what == FLAG:
            quiet.note_tick(0.1, flag="done")
        if what == PRESS:
            quiet.note_press()
            assert quiet.sentence == ""
        quiet.begin_situation()
    assert quiet.sentence == sentence
