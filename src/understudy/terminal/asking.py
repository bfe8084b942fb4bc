"""Small questions on top of the screen, and the page of help."""

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

NAMES = {"escape": "esc"}


class Ask(ModalScreen[str]):
    """A question with a key for each answer; it ends with the key."""

    CSS = """
    Ask { align: center middle; }
    Ask > Static { width: 62; max-width: 100%; height: auto; border: round ansi_default; padding: 1 2; }
    """

    def __init__(self, question: str, ways: Mapping[str, str]) -> None:
        super().__init__()
        self._question, self._ways = question, ways

    def compose(self) -> ComposeResult:
        """The question and its answers."""
        text = Text(f"{self._question}\n")
        for key, way in self._ways.items():
            text.append(f"\n{NAMES.get(key, key):>6}", "bold")
            text.append(f"  {way}")
        yield Static(text)

    def on_key(self, event: events.Key) -> None:
        """One of the answers."""
        if event.key in self._ways:
            event.stop()
            self.dismiss(event.key)


HELP = """\
[bold]How teaching goes[/]

Direct the robot with the keys of the states. Each press records an example: what the robot
sensed, the state it was in, and the state you sent it to; and, right after the switch, that it
should stay there for now (the default). Press [bold]t[/]: it learns from the examples and tries by itself.
Where it does wrong, press the state it should have gone to: that is a [bold]correction[/], and it is
back in training. Press [bold]t[/] again. Then try another world with [bold]n[/], and save with [bold]s[/].

[bold]Directing[/]
   1-9, letters   the states, as listed on the right; 0 is the start state
         ↑ ← → ↓   the states that drive or turn that way
           enter   keep doing this: confirms the state it is in
    u  or ctrl+z   undo the last step of the lesson     [bold]U[/]  or ctrl+y   redo

[bold]The run[/]
               t   training or testing
           space   pause; a press while paused acts when time goes on
               .   one step                              [bold]+ −[/]   faster, slower
               r   restart the automaton where it is
               R   the same world from its beginning     [bold]n[/]   a new world
               d   drive the robot into position with the same keys; nothing is recorded
               p   let the parameters stand for the next target
               w   I am not watching (where silence counts as consent)

[bold]The lesson[/]
               ?   why it does what it does, instead of the examples
               l   all examples, and what was learned from them; delete some
               c   choose states, features, flags and options anew
               s   save into the library                 [bold]q[/]   quit

Angles are 0° ahead, above 0 to the left and below 0 to the right. Every press is on disk before
it counts: after a crash or a lost connection, the same command goes on where you were.

[dim]esc or h closes this page[/]
"""


class Help(ModalScreen[None]):
    """All keys, and how teaching goes."""

    CSS = """
    Help > VerticalScroll { border: round ansi_default; padding: 0 2; }
    Help Static { width: 1fr; height: auto; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape,h,f1,q,enter", "close", show=False),
    ]

    def compose(self) -> ComposeResult:
        """The page."""
        with VerticalScroll():
            yield Static(Text.from_markup(HELP))

    def action_close(self) -> None:
        """Back to the robot."""
        self.dismiss(None)
