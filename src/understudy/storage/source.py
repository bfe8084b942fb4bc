"""A document's text, and errors that name the place in it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from understudy.errors import FileError, UnderstudyError
from understudy.storage.json_text import line_of, spelled

Steps: TypeAlias = tuple[str | int, ...]


@dataclass(frozen=True, slots=True)
class Source:
    """The text of one document and the file it is from."""

    path: Path | str
    text: str

    def wrong(self, steps: Steps, problem: str, remedy: str) -> FileError:
        """The error for what is at these keys and indices."""
        return FileError(path=self.path, place=self.place(steps), problem=problem, remedy=remedy)

    def place(self, steps: Steps) -> str:
        """A JSON path with the line it is on."""
        line = line_of(self.text, steps)
        return spelled(steps) + (f" (line {line})" if line else "")

    @contextmanager
    def at(
        self, steps: Steps, remedy: str = "edit it there, or restore an earlier version"
    ) -> Iterator[None]:
        """Errors of the model's own inside become errors of the file, at this place."""
        try:
            yield
        except FileError:
            raise
        except UnderstudyError as error:
            raise self.wrong(steps, str(error), remedy) from error

    def once(self, names: Sequence[str], steps: Steps, what: str) -> None:
        """FileError where a name comes twice."""
        seen: dict[str, int] = {}
        for index, name in enumerate(names):
            if name in seen:
                raise self.wrong(
                    (*steps, index), f"{what} {name!r} is there twice", "rename or remove one of the two"
                )
            seen[name] = index
