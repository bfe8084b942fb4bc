"""The advice page: what the coach suggests to show next, and what a check of the automaton finds."""

from __future__ import annotations

from typing import ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import VerticalScroll
from textual.screen import ModalScreen
from textual.widgets import Static

from understudy.addons.checks.verification.finding import Finding, Severity
from understudy.model.plain_names import format_names
from understudy.ui.controller.coach import AdviceReport
from understudy.ui.terminal.panels import DIM, TITLE, TONES

MOST_ADVICE = 8
"""The number of suggestions that are listed; the rest is less useful."""


class AdviceScreen(ModalScreen[bool]):
    """The coach's suggestions about a lesson, above the errors and warnings of its automaton.

    It returns whether the next situation is to be set up.
    """

    CSS = """
    AdviceScreen > VerticalScroll { border: round ansi_default; padding: 0 2; }
    AdviceScreen Static { width: 1fr; height: auto; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("C", "close(True)", show=False),
        Binding("escape,K,q,enter", "close(False)", show=False),
    ]

    def __init__(self, report: AdviceReport) -> None:
        super().__init__()
        self._report = report

    def compose(self) -> ComposeResult:
        """Lay out the page."""
        with VerticalScroll():
            yield Static(render_advice(self._report))

    def action_close(self, sets_up: bool) -> None:
        """Return to the robot."""
        self.dismiss(sets_up)


def render_advice(report: AdviceReport) -> Text:
    """Render the suggestions and findings of a report."""
    text = Text.assemble(("What to show next", TITLE))
    for each in report.advice[:MOST_ADVICE]:
        text.append("\n• ").append(format_names(each.sentence))
        if each.evidence:
            text.append(" ").append(format_names(each.evidence))
    if not report.advice:
        text.append("\nno suggestions: the lesson is consistent", DIM)
    elif len(report.advice) > MOST_ADVICE:
        text.append(f"\n{len(report.advice) - MOST_ADVICE} more, less useful", DIM)
    text.append("\n\n").append("What a check finds", TITLE)
    for finding in report.findings:
        text.append_text(_render_finding(finding))
    if not report.findings:
        text.append("\nno errors or warnings", DIM)
    text.append("\n\nC ", "bold").append("set up the next situation  ", DIM)
    return text.append("esc ", "bold").append("back to the robot", DIM)


def _render_finding(finding: Finding) -> Text:
    text = Text("\n• ")
    if finding.severity is Severity.ERROR:
        text.append("error: ", TONES["error"])
    else:
        text.append("warning: ", TONES["correction"])
    text.append(format_names(finding.sentence))
    for each in finding.assumptions:
        text.append(f"\n  assumes: {format_names(each)}", DIM)
    return text.append(f"\n  → {format_names(finding.remedy)}")
