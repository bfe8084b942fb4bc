"""File names for automata: readable, and safe on every file system, whatever an automaton is called."""

from __future__ import annotations

import unicodedata

from understudy.errors import DefinitionError

LONGEST = 150
"""Bytes of a file name without its ending; every file system takes 255."""

_DEVICES = {"con", "prn", "aux", "nul", *(f"{port}{n}" for port in ("com", "lpt") for n in range(1, 10))}


def stem(name: str) -> str:
    """The file name, without ending, of the automaton of this name.

    Letters, digits, _ and - stay, and so do spaces inside; other characters become %XX. DefinitionError where
    no file can be called so.
    """
    written, length = "", 0
    try:
        written = "".join(map(_safe, name))
        if written != written.strip():
            written = written.replace(" ", "%20")
        if written.lower() in _DEVICES:
            written = _percent(written[0]) + written[1:]
        length = len(written.encode("utf-8"))
    except UnicodeEncodeError:
        pass
    if not 0 < length <= LONGEST or not name.isprintable():
        raise DefinitionError(
            what=f"automaton {name!r}",
            problem="no file can be called so",
            remedy=f"give it a name of 1 to {LONGEST} letters, digits and other printable characters",
        )
    return written


def _safe(character: str) -> str:
    return character if character.isalnum() or character in "_- " else _percent(character)


def _percent(character: str) -> str:
    return "".join(f"%{byte:02X}" for byte in character.encode("utf-8"))


def alike(name: str) -> str:
    """What names have in common that some file systems take for one: no case, one form of each character."""
    return unicodedata.normalize("NFKC", unicodedata.normalize("NFKC", name).casefold())
