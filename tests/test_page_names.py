"""Names in the studio's page: what it declares is called by the field's terms, as in the rest of the code."""

import re
from collections.abc import Iterator
from pathlib import Path

from tests.sources import ROOT
from tests.test_names import is_participle

PAGE = ROOT / "page" / "src"
GENERATED = PAGE / "protocol.ts"
VAGUE = {
    "anew", "asked", "desk", "found", "given", "heard", "kept", "known", "made", "onceMore", "parcel", "roster",
    "said", "seen", "shelf", "shown", "takeUp", "taught", "told", "trial", "twice", "wish",
}  # fmt: skip
"""Names that say nothing of a value, or that no other program has for what they stand for."""
TERMS = {
    "FailedWorlds": "the worlds in which an evaluation failed",
    "Finding": "what a static check reports",
    "Interrupted": "a session that was interrupted",
    "Learned": "what was learned from a recording",
    "Pruning": "the term of decision trees",
    "Recording": "a recording",
    "SavedTour": "the part of a tour that is kept in the browser",
    "Selected": "the span that is selected",
    "proceed": "a verb",
}
"""Names, or how they begin, that end like a participle and are a term for a value, or a verb; and why."""
NOT_CODE = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:[^"\\\n]|\\.)*"|`[^`]*`', re.DOTALL)
DECLARATION = re.compile(r"\b(function|class|interface|type|const|let)\s+([A-Za-z]\w*)")
METHOD = re.compile(r"^  (?:private |static |async )*([A-Za-z]\w*)\(", re.MULTILINE)
GETTER = re.compile(r"^  (?:private |static )*get ([A-Za-z]\w*)\(", re.MULTILINE)
ARROW = re.compile(r"\bconst ([A-Za-z]\w*) = (?:async )?(?:\([^()]*\)|\w+)(?:: [^=;]+)? =>")
MEMBER = re.compile(r"(?:[{(,]|^)\s*(?:private |readonly )*([A-Za-z]\w*)\??:\s", re.MULTILINE)
PATTERN = re.compile(r"\b(?:const|let)\s*[{\[]([^}\]]*)[}\]]\s*=|\(\{([^}]*)\}[,:)]")


def read_code(path: Path) -> str:
    """Return a module of the page without its comments and texts."""
    return NOT_CODE.sub(" ", path.read_text(encoding="utf-8"))


def list_functions_and_types(code: str) -> Iterator[str]:
    """Yield the names of functions, methods, components, classes and types."""
    for word, name in DECLARATION.findall(code):
        if word not in ("const", "let"):
            yield name
    yield from METHOD.findall(code)
    yield from ARROW.findall(code)


def list_values(code: str) -> Iterator[str]:
    """Yield the names of variables, parameters, properties and what is taken out of objects."""
    for word, name in DECLARATION.findall(code):
        if word in ("const", "let"):
            yield name
    yield from GETTER.findall(code)
    yield from MEMBER.findall(code)
    for groups in PATTERN.findall(code):
        for part in ",".join(groups).split(","):
            yield part.partition("=")[0].rpartition(":")[2].strip()


def first_word(name: str) -> str:
    """Return the first word of a name in camel case, in small letters: `askedStates` begins with `asked`."""
    return re.match(r"[A-Z]?[a-z]*", name)[0].lower()  # type: ignore[index]


MESSAGE_FIELDS = set(MEMBER.findall(read_code(GENERATED)))
"""The fields of messages, which are called as in Python."""


def is_term(name: str) -> bool:
    return any(name.startswith(term) for term in TERMS)


def list_offenders(path: Path) -> Iterator[str]:
    """Yield the names of one module that say nothing, or are participles where a verb or a noun is due."""
    code = read_code(path)
    actions = set(list_functions_and_types(code))
    for name in sorted(actions):
        if (is_participle(first_word(name)) or name in VAGUE) and not is_term(name):
            yield name
    yield from sorted((set(list_values(code)) & VAGUE) - actions - MESSAGE_FIELDS)


def test_names_of_the_page() -> None:
    """Functions are verbs, components and types are nouns, and no value is called `found` or `told`."""
    modules = [path for path in sorted(PAGE.rglob("*.ts*")) if path != GENERATED]
    assert sum(len(set(list_functions_and_types(read_code(path)))) for path in modules) > 500
    assert sum(len(set(list_values(read_code(path)))) for path in modules) > 1_500
    offenders = [f"{path.relative_to(PAGE)}: {name}" for path in modules for name in list_offenders(path)]
    assert not offenders, "names in page/src that are participles or say nothing:\n" + "\n".join(offenders)


def test_files_of_the_page() -> None:
    """Modules of the page are called by what they hold."""
    names = {path.name.partition(".")[0] for path in PAGE.rglob("*.ts*")}
    offenders = sorted(name for name in names if name in VAGUE | {"desk", "memory", "past", "standing"})
    assert not offenders, f"modules of the page with names that say nothing: {', '.join(offenders)}"
