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

TUTORIAL = Path(__file__).parents[2] / "docs" / "tutorials" / "notebook.ipynb"
SESSION, SHOW, LESSON, JUDGE = 1, 3, 5, 7
"""The cells of the tutorial's notebook."""
LIMIT_S = 40.0

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


@pytest.fixture
def jupyter(tmp_path: Path) -> Iterator[Jupyter]:
    """A JupyterLab; where there is none the test is skipped, but in continuous integration it fails."""
    missing = [name for name in ("jupyterlab", "anywidget") if find_spec(name) is None]
    if missing:
        reason = f"there is no {missing[0]}: pip install {missing[0]}"
        pytest.fail(reason) if os.environ.get("CI") else pytest.skip(reason)
    made = Jupyter(tmp_path)
    made.start()
    yield made
    made.stop()


@pytest.fixture
def page(chromium: Browser) -> Iterator[Page]:
    """A page whose errors fail the test."""
    errors: list[str] = []
    context = chromium.new_context(viewport={"width": 1280, "height": 900})
    page = context.new_page()
    page.on("pageerror", lambda error: errors.append(str(error)))
    yield page
    context.close()
    assert not errors, errors


def test_a_robot_is_taught_in_a_notebook(
    jupyter: Jupyter, page: Page, tmp_path: Path, snap: Callable[[Page, str], None]
) -> None:
    (tmp_path / "goto.ipynb").write_bytes(TUTORIAL.read_bytes())
    notebook = jupyter.open(page, "goto.ipynb")
    notebook.run(SESSION)
    notebook.run(SHOW)
    widget = notebook.widget
    widget.scroll_into_view_if_needed()
    expect(notebook.state("start")).to_have_attribute("aria-current", "true")

    press(notebook, "rotate_left")  # with the mouse
    expect(widget.locator(".status")).to_contain_text("start → rotate_left, distance_to(A) = ")
    until(notebook, lambda: abs(notebook.reading("angle_to(A)")) < 6)
    before = picture(page)
    page.keyboard.press("1")  # its key, which would make a heading of the cell
    expect(notebook.state("forward")).to_have_attribute("aria-current", "true")
    until(notebook, lambda: notebook.reading("distance_to(A)") < 0.45)
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

    shown = notebook.run(LESSON).splitlines()
    assert len(shown) == taught
    assert re.fullmatch(r"directive +start → rotate_left", shown[0])
    assert re.search(r"it arrives in \d+% of 40 worlds", notebook.run(JUDGE))


def test_cells_and_the_widget_share_a_session(jupyter: Jupyter, page: Page, tmp_path: Path) -> None:
    write_notebook(
        tmp_path / "two.ipynb",
        BEGIN,
        SHOWN,
        "session.direct('forward')",
        "print(session.view().state, round(session.body.time_s, 1))",
        "import time; time.sleep(1.5)",
        "print(session.examples[-1].next)",
    )
    notebook = jupyter.open(page, "two.ipynb")
    for cell in (0, 1):
        notebook.run(cell)
    notebook.widget.scroll_into_view_if_needed()
    expect(notebook.state("start")).to_have_attribute("aria-current", "true")
    notebook.run(2)
    expect(notebook.state("forward")).to_have_attribute("aria-current", "true")
    state, first = notebook.run(3).split()
    assert state == "forward"
    page.wait_for_timeout(500)
    assert float(notebook.run(3).split()[1]) > float(first)

    notebook.start(4)  # a cell that takes its time: the press waits, and is not lost
    notebook.state("rotate_left").click()
    expect(notebook.state("rotate_left")).to_have_attribute("aria-current", "true")
    assert notebook.run(5) == "rotate_left"


def test_a_reload_and_the_end_of_the_kernel_lose_nothing(
    jupyter: Jupyter, page: Page, tmp_path: Path
) -> None:
    resume = BEGIN.replace("Session(", "Session.resume('goto.journal', ").split("session = ")[0] + (
        "session = Session.resume('goto.journal', Forage([42]), library)\n"
        "print(len(session.examples), session.view().state)"
    )
    write_notebook(tmp_path / "journal.ipynb", BEGIN, SHOWN, resume, SHOWN)
    notebook = jupyter.open(page, "journal.ipynb")
    for cell in (0, 1):
        notebook.run(cell)
    notebook.widget.scroll_into_view_if_needed()
    press(notebook, "forward")
    page.keyboard.press("Control+s")
    page.wait_for_timeout(1000)
    page.reload()
    notebook = Notebook(page)
    notebook.widget.scroll_into_view_if_needed()
    expect(notebook.state("forward")).to_have_attribute("aria-current", "true")
    press(notebook, "rotate_left")

    jupyter.restart_kernels(page)
    page.wait_for_timeout(2000)
    notebook.wait_for_kernel()
    assert notebook.run(2) == "4 rotate_left"
    notebook.run(3)
    expect(notebook.cells.nth(3).locator('.states [data-state="rotate_left"]')).to_have_attribute(
        "aria-current", "true"
    )


def test_the_world_stands_still_where_nobody_sees_it(jupyter: Jupyter, page: Page, tmp_path: Path) -> None:
    far = "print('\\n' * 200)"
    write_notebook(tmp_path / "far.ipynb", BEGIN, SHOWN, far, "print(session.body.time_s)")
    notebook = jupyter.open(page, "far.ipynb")
    for cell in (0, 1):
        notebook.run(cell)
    notebook.widget.scroll_into_view_if_needed()
    until(notebook, lambda: notebook.widget.locator(".time").inner_text() != "0:00.0")
    notebook.run(2)
    first = notebook.run(3)
    page.wait_for_timeout(700)
    assert notebook.run(3) == first


def press(notebook: Notebook, state: str) -> None:
    """Click a state, and see that the robot is in it, beside the picture and in the automaton."""
    notebook.state(state).click()
    expect(notebook.state(state)).to_have_attribute("aria-current", "true")
    expect(notebook.widget.locator(f'.graph [data-state="{state}"]')).to_have_class("current")
    expect(notebook.widget.locator(".graph .current")).to_have_count(1)


def until(notebook: Notebook, seen: Callable[[], bool]) -> None:
    """Watch until something is seen."""
    for _ in range(round(LIMIT_S / 0.02)):
        if seen():
            return
        notebook.page.wait_for_timeout(20)
    raise AssertionError(f"not within {LIMIT_S:.0f} s")


def picture(page: Page) -> str:
    """The picture of the world, as it is drawn."""
    drawn = page.evaluate("document.querySelector('.understudy canvas').toDataURL()")
    assert isinstance(drawn, str)
    return drawn
