"""Identifiers: names of a library as a target's language can spell them."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Mapping

from understudy.errors import DefinitionError

_OTHER = re.compile(r"[^a-z0-9_]+", re.IGNORECASE)


def make_identifier(name: str, reserved: Iterable[str] = ()) -> str:
    """Make an identifier of ASCII letters, digits and underscores from a name; `reserved` ones get an underscore.

    Letters lose their accents. Letters of other scripts are spelled by their number in Unicode, such as u901f.
    """
    plain = "".join(map(_spell, unicodedata.normalize("NFKD", name)))
    identifier = _OTHER.sub("_", plain).strip("_") or "unnamed"
    if identifier[0].isdigit():
        identifier = f"n{identifier}"
    return f"{identifier}_" if identifier.lower() in reserved else identifier


def _spell(character: str) -> str:
    if character.isascii():
        return character
    return "" if unicodedata.combining(character) else f" u{ord(character):04x} "


def make_identifiers(names: Iterable[str], *, what: str, reserved: Iterable[str] = ()) -> Mapping[str, str]:
    """Make an identifier for each name; refuse two names that become the same, ignoring case.

    `what` says what the names are of, in the plural, for the error message.
    """
    identifiers = {name: make_identifier(name, reserved) for name in names}
    by_identifier: dict[str, str] = {}
    for name, identifier in identifiers.items():
        other = by_identifier.setdefault(identifier.upper(), name)
        if other != name:
            raise DefinitionError(
                what=f"{what} {other!r} and {name!r}",
                problem=f"both become {identifier!r} in the exported code",
                remedy="rename one of the two",
            )
    return identifiers
