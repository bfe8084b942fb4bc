"""Documents: one readable JSON text per automaton (docs/reference/library-format.md).

Examples are the source. The trees learned from them are stored too, with a hash: they are used if the hash matches,
otherwise they are learned again from the examples, and this is reported.
"""

from __future__ import annotations

import hashlib
import re
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from json import JSONDecodeError
from pathlib import Path
from typing import Any, TypeAlias

import msgspec

from understudy.errors import DefinitionError, FileError
from understudy.model.automaton import Transition
from understudy.model.learner_options import LEARNER_VERSION
from understudy.model.lesson import Lesson
from understudy.model.library import Kit, TrainedAutomaton
from understudy.storage.decode import decode_automaton, decode_lesson, decode_trees
from understudy.storage.encode import encode_automaton, encode_built_trees, encode_lesson, sort_examples
from understudy.storage.json_text import Source, find_repeated_key, format_document, parse_json_path
from understudy.storage.kit_parts import decode_kit
from understudy.storage.library_schema import (
    FORMAT,
    MIGRATIONS,
    Document,
    FormatVersion,
    LessonDoc,
    ScikitDoc,
)

Learn: TypeAlias = Callable[[Lesson], Mapping[str, Transition]]
"""A function that learns the transition functions of a lesson, such as `understudy.learning.fit.learn`."""


@dataclass(frozen=True, slots=True)
class LoadedDocument:
    """The content of a document.

    `taught` is the automaton with its lesson. `rebuilt` says why its transition functions were learned again;
    None if the stored ones were used.
    """

    taught: TrainedAutomaton
    rebuilt: str | None = None


def encode_document(taught: TrainedAutomaton) -> bytes:
    """Encode an automaton with its lesson as a document; refuse one that could not be read back unchanged."""
    automaton, lesson = taught.automaton, taught.lesson
    bare = replace(automaton, transitions={})
    if lesson is not None and lesson.automaton != bare:
        raise DefinitionError(
            what=f"automaton {automaton.name!r}",
            problem="its lesson is for an automaton with other states, features or parameters",
            remedy="learn from the lesson again before saving",
        )
    document = _document(taught)
    if document.built is not None and lesson is not None:
        document.built.hash = _hash(document)
    try:
        data = format_document(document)
        _prove(data, taught)
    except (UnicodeEncodeError, FileError) as error:
        problem = "it has text that is not Unicode" if isinstance(error, UnicodeEncodeError) else str(error)
        raise DefinitionError(
            what=f"automaton {automaton.name!r}",
            problem=problem,
            remedy="nothing was saved; correct it first",
        ) from error
    return data


def _prove(data: bytes, taught: TrainedAutomaton) -> None:
    """Decode the document to check that it gives back exactly what was encoded."""
    features = {bound.feature.name: bound.feature for bound in taught.automaton.features}
    lesson = None if taught.lesson is None else sort_examples(taught.lesson)
    transitions = taught.automaton.transitions
    opened = decode_document(
        data, Kit(features, {}, {}), path=taught.automaton.name, learn=lambda _: transitions
    ).taught
    if _document(opened) != _document(TrainedAutomaton(taught.automaton, lesson)):
        raise FileError(
            path=taught.automaton.name,
            place="",
            problem="it does not come back from its document as it was",
            remedy="please report this",
        )


def _document(taught: TrainedAutomaton) -> Document:
    """Build the document of an automaton, without trees if they have not been learned yet."""
    lesson = taught.lesson
    unlearned = lesson is not None and lesson.teaches and not taught.automaton.transitions
    return Document(
        format=FORMAT,
        automaton=encode_automaton(taught.automaton),
        lesson=None if lesson is None else encode_lesson(lesson),
        built=None if unlearned else encode_built_trees(taught),
    )


KIT = b'"kit":'
"""How the key begins of what a lesson of a recording needs."""


def decode_recorded_kit(data: bytes, *, path: Path | str) -> Kit | None:
    """Decode what the lesson of a document needs that no program defines; None if there is nothing."""
    document, source = parse_document(data, path=path)
    lesson = document.lesson
    if lesson is None or isinstance(lesson.kit, msgspec.UnsetType):
        return None
    return decode_kit(lesson.kit, source, ("lesson", "kit"))


def decode_document(
    data: bytes, kit: Kit | None, *, path: Path | str, learn: Learn | None = None, checked: bool = False
) -> LoadedDocument:
    """Decode a document, with features of the kit; refuse invalid content with a FileError that names the place.

    If the stored trees do not match the lesson, or there are none, `learn` makes them; without `learn` that is an
    error too. `checked` is True for text that `check_apart` has accepted.
    """
    document, source = parse_document(data, path=path, checked=checked)
    automaton = decode_automaton(document.automaton, kit, source)
    lesson = None if document.lesson is None else decode_lesson(document.lesson, automaton, source)
    trees = {} if document.built is None else decode_trees(document.built, automaton, source)
    stale = _stale(document, source)
    if document.built is None and lesson is not None and not lesson.teaches:
        stale = None  # nothing is what is learned from it
    if lesson is None or stale is None:
        return LoadedDocument(TrainedAutomaton(replace(automaton, transitions=trees), lesson))
    if learn is None:
        problem = f"its trees must be built: {stale}"
        remedy = "open it with a learner, or build and save it with `understudy rebuild`"
        raise source.make_error(("built",), problem, remedy)
    with source.convert_errors(("lesson",)):
        learned = replace(automaton, transitions=learn(lesson))
    return LoadedDocument(TrainedAutomaton(learned, lesson), stale)


def _stale(document: Document, source: Source) -> str | None:
    """Return why the trees must be learned again, or None if those stored match the lesson."""
    if document.lesson is None:
        if document.built is None:
            remedy = "restore an earlier version"
            raise source.make_error((), "it holds neither a lesson nor trees", remedy)
        return None
    if isinstance(document.lesson.options.learner, ScikitDoc):
        return "classifiers are fitted again on loading"
    if document.built is None:
        return "it has none yet"
    if document.built.hash != _hash(document):
        return "the lesson or the trees were edited, or another version of the learner built them"
    return None


def _hash(document: Document) -> str:
    """Compute a hash of the trees and of everything they are learned from; sources of examples teach nothing."""
    lesson, built = document.lesson, document.built
    parts: list[Any] = [_learner_version(lesson), document.automaton]
    if lesson is not None:
        pressed = [msgspec.structs.replace(each, source=msgspec.UNSET) for each in lesson.examples]
        watched = [msgspec.structs.replace(each, source=msgspec.UNSET) for each in lesson.watched]
        parts += [lesson.options, pressed, watched]
    parts += [] if built is None else [built.trees]
    return "sha256:" + hashlib.sha256(msgspec.json.encode(parts)).hexdigest()


def _learner_version(lesson: LessonDoc | None) -> int:
    """Return the first version of the learner that gives the same trees for this lesson as the present version."""
    watched = [] if lesson is None else lesson.watched
    absent = any(value is None for group in watched for column in group.values for value in column)
    return LEARNER_VERSION if absent else 1


def parse_document(data: bytes, *, path: Path | str, checked: bool = False) -> tuple[Document, Source]:
    """Parse the document in these bytes and convert it to the current format; raise FileError if it is invalid."""
    source = Source(path, data.decode("utf-8", errors="replace"))
    if not checked:
        _check_text(data, source)
    try:
        return _current(data, source), source
    except msgspec.ValidationError as error:
        problem, _, place = str(error).partition(" - at `")
        steps = parse_json_path(place.rstrip("`"))
        raise source.make_error(
            steps, _lower(problem), "see docs/reference/library-format.md for what belongs there"
        ) from error
    except msgspec.DecodeError as error:  # what Python's reader takes and JSON does not: NaN, Infinity
        at = re.search(r"\(byte (\d+)\)", str(error))
        line = data.count(b"\n", 0, int(at[1])) + 1 if at else 1
        problem = "it is not JSON: something in it is not a number, a string, true, false or null"
        raise _unreadable(path, f"line {line}", problem) from error


def _check_text(data: bytes, source: Source) -> None:
    """Refuse bytes that are no JSON, or in which an object has a key twice; this blocks other threads."""
    path = source.path
    try:
        data.decode("utf-8")
        repeated = find_repeated_key(source.text)
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise _unreadable(path, f"line {line}", "it is not UTF-8 text") from error
    except JSONDecodeError as error:
        cut = error.pos >= len(source.text.rstrip()) or error.msg.startswith("Unterminated string")
        place = f"line {error.lineno}, column {error.colno}"
        raise _unreadable(
            path, place, "it is cut short" if cut else f"it is not JSON: {error.msg}"
        ) from error
    except ValueError as error:
        raise _unreadable(path, "", f"it is not JSON: {error}") from error
    except RecursionError as error:
        raise _unreadable(path, "", "it is nested too deeply to be a document") from error
    if repeated is not None:
        problem = f"an object has the key {repeated!r} twice"
        raise FileError(path=path, place="", problem=problem, remedy="remove one of the two")


def _current(data: bytes, source: Source) -> Document:
    version = msgspec.json.decode(data, type=FormatVersion).format
    if version > FORMAT:
        problem = f"it has format {version}, and this Understudy reads up to {FORMAT}"
        raise source.make_error(("format",), problem, "update Understudy to open it")
    raw: dict[str, Any] = {}
    if version != FORMAT:
        raw = msgspec.json.decode(data)
    for each in range(version, FORMAT):
        if each not in MIGRATIONS:
            oldest = min([*MIGRATIONS, FORMAT])
            raise source.make_error(
                ("format",), f"there is no format {version}", f"formats are {oldest} to {FORMAT}"
            )
        raw = {**MIGRATIONS[each](raw), "format": each + 1}
    return msgspec.convert(raw, Document) if raw else msgspec.json.decode(data, type=Document)


def _unreadable(path: Path | str, place: str, problem: str) -> FileError:
    return FileError(path=path, place=place, problem=problem, remedy="restore an earlier version of it")


def _lower(text: str) -> str:
    return text[:1].lower() + text[1:]


def fingerprint_automaton(taught: TrainedAutomaton) -> str:
    """Compute a hash of an automaton, its lesson and its transition functions."""
    return hash_content(encode_document(taught))


def hash_content(content: bytes) -> str:
    """Compute a short hash: 16 hexadecimal digits of SHA-256."""
    return hashlib.sha256(content).hexdigest()[:16]


# Apart

SLOWEST_CHECK_S = 60.0


def check_documents(documents: Sequence[tuple[str, bytes]]) -> None:
    """Parse documents, each after its name; raise FileError for the first that is invalid."""
    for name, data in documents:
        parse_document(data, path=name)


def check_apart(documents: Sequence[tuple[str, bytes]]) -> None:
    """Parse documents, each after its name, in a separate process; raise FileError for the first that is invalid.

    Python's JSON parser lets no other thread run, so a large document would block them for seconds.
    """
    command = [sys.executable, "-P", "-m", __name__]
    try:
        answer = subprocess.run(
            command,
            input=msgspec.msgpack.encode(documents),
            capture_output=True,
            timeout=SLOWEST_CHECK_S,
            check=True,
        )
    except (subprocess.SubprocessError, OSError) as error:  # killed for its memory, say
        place, remedy = f"{len(documents)} documents", "give fewer or smaller ones"
        problem = f"they cannot be read ({type(error).__name__})"
        raise FileError(path=place, place="", problem=problem, remedy=remedy) from error
    wrong = msgspec.json.decode(answer.stdout, type=_Wrong | None)
    if wrong is not None:
        raise FileError(path=wrong.path, place=wrong.place, problem=wrong.problem, remedy=wrong.remedy)


class _Wrong(msgspec.Struct, frozen=True):
    """A FileError from the other process."""

    path: str
    place: str
    problem: str
    remedy: str


def _check_input() -> None:
    """Parse documents from standard input, in the separate process, and write the first error to standard output."""
    wrong = None
    try:
        check_documents(msgspec.msgpack.decode(sys.stdin.buffer.read(), type=list[tuple[str, bytes]]))
    except FileError as error:
        wrong = _Wrong(str(error.path), error.place, error.problem, error.remedy)
    sys.stdout.buffer.write(msgspec.json.encode(wrong))


if __name__ == "__main__":
    _check_input()
