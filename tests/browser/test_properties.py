"""Properties at the page: written in a form, refused beside the field, tested, changed, deleted and brought back."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from playwright.sync_api import Browser, Locator, Page, expect
from tests.browser.studio import open_studio
from tests.browser.test_review import tab
from tests.falsification.idle_lesson import make_idle_library

from understudy.judging.properties.property_file import load_properties
from understudy.storage.library_folder import save_automaton

Snap = Callable[[Page, str], None]
OURS = """\
# Agreed on with the hall's owner.
understudy = "properties"
version = 1

[stands]  # it is slow
behavior = "forage"
world = "forage"
seeds = 2
limit_s = 20
never = "food_stored is at least 99 units"
"""


def part(page: Page) -> Locator:
    """Where the properties are listed."""
    return page.get_by_role("region", name="Properties of the library")


def test_a_property_is_written_refused_tested_changed_and_deleted(
    tmp_path: Path, chromium: Browser, snap: Snap
) -> None:
    library = tmp_path / "library"
    for taught in make_idle_library().taught.values():
        save_automaton(library, taught)
    file = library / "properties.toml"
    file.write_text(OURS)
    with open_studio(chromium, library, "forage", "--failures", str(tmp_path / "failures")) as page:
        tab(page, "Coach")
        part(page).get_by_role("button", name="Test all").click()
        expect(part(page).get_by_role("img", name="Holds")).to_be_visible()

        part(page).get_by_role("button", name="+ property").click()
        form = page.get_by_role("form", name="New property")
        form.get_by_label("Name", exact=True).fill("arrives")
        form.get_by_label("Behavior").select_option("goto")
        form.get_by_label("Target A").select_option("station")
        form.get_by_label("Claim").select_option("always within a time")
        form.get_by_label("Time, s").fill("0.5")
        form.get_by_label("Add to the condition").select_option("distance_to(station) is below 1 m")
        expect(form.get_by_label("Reached")).to_have_value("distance_to(station) is below 1 m")
        form.get_by_label("Reached").fill("distance_to(station) is below 1")
        form.get_by_label("Seeds").fill("4")
        form.get_by_role("button", name="Save and test").click()
        expect(form.get_by_role("alert")).to_contain_text("has no unit, but distance_to(station) is in m")
        snap(page, "properties-refused")
        assert file.read_text() == OURS

        form.get_by_label("Reached").fill("distance_to(station) is below 1 m")
        form.get_by_role("button", name="Save and test").click()
        expect(form).to_have_count(0)
        expect(part(page).get_by_role("img", name="Fails")).to_be_visible()
        expect(part(page)).to_contain_text("worlds failed")
        snap(page, "properties-tested")
        assert file.read_text().startswith(OURS)
        assert [each.name for each in load_properties(file)] == ["stands", "arrives"]

        part(page).get_by_role("button", name="Change property arrives").click()
        form = page.get_by_role("form", name="Property arrives")
        expect(form.get_by_label("Reached")).to_have_value("distance_to(station) is below 1 m")
        form.get_by_label("At least").fill("0.01")
        form.get_by_role("button", name="Save and test").click()
        expect(form).to_have_count(0)
        expect(part(page)).to_contain_text("1 % of worlds")
        assert load_properties(file)[1].at_least == 0.01

        part(page).get_by_role("button", name="Delete property arrives").click()
        expect(part(page)).not_to_contain_text("arrives")
        assert file.read_text() == OURS
        page.get_by_role("button", name="undo").click()
        expect(part(page)).to_contain_text("arrives")
        snap(page, "properties-undone")
