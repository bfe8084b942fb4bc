"""The library at the page: other names, copies, former versions, and the way out and in again as a file."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from zipfile import ZipFile

import pytest
from playwright.sync_api import Page, expect
from tests.browser.studio import Studio
from tests.browser.teacher import Teacher
from tests.export.test_ros2 import FORAGER


@pytest.fixture
def teacher(visit: Callable[[], Page]) -> Teacher:
    """Somebody who has saved goto, and looks at the library."""
    made = Teacher(visit())
    made.begin_goto()
    made.click("Pause")
    expect(made.page.get_by_role("button", name="Resume", exact=True)).to_be_visible()
    show(made, "forward")
    made.page.get_by_role("tab", name="Library").click()
    return made


def show(teacher: Teacher, state: str) -> None:
    """One more example, and save."""
    save = teacher.page.get_by_role("button", name="Save", exact=True)
    teacher.state_button(state).click()
    step = teacher.page.get_by_role("button", name="Step")
    if step.is_enabled():  # time stands still
        step.click()
    save.click()
    expect(teacher.page.get_by_title(re.compile("^Every press is written"))).to_have_text("in the library")


def test_other_names(teacher: Teacher) -> None:
    page = teacher.page
    page.get_by_role("button", name="Duplicate goto").click()
    page.get_by_role("textbox", name="Name of the copy of goto").fill("twin")
    page.keyboard.press("Enter")
    expect(page.get_by_role("button", name="Open twin")).to_be_visible()
    page.get_by_role("button", name="Rename goto").click()
    field = page.get_by_role("textbox", name="New name of goto")
    field.fill("twin")
    page.keyboard.press("Enter")
    expect(page.get_by_text("the library has twin already")).to_be_visible()
    field.fill("reach")
    page.keyboard.press("Enter")
    expect(page.get_by_role("button", name="Rename reach")).to_be_visible()
    expect(page.get_by_role("banner")).to_contain_text("reach")
    expect(field).to_have_count(0)


def test_back_to_a_former_version(teacher: Teacher) -> None:
    page = teacher.page
    show(teacher, "rotate_left")
    page.get_by_role("button", name="Versions of goto").click()
    page.get_by_role("button", name="version 1", exact=True).click()
    changes = page.get_by_role("region", name="What changed since version 1")
    expect(changes).to_contain_text("go to turn left (directive)")
    assert teacher.examples == 4
    page.get_by_role("button", name="Go back to version 1 of goto").click()
    expect(page.get_by_role("button", name="version 2", exact=True)).to_be_visible()
    assert teacher.examples == 2


def test_out_as_a_file_and_in_again(teacher: Teacher, tmp_path: Path) -> None:
    page = teacher.page
    with page.expect_download() as download:
        page.get_by_role("button", name="Export library").click()
    parcel = tmp_path / "mine.zip"
    download.value.save_as(parcel)
    page.get_by_role("button", name="Duplicate goto").click()
    page.get_by_role("textbox", name="Name of the copy of goto").press("Enter")
    page.get_by_role("button", name="Open goto 2").click()
    expect(page.get_by_text("Opened goto 2")).to_be_visible()
    page.get_by_role("tab", name="Library").click()
    page.get_by_role("button", name="Delete goto").click()

    def give() -> None:
        with page.expect_file_chooser() as chooser:
            page.get_by_role("button", name="Import").click()
        chooser.value.set_files(parcel)

    give()
    expect(page.get_by_text("Imported goto")).to_be_visible()
    page.get_by_role("button", name="Open goto", exact=True).click()
    teacher.pause()
    show(teacher, "rotate_left")
    page.get_by_role("tab", name="Library").click()
    page.get_by_role("button", name="Open goto 2").click()
    expect(page.get_by_text("Opened goto 2")).to_be_visible()
    page.get_by_role("tab", name="Library").click()
    give()
    page.get_by_role("button", name="Replace").click()
    expect(page.get_by_text("replaced goto, former versions are kept")).to_be_visible()
    parcel.write_bytes(b"no zip")
    give()
    expect(page.get_by_text("cannot be read as a zip")).to_be_visible()


def test_what_was_deleted_is_brought_back_where_it_is_said(teacher: Teacher) -> None:
    page = teacher.page
    page.get_by_role("button", name="Duplicate goto").click()
    page.keyboard.press("Enter")
    page.get_by_role("button", name="Delete goto 2").click()
    said = page.get_by_role("status").filter(has_text="goto 2 is in the trash")
    said.get_by_role("button", name="undo").click()
    expect(page.get_by_role("button", name="Open goto 2")).to_be_visible()
    page.get_by_role("tab", name="Lesson").click()
    page.get_by_role("button", name="Example 1", exact=True).click()
    page.get_by_role("button", name="Delete", exact=True).click()
    said = page.get_by_role("status").filter(has_text="Example 1 deleted")
    said.get_by_role("button", name="undo").click()
    expect(page.get_by_role("button", name="Example 1", exact=True)).to_be_visible()


def test_one_behavior_in_two_ways(teacher: Teacher) -> None:
    """To the station and to the food: two states that run goto."""
    page = teacher.page
    page.get_by_role("tabpanel").get_by_role("button", name="Teach something new").click()
    page.get_by_label("Name", exact=True).fill("fetch")
    for chosen in ("goto station", "goto nearest food", "load food", "food stored"):
        page.get_by_role("checkbox", name=chosen, exact=True).check(force=True)
    page.get_by_role("button", name="Begin", exact=True).click()
    teacher.state_button("goto(nearest_food)").click()
    expect(teacher.state_button("goto(nearest_food)")).to_have_attribute("aria-pressed", "true")
    page.get_by_role("button", name="choose features").click()
    page.get_by_role("checkbox", name="food left", exact=True).check(force=True)
    page.get_by_role("button", name="Choose", exact=True).click()
    expect(teacher.state_button("goto(station)")).to_be_visible()
    assert teacher.examples == 2


def test_a_lesson_that_was_cut_off_is_thrown_away(
    teacher: Teacher, studio: Studio, snap: Callable[[Page, str], None]
) -> None:
    """What is saved can be opened then; and it can be taken back where it is said."""
    page = teacher.page
    page.get_by_role("button", name="Duplicate goto").click()
    page.keyboard.press("Enter")
    teacher.state_button("rotate_left").click()
    teacher.click("Step")
    expect(page.get_by_role("button", name="Save", exact=True)).to_be_enabled()
    studio.stop()
    studio.start()
    page.reload()
    discard = page.get_by_role("button", name="Discard the interrupted lesson of goto")
    discard.click()
    expect(discard).to_have_count(0)
    said = page.get_by_role("status").filter(has_text="Discarded the interrupted lesson")
    said.get_by_role("button", name="undo").click()
    expect(discard).to_be_visible()
    snap(page, "cut-off")
    page.get_by_role("tab", name="Library").click()
    teacher.click("Open goto 2")
    expect(page.get_by_role("banner")).to_contain_text("goto 2")
    teacher.press("Space")
    teacher.state_button("forward").click()
    teacher.click("Step")
    page.get_by_role("tab", name="Library").click()
    teacher.click("Resume goto")
    expect(page.get_by_role("alert")).to_contain_text("goto 2 has changes")
    teacher.click("not now")
    teacher.click("Open goto")
    teacher.click("Open without saving")
    snap(page, "cut-off-library")
    teacher.click("Discard it, and open what is saved")
    expect(page.get_by_role("banner")).to_contain_text("goto (A)")
    assert teacher.examples == 2


def test_export_to_run_elsewhere(teacher: Teacher, tmp_path: Path, snap: Callable[[Page, str], None]) -> None:
    """As C code; and for a robot, which asks for the file of that."""
    page = teacher.page
    page.get_by_role("button", name="Export goto", exact=True).click()
    form = page.get_by_role("form", name="Export goto")
    form.get_by_label("Export as").select_option("C code")
    form.get_by_label("A stands for").select_option("nearest food")
    form.get_by_label("Single precision").check()
    snap(page, "export")
    with page.expect_download() as download:
        form.get_by_role("button", name="Download").click()
    assert download.value.suggested_filename == "goto-c99.zip"
    download.value.save_as(tmp_path / "goto.zip")
    with ZipFile(tmp_path / "goto.zip") as archive:
        manifest = json.loads(archive.read("goto-c99/manifest.json"))
    assert (manifest["binding"], manifest["precision"]) == ({"A": "nearest_food"}, "single")
    expect(page.get_by_text("Exported goto for c99")).to_be_visible()

    form.get_by_label("Export as").select_option("ROS 2 package")
    button = form.get_by_role("button", name="Download")
    expect(button).to_be_disabled()
    file = tmp_path / "rover.toml"
    file.write_text(FORAGER.replace("drive_m_s = 0.25", "drive_m_s = 7"))
    form.get_by_label("Robot's file").set_input_files(file)
    button.click()
    expect(
        page.get_by_text("the robot's file at commands.drive_m_s: is 7; give a number above 0")
    ).to_be_visible()
    snap(page, "export-refused")
    file.write_text(FORAGER)
    button.click()
    expect(page.get_by_text("rover.toml has changed or is gone: choose it again")).to_be_visible()
    form.get_by_label("Robot's file").set_input_files(file)
    with page.expect_download() as download:
        button.click()
    assert download.value.suggested_filename == "goto-ros2.zip"
