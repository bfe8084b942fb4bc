"""The page of failing worlds: what went wrong in each, whether it still does, and a key that opens one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.screen import Screen
from textual.widgets import DataTable, Static

from understudy.addons.checks.falsification.failing_world import FailingWorld, RerunVerdict
from understudy.judging.properties.run_property import describe_result
from understudy.model.plain_names import format_names
from understudy.ui.controller.failing_worlds import RerunResults
from understudy.ui.controller.status import describe_error
from understudy.ui.terminal.panels import DIM, TITLE, TONES

VERDICTS = {"fails": ("✗", TONES["error"]), "holds": ("✓", TONES["recorded"]), "undecided": ("?", DIM)}
MARKS: dict[RerunVerdict, tuple[str, str]] = {
    "not run": ("·", DIM),
    "fails": ("✗", TONES["error"]),
    "passes": ("✓", TONES["recorded"]),
    "unknown": ("?", TONES["error"]),
}
LEAST_WIDTH = 20
"""The least width of the sentences, in characters."""
RUNNING = "running them with what is trained …"


class FailuresScreen(Screen[str | None]):
    """The failing worlds of a folder, the worst and most different first.

    They are run with what is in training when the page opens, in a thread of their own. The result is the name of the
    one to open; None if none is.

    Parameters
    ----------
    worlds
        The failing worlds.
    problems
        A sentence about each that cannot be read.
    rerun
        Runs all of them, and the properties of the library.
    """

    CSS = """
    FailuresScreen Static { height: auto; margin: 0 1; }
    FailuresScreen DataTable { height: 1fr; margin: 0 1; overflow-x: hidden; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape,W,q", "close", show=False)]

    def __init__(
        self, worlds: Sequence[FailingWorld], problems: Sequence[str], rerun: Callable[[], RerunResults]
    ) -> None:
        super().__init__()
        self._worlds, self._problems, self._rerun = worlds, problems, rerun
        self._filled, self._told = False, ""
        self.result: RerunResults | None = None

    def compose(self) -> ComposeResult:
        """Lay out the heading, the table, and the keys."""
        yield Static(id="head")
        yield DataTable(cursor_type="row", zebra_stripes=False)
        yield Static(id="told")

    def on_mount(self) -> None:
        """Fill the table, and run the worlds."""
        self.query_one(DataTable).focus()
        self._fill(RUNNING)
        self.run_worker(self._run, thread=True)

    def _run(self) -> None:
        try:
            self.result = self._rerun()
            told = ""
        except Exception as error:
            told = describe_error(error)
        self.app.call_from_thread(self._fill, told)

    def _fill(self, told: str) -> None:
        if not self.is_attached:
            return
        self._filled, self._told = True, told
        table = self.query_one(DataTable)
        at = table.cursor_row
        table.clear(columns=True)
        names = [each.folder.name for each in self._worlds]
        table.add_column("", width=1)
        table.add_column("world", width=max(map(len, ["world", *names])))
        table.add_column("what went wrong", width=self._compute_width(names))
        results = {} if self.result is None else {each.folder.name: each for each in self.result.worlds}
        for each in self._worlds:
            name = each.folder.name
            seen = results.get(name, each)
            table.add_row(
                Text(*MARKS[seen.verdict]),
                name,
                Text(format_names(seen.problem or each.summary)),
                height=None,
                key=name,
            )
        table.move_cursor(row=max(0, min(at, table.row_count - 1)))
        self.query_one("#head", Static).update(self._render_head(told))
        self.query_one("#told", Static).update(self._render_foot())

    def on_resize(self) -> None:
        """Wrap the sentences to the new width."""
        if self._filled:
            self._fill(self._told)

    def _compute_width(self, names: list[str]) -> int:
        """Compute the width that is left for sentences beside the marks and the names."""
        gaps = (
            2 * len(("mark", "world", "sentence")) + 4
        )  # beside each cell, at both margins, and for a scroll bar
        return max(LEAST_WIDTH, self.size.width - gaps - 1 - max(map(len, ["world", *names])))

    def _render_head(self, told: str) -> Text:
        text = Text.assemble(("Failing worlds", TITLE))
        if self.result is not None:
            passed = sum(each.has_passed for each in self.result.worlds)
            text.append(f"  {passed} of {len(self.result.worlds)} pass now")
        elif told:
            text.append(f"  {told}", DIM)
        if not self._worlds:
            text.append("\nnone: understudy falsify looks for them", DIM)
        return text

    def _render_foot(self) -> Text:
        text = Text()
        problems = list(self._problems)
        if self.result is not None:
            if self.result.properties:
                text.append("Properties of the library\n", TITLE)
            for each in self.result.properties:
                mark, tone = VERDICTS[each.verdict]
                text.append(f"{mark} ", tone).append(f"{each.tested.name} {each.verdict}")
                text.append(f"  {next(describe_result(each), '')}\n", DIM)
            problems += [self.result.problem] * bool(self.result.problem)
        for problem in problems:
            text.append(f"{problem}\n", TONES["error"])
        text.append("enter ", "bold").append("open it where it goes wrong  ", DIM)
        return text.append("esc ", "bold").append("back to the robot", DIM)

    def on_data_table_row_selected(self, event: DataTable.RowSelected) -> None:
        """Open the failing world under the cursor."""
        self.dismiss(event.row_key.value)

    def action_close(self) -> None:
        """Return to the robot."""
        self.dismiss(None)
