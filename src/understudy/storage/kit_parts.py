"""Kits in documents: what a lesson of a recording or a table needs that no program defines."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from understudy.errors import DefinitionError, FileError
from understudy.model.behaviors import Behavior, Command
from understudy.model.binding import Target
from understudy.model.features import AnyFeature, Feature
from understudy.model.library import Kit
from understudy.model.value_kinds import parse_kind
from understudy.storage.json_text import JsonSteps, Source
from understudy.storage.library_schema import KitDoc, KitFeatureDoc


def encode_kit(kit: Kit) -> KitDoc:
    """Encode a kit whose features are readings and whose behaviors are constant commands.

    Features of the automaton itself are left out, as all automata have them. DefinitionError is raised if a feature or
    behavior is a function, which no document can hold.
    """
    for part in (*kit.features.values(), *kit.behaviors.values()):
        if getattr(part, "function", None) is not None or getattr(part, "order", None) is not None:
            problem = f"{part.name!r} is a function, and a document has readings and commands only"
            raise DefinitionError(what="kit", problem=problem, remedy="leave it out")
    return KitDoc(
        features=[
            KitFeatureDoc(
                name=each.name,
                reading=each.reading if each.reading not in (None, each.name) else "",
                of=each.of,
                kind=str(each.kind),
                unit=each.unit,
                doc=each.doc,
            )
            for each in kit.features.values()
            if isinstance(each, Feature)
        ],
        behaviors={each.name: dict(each.command) for each in kit.behaviors.values()},
        targets=list(kit.targets),
    )


def decode_kit(doc: KitDoc, source: Source, here: JsonSteps) -> Kit:
    """Decode a kit of a document; FileError names the place of what is invalid."""
    with source.convert_errors(here):
        return Kit.from_parts(
            *(
                Feature(
                    each.name,
                    parse_kind(each.kind, where=f"feature {each.name!r}"),
                    each.reading or each.name,
                    of=each.of,
                    unit=each.unit,
                    doc=each.doc,
                )
                for each in doc.features
            ),
            *(Behavior(name, Command(**command)) for name, command in doc.behaviors.items()),
            *map(Target, doc.targets),
        )


def join_kits(kits: Iterable[tuple[Kit, Path | str]]) -> Kit:
    """Join kits to one that has the parts of all.

    Parameters
    ----------
    kits
        Each kit with the file that it is from; an empty text for one that a program defines. Of parts with the same
        name, the first counts.

    Returns
    -------
    Kit
        The kit.

    Raises
    ------
    FileError
        If two files have different behaviors or features of one name.
    """
    parts: dict[tuple[type, str], AnyFeature | Behavior | Target] = {}
    sources: dict[tuple[type, str], Path | str] = {}
    for kit, path in kits:
        for part in (*kit.features.values(), *kit.behaviors.values(), *kit.targets.values()):
            key = (type(part), part.name)
            former = parts.setdefault(key, part)
            if former != part and path and sources[key]:
                problem = f"{part.name!r} is something else than in {sources[key]}"
                remedy = "keep the two in different folders, or rename one of them"
                raise FileError(path=path, place="$.lesson.kit", problem=problem, remedy=remedy)
            sources.setdefault(key, path)
    return Kit.from_parts(*parts.values())
