"""The lesson page: the learned conditions, and every example, with deletion and undo."""

from __future__ import annotations

from typing import ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import VerticalScroll
from textual.screen import Screen
from textual.widgets import DataTable, Static

from understudy.errors import UnderstudyError
from understudy.learning.report import list_contradicting_numbers
from understudy.model import describe
from understudy.model.plain_names import format_names
from understudy.ui.controller.trainer import Trainer
from understudy.ui.terminal.panels import DIM, TITLE, TONES


class LessonScreen(Screen[None]):
    """All examples of a lesson, the newest first, below the learned conditions."""

    CSS = """
    LessonScreen #rules { height: auto; max-height: 40%; margin: 0 1; }
    LessonScreen #rules Static { width: 1fr; height: auto; }
    LessonScreen DataTable { height: 1fr; margin: 0 1; }
    LessonScreen #told { height: auto; margin: 0 1; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("x,delete", "delete", show=False),
        Binding("u,ctrl+z", "undo", show=False),
        Binding("U,ctrl+y", "redo", show=False),
        Binding("escape,l,q", "close", show=False),
    ]

    def __init__(self, trainer: Trainer) -> None:
        super().__init__()
        self.trainer = trainer

    def compose(self) -> ComposeResult:
        """Lay out the conditions, the table, and the keys."""
        with VerticalScroll(id="rules"):
            yield Static()
        yield DataTable(cursor_type="row", zebra_stripes=False)
        yield Static(id="told")

    def on_mount(self) -> None:
        """Fill the table."""
        self.query_one("#rules", VerticalScroll).can_focus = False
        self.query_one(DataTable).focus()
        self._fill("")

    def _fill(self, status: str) -> None:
        self.query_one("#rules Static", Static).update(self._rules())
        self._fill_table()
        keys = Text()
        for key, what in (("x", "delete"), ("u", "undo"), ("U", "redo"), ("esc", "back to the robot")):
            keys.append(f"{key} ", "bold").append(f"{what}  ", DIM)
        keys.append("◆ correction  ! contradicts another example", DIM)
        self.query_one("#told", Static).update(
            Text.assemble((format_names(status), "bold"), "\n" if status else "", keys)
        )

    def _rules(self) -> Text:
        rules = Text.assemble((f"What {format_names(self.trainer.name)} learned", TITLE))
        for state, rule in self.trainer.explainer.describe_rules():
            rules.append("\n").append(f"{format_names(state)}: ", "bold").append(format_names(rule))
        if not self.trainer.session.examples:
            rules.append("\nnothing yet: go back and press the keys of the states", DIM)
        return rules

    def _fill_table(self) -> None:
        features, table = self.trainer.features, self.query_one(DataTable)
        at = table.cursor_row
        table.clear(columns=True)
        table.add_columns("#", "state", "next", *(format_names(str(bound)) for bound in features), "kind")
        torn = list_contradicting_numbers(self.trainer.session.lesson)
        for example in reversed(self.trainer.session.examples):
            mark = "! " if example.number in torn else "◆ " if example.correction else ""
            number = str(example.number)
            values = [describe.format_value(*pair) for pair in zip(features, example.values, strict=True)]
            what = Text(f"{mark}{example.kind}", TONES["correction"] if mark else "")
            states = map(format_names, (example.state, example.next))
            table.add_row(number, *states, *values, what, key=number)
        table.move_cursor(row=max(0, min(at, table.row_count - 1)))

    def action_delete(self) -> None:
        """Delete the example under the cursor."""
        table = self.query_one(DataTable)
        if table.row_count:
            number = table.coordinate_to_cell_key(table.cursor_coordinate).row_key.value
            self._do(lambda: self.trainer.delete(int(number or 0)))

    def action_undo(self) -> None:
        """Undo the last change."""
        self._do(self.trainer.undo)

    def action_redo(self) -> None:
        """Redo the last undone change."""
        self._do(self.trainer.redo)

    def _do(self, action: object) -> None:
        try:
            if callable(action):
                action()
            self._fill(self.trainer.status.text)
        except UnderstudyError as error:
            self._fill(str(error))

    def action_close(self) -> None:
        """Return to the robot."""
        self.dismiss(None)
