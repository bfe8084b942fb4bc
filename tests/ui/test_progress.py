"""Progress where stderr is no terminal: a line after 2 s of silence, and then less and less often."""

from __future__ import annotations

import pytest
from tests.make.goto_sessions import GOTO, make_goto_session
from tests.simulated_clock import SimulatedClock

from understudy.coaching.give_advice import give_advice
from understudy.learning.fit import learn
from understudy.ui.cli.progress_bar import show_progress

TIMES = [  # how long a command takes, s, and after how many it has written a line
    (0.0, []),
    (1.9, []),
    (2.1, [2]),
    (5.9, [2]),
    (6.1, [2, 6]),
    (15.0, [2, 6, 14]),
    (250.0, [2, 6, 14, 30, 62, 122, 182, 242]),
]


@pytest.mark.parametrize(("seconds", "times"), TIMES)
def test_a_line_after_silence(seconds: float, times: list[int], capsys: pytest.CaptureFixture[str]) -> None:
    clock = SimulatedClock()
    with show_progress("Tests run", clock=clock) as report:
        clock.expect(1)
        for second in range(int(seconds)):
            report(second, 200)
            clock.advance(1.0)
        clock.advance(seconds - int(seconds))
    out, err = capsys.readouterr()
    assert out == ""
    assert err.splitlines() == [f"Tests run: {time - 1} of 200" for time in times]


def test_before_anything_is_counted(capsys: pytest.CaptureFixture[str]) -> None:
    clock = SimulatedClock()
    with show_progress("Tests run", clock=clock):
        clock.expect(1)
        clock.advance(3.0)
    assert capsys.readouterr().err == "Tests run: still working\n"


@pytest.mark.parametrize("is_terminal", [False, True])
def test_no_lines(
    is_terminal: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """With `--json` there are none, nor in a terminal, which has the bar."""
    if is_terminal:
        monkeypatch.setenv("FORCE_COLOR", "1")
    clock = SimulatedClock()
    with show_progress("Tests run", quiet=not is_terminal, clock=clock) as report:
        report(1, 200)
        clock.jump(10.0)
    assert "1 of 200" not in capsys.readouterr().err


def test_the_writer_ends_with_an_error(capsys: pytest.CaptureFixture[str]) -> None:
    clock = SimulatedClock()

    def interrupt() -> None:
        with show_progress("Tests run", clock=clock):
            clock.expect(1)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupt()
    clock.advance(100.0)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("presses", [(), GOTO])
def test_advice_counts_its_looks(presses: tuple[tuple[str, str, str, float, float], ...]) -> None:
    lesson = make_goto_session(presses)
    counts: list[tuple[int, int]] = []
    advice = give_advice(lesson, learn(lesson), progress=lambda done, total: counts.append((done, total)))
    assert advice == give_advice(lesson, learn(lesson))
    assert counts == [(number, 9) for number in range(1, len(counts) + 1)]
    assert len(counts) == (9 if presses else 3)
