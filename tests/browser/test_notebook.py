"""A robot is taught in a real notebook: JupyterLab, a kernel, and the widget in Chromium."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect
from tests.browser.jupyter import Jupyter, Notebook, write_notebook
from tests.browser.window import COARSE, PATIENCE_MS, SNAPS, wait_until

TUTORIAL = Path(__file__).parents[2] / "docs" / "tutorials" / "notebook.ipynb"
pytestmark = pytest.mark.xdist_group("notebook")  # one JupyterLab for all
SESSION, SHOW, LESSON, JUDGE = 1, 3, 5, 7
"""The cells of the tutorial's notebook."""

BEGIN = """
from understudy import Forage, Library, Session, new_lesson
from understudy.sim.forage import FORAGE_KIT

library = Library(FORAGE_KIT)
lesson = new_lesson(
    library, "goto", parameters=["A"], states=["forward", "rotate_left"], features=["distance_to(A)"], live=False
)
session = Session(Forage([42]), library, lesson, targets={"A": "station"}, journal="goto.journal")
"""
SHOWN = """
from understudy.ui.notebook import show_session

show_session(session)
"""


CLOSING = "Canceled future for create_subshell_request"
"""JupyterLab's own complaint about a kernel that it shuts down while it asks it for another shell."""


@pytest.fixture
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Jupyter]:
    """A JupyterLab; where there is none the test is skipped, but in continuous integration it fails.

    Each test has its own: in a shared one, a kernel that was restarted found its journal still open.
    """
    missing = [name for name in ("jupyterlab", "anywidget") if find_spec(name) is None]
    if missing:
        reason = f"there is no {missing[0]}: pip install {missing[0]}"
        pytest.fail(reason) if os.environ.get("CI") else pytest.skip(reason)
    made = Jupyter(tmp_path_factory.mktemp("notebooks"))
    made.start()
    yield made
    made.stop()


@pytest.fixture
def jupyter(lab: Jupyter, page: Page, request: pytest.FixtureRequest) -> Iterator[Jupyter]:
    """The JupyterLab, with a folder for the notebooks of one test."""
    lab.begin(request.node.name)
    yield lab
    lab.end_kernels(page)


@pytest.fixture
def page(chromium: Browser) -> Iterator[Page]:
    """A page whose errors fail the test."""
    errors: list[str] = []
    context = chromium.new_context(
        viewport={"width": 1280, "height": 900}, device_scale_factor=1 if SNAPS in os.environ else COARSE
    )
    context.set_default_timeout(PATIENCE_MS)
    page = context.new_page()
    page.on("pageerror", lambda error: None if CLOSING in str(error) else errors.append(str(error)))
    yield page
    context.close()
    assert not errors, errors


def test_a_robot_is_taught_in_a_notebook(
    jupyter: Jupyter, page: Page, snap: Callable[[Page, str], None]
) -> None:
    (jupyter.folder / "goto.ipynb").write_bytes(TUTORIAL.read_bytes())
    notebook = jupyter.open(page, "goto.ipynb")
    notebook.run(SESSION)
    notebook.run(SHOW)
    widget = notebook.widget
    widget.scroll_into_view_if_needed()
    expect(notebook.state("start")).to_have_attribute("aria-current", "true")

    press(notebook, "rotate_left")  # with the mouse
    expect(widget.locator(".status")).to_contain_text("start → rotate_left, distance_to(A) = ")
    wait_until(page, lambda: abs(notebook.read_value("angle_to(A)")) < 6)
    before = picture(page)
    page.keyboard.press("1")  # its key, which would make a heading of the cell
    expect(notebook.state("forward")).to_have_attribute("aria-current", "true")
    wait_until(page, lambda: notebook.read_value("distance_to(A)") < 0.45)
    assert picture(page) != before
    press(notebook, "done")
    snap(page, "notebook-taught")
    assert widget.locator(".rules li").count() == 3
    taught = int(widget.locator(".count").inner_text().split()[0])

    page.keyboard.press("t")
    expect(widget.get_by_role("button", name="Try")).to_have_attribute("aria-pressed", "true")
    page.keyboard.press("ArrowLeft")  # a correction, by its arrow
    expect(widget.get_by_role("button", name="Teach")).to_have_attribute("aria-pressed", "true")
    expect(widget.locator(".status")).to_contain_text("correction: ")
    page.keyboard.press("u")
    expect(widget.locator(".status")).to_contain_text("Undone: ")
    expect(widget.locator(".count")).to_have_text(f"{taught} examples")

    for key in ("d", "d", "x", "b", "m"):  # commands of the notebook, not while the widget has the keys
        page.keyboard.press(key)
    assert notebook.cells.count() == 8

    shown = notebook.read(LESSON).splitlines()
    assert len(shown) == taught
    assert re.fullmatch(r"directive +start → rotate_left", shown[0])
    assert re.search(r"it arrives in \d+% of 40 worlds", notebook.read(JUDGE))


def test_cells_and_the_widget_share_a_session(jupyter: Jupyter, page: Page) -> None:
    os.mkfifo(jupyter.folder / "gate")
    write_notebook(
        jupyter.folder / "two.ipynb",
        BEGIN,
        SHOWN,
        "session.direct('forward')",
        "print(session.view().state, round(session.body.time_s, 1))",
        "open('gate').read()",
        "print(session.examples[-1].next)",
    )
    notebook = jupyter.open(page, "two.ipynb")
    for cell in (0, 1):
        notebook.run(cell)
    notebook.widget.scroll_into_view_if_needed()
    expect(notebook.state("start")).to_have_attribute("aria-current", "true")
    notebook.run(2)
    expect(notebook.state("forward")).to_have_attribute("aria-current", "true")
    state, first = notebook.read(3).split()
    assert state == "forward"
    wait_until(page, lambda: float(notebook.read(3).split()[1]) > float(first))

    notebook.start(4)  # a cell that takes its time: the press waits, and is not lost
    notebook.state("rotate_left").click()
    (jupyter.folder / "gate").write_text("")
    expect(notebook.state("rotate_left")).to_have_attribute("aria-current", "true")
    assert notebook.read(5) == "rotate_left"


def test_a_reload_and_the_end_of_the_kernel_lose_nothing(jupyter: Jupyter, page: Page) -> None:
    resume = BEGIN.replace("Session(", "Session.resume('goto.journal', ").split("session = ")[0] + (
        "if 'session' in globals(): session.close()\n"  # the cell runs twice if the kernel was not ready
        "session = Session.resume('goto.journal', Forage([42]), library)\n"
        "print(len(session.examples), session.view().state)"
    )
    write_notebook(jupyter.folder / "journal.ipynb", BEGIN, SHOWN, resume, SHOWN)
    notebook = jupyter.open(page, "journal.ipynb")
    for cell in (0, 1):
        notebook.run(cell)
    notebook.widget.scroll_into_view_if_needed()
    press(notebook, "forward")
    page.keyboard.press("Control+s")
    saved = jupyter.folder / "journal.ipynb"
    wait_until(page, lambda: '"execution_count": 2' in saved.read_text(encoding="utf-8"))
    page.reload()
    notebook = Notebook(page)
    notebook.widget.scroll_into_view_if_needed()
    expect(notebook.state("forward")).to_have_attribute("aria-current", "true")
    press(notebook, "rotate_left")

    jupyter.restart_kernels(page)
    notebook.wait_for_kernel()
    assert notebook.read(2) == "4 rotate_left"
    notebook.run(3)
    expect(notebook.cells.nth(3).locator('.states [data-state="rotate_left"]')).to_have_attribute(
        "aria-current", "true"
    )


def test_the_world_stands_still_where_nobody_sees_it(jupyter: Jupyter, page: Page) -> None:
    far = "print('\\n' * 200)"
    times = "from time import monotonic; print(session.body.time_s, monotonic())"
    write_notebook(jupyter.folder / "far.ipynb", BEGIN, SHOWN, far, times)
    notebook = jupyter.open(page, "far.ipynb")
    for cell in (0, 1):
        notebook.run(cell)
    notebook.widget.scroll_into_view_if_needed()
    wait_until(page, lambda: notebook.widget.locator(".time").inner_text() != "0:00.0")
    notebook.run(2)
    said = [read_times(notebook)]

    def stands_still() -> bool:
        """Whether the world's time is what it was at least 0.7 s ago."""
        said.append(read_times(notebook))
        return any(time == said[-1][0] and now <= said[-1][1] - 0.7 for time, now in said)

    wait_until(page, stands_still)


def test_what_a_press_changed_is_shown_and_undone_and_the_score_turned_off(
    jupyter: Jupyter, page: Page, snap: Callable[[Page, str], None]
) -> None:
    live = BEGIN.replace("live=False", "live=True").replace(
        '"distance_to(A)"', '"distance_to(A)", "angle_to(A)"'
    )
    write_notebook(jupyter.folder / "changed.ipynb", live, SHOWN, "session.delete(3)")
    notebook = jupyter.open(page, "changed.ipynb")
    for cell in (0, 1):
        notebook.run(cell)
    widget = notebook.widget
    widget.scroll_into_view_if_needed()
    press(notebook, "rotate_left")
    press(notebook, "forward")
    score = widget.get_by_label("In new worlds")
    expect(score).to_contain_text(re.compile(r"goto works in \d+ of \d+ new worlds|not measured: choose"))
    notebook.run(2)
    changed = widget.locator(".changed")
    expect(changed).to_contain_text("Changed: rotate_left no longer goes to forward")
    conditions = changed.get_by_text("− ")
    expect(conditions).to_be_hidden()
    changed.get_by_role("button", name="Show me").click()
    expect(conditions).to_be_visible()
    snap(page, "notebook-changed")
    page.keyboard.press("D")
    expect(conditions).to_be_hidden()
    score.get_by_role("button", name="turn off").click()
    expect(score).to_contain_text("not measured: turned off")
    snap(page, "notebook-score-off")
    changed.get_by_role("button", name="Undo").click()
    expect(changed).to_be_hidden()
    expect(widget.locator(".count")).to_have_text("4 examples")


def read_times(notebook: Notebook) -> tuple[float, float]:
    """Return the world's time and the kernel's, s."""
    time, now = notebook.read(3).split()
    return float(time), float(now)


def press(notebook: Notebook, state: str) -> None:
    """Click a state, and see that the robot is in it, beside the picture and in the automaton."""
    notebook.state(state).click()
    expect(notebook.state(state)).to_have_attribute("aria-current", "true")
    expect(notebook.widget.locator(f'.graph [data-state="{state}"]')).to_have_class("current")
    expect(notebook.widget.locator(".graph .current")).to_have_count(1)


def picture(page: Page) -> str:
    """The picture of the world, as it is drawn."""
    drawn = page.evaluate("document.querySelector('.understudy canvas').toDataURL()")
    assert isinstance(drawn, str)
    return drawn
