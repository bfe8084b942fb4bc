"""A list in which space chooses, from the first key on."""

from __future__ import annotations

import asyncio

from textual.app import App, ComposeResult

from understudy.ui.terminal.lesson_form import MultiSelect


class Page(App[None]):
    def compose(self) -> ComposeResult:
        yield MultiSelect(id="picks")

    def on_mount(self) -> None:
        self.query_one(MultiSelect).show_choices(["one", "two", "three"], chosen=["three"])
        self.query_one(MultiSelect).focus()


def test_space_chooses_where_the_list_begins() -> None:
    async def keys() -> list[str]:
        page = Page()
        async with page.run_test() as pilot:
            await pilot.press("space", "down", "down", "space")
            return page.query_one(MultiSelect).selection

    assert asyncio.run(keys()) == ["one"]
