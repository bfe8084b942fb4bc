"""Questions on top of the screen, and the help page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from rich.text import Text
from textual import events
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import VerticalScroll
from textual.screen import ModalScreen
from textual.widgets import Static

from understudy.model.plain_names import format_names

NAMES = {"escape": "esc"}
HOW = """\
Direct the robot with the keys of the states. It decides by itself from the first press on, and learns from \
each press: press only where it does wrong, the state it should go to. A press records an example: what the \
robot sensed, the state it was in, and the state you sent it to; and, right after the switch, that it should \
stay there for now (the default). Press t: it decides without learning, until you press. Try other worlds \
with n, and save with s. A lesson of the paper's training decides only after t.
"""
KEYS = {
    "Directing": (
        ("1-9, letters", "the states, as listed on the right; 0 is the start state"),
        ("↑ ← → ↓", "the states that drive or turn that way"),
        ("enter", "confirm: the current state is right"),
        ("u, ctrl+z", "undo the last step of the lesson"),
        ("U, ctrl+y", "redo"),
    ),
    "The run": (
        ("t", "teach or try"),
        ("space", "pause or resume; a press while paused acts on the next tick"),
        (".", "one step"),
        ("F", "skip to where it needs you, and pause there"),
        ("G", "go to where an answer matters most, in further worlds"),
        ("+ −", "faster, slower"),
        ("n, R", "a new world; restart the same world"),
        ("r", "restart the automaton where the robot is"),
        ("d", "drive the robot into position with the same keys"),
        ("p", "bind the parameters to the next target"),
        ("w", "stop or start learning from silence"),
        ("T", "test it in new worlds, and go to where it goes wrong, until it holds"),
        ("B", "undo what made it worse: back to the version that T found to work in most worlds"),
        (
            "S",
            "what success means, for a behavior without a flag: the next of the goals that fit what was shown",
        ),
        ("M", "stop or start runs in new worlds after each press"),
        ("A", "where it is unsure: pause and ask, mark, or neither"),
    ),
    "The lesson": (
        ("C", "set up the next situation that the coach wants to see"),
        ("K", "all that the coach suggests, and what a check of the automaton finds"),
        ("W", "failing worlds: whether they still fail; enter opens one where it goes wrong"),
        ("?", "show why it does what it does, instead of the examples"),
        ("D", "show what the last press or edit changed beyond what it says, instead of the examples"),
        ("l", "all examples and what was learned; delete some"),
        ("c", "change states, features, flags and options"),
        ("s, q", "save to the library; quit"),
        ("esc, h", "close this page"),
    ),
    "A real robot": (
        ("y", "arm the robot, so that it can move"),
        ("esc", "stop it at once"),
    ),
}
LAST = """
Angles: 0° is ahead, above 0 is to the left, below 0 to the right. Every press is on disk before it \
counts: after a crash or a lost connection, the same command goes on where you were.
"""


class QuestionDialog(ModalScreen[str]):
    """A question with a key for each answer; it returns the key."""

    CSS = """
    QuestionDialog { align: center middle; background: transparent; }
    QuestionDialog > Static { width: 62; max-width: 100%; height: auto; border: round ansi_default; padding: 1 2; }
    """

    def __init__(self, question: str, ways: Mapping[str, str]) -> None:
        super().__init__()
        self._question, self._ways = question, ways

    def compose(self) -> ComposeResult:
        """Lay out the question and its answers."""
        text = Text(f"{format_names(self._question)}\n")
        for key, way in self._ways.items():
            text.append(f"\n{NAMES.get(key, key):>6}", "bold")
            text.append(f"  {way}")
        yield Static(text)

    def on_key(self, event: events.Key) -> None:
        """Close with an answer."""
        if event.key in self._ways:
            event.stop()
            self.dismiss(event.key)


def _help() -> Text:
    text = Text.assemble(("How teaching goes", "bold underline"), "\n", HOW)
    for title, rows in KEYS.items():
        text.append(f"\n{title}\n", "bold underline")
        for key, what in rows:
            text.append(f"{key:>13}  ", "bold").append(f"{what}\n")
    return text.append(LAST)


class HelpScreen(ModalScreen[None]):
    """The help page, with all keys and how teaching works."""

    CSS = """
    HelpScreen > VerticalScroll { border: round ansi_default; padding: 0 2; }
    HelpScreen Static { width: 1fr; height: auto; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape,h,f1,q,enter", "close", show=False),
    ]

    def compose(self) -> ComposeResult:
        """Lay out the page."""
        with VerticalScroll():
            yield Static(_help())

    def action_close(self) -> None:
        """Return to the robot."""
        self.dismiss(None)
