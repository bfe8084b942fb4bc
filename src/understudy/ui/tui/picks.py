"""A list in which space chooses; what is chosen is marked with a sign, not with a color alone."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import ClassVar

from rich.text import Text
from textual.binding import Binding, BindingType
from textual.widgets import OptionList
from textual.widgets.option_list import Option


class Picks(OptionList):
    """Some of a list of texts, in its order."""

    BINDINGS: ClassVar[list[BindingType]] = [Binding("space", "select", show=False)]

    def __init__(self, *, id: str) -> None:
        super().__init__(id=id, compact=True)
        self._texts: list[str] = []
        self._chosen: set[str] = set()

    @property
    def chosen(self) -> list[str]:
        """What was chosen."""
        return [text for text in self._texts if text in self._chosen]

    def offer(self, texts: Iterable[str], *, chosen: Sequence[str]) -> None:
        """Offer these, with some chosen."""
        self._texts, self._chosen = list(texts), set(chosen)
        self.clear_options()
        self.add_options([Option(self._prompt(text)) for text in self._texts])
        self.highlighted = 0 if self._texts else None  # so that space chooses at once

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        """Choose it, or not any more."""
        event.stop()
        text = self._texts[event.option_index]
        self._chosen ^= {text}
        self.replace_option_prompt_at_index(event.option_index, self._prompt(text))

    def _prompt(self, text: str) -> Text:
        mark, style = ("[x]", "bold") if text in self._chosen else ("[ ]", "")
        return Text.assemble((f"{mark} {text}", style))
