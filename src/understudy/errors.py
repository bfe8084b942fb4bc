"""Errors about input that users can correct.

Every message is one paragraph that says what was wrong, where, and what would be right. Each error keeps its data in
fields. Errors are raised before anything is changed.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any, ClassVar


class UnderstudyError(Exception):
    """The base class of errors about something that a user gave and that cannot be used; nothing was changed.

    `exit_code` is the exit status with which the command line ends.
    """

    exit_code = 2
    json_type: ClassVar[str] = "UnderstudyError"
    """The name of the error in `--json` output. It must stay the same even if the class is renamed."""

    def __init_subclass__(cls, *, json_type: str = "", **rest: Any) -> None:
        """Set the name of the error in `--json` output; by default it is the name of the class."""
        super().__init_subclass__(**rest)
        cls.json_type = json_type or cls.__name__

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the error with its fields, because `__init__` cannot be called with the message alone."""
        return _again, (type(self), self.args, vars(self))


def _again(kind: type[UnderstudyError], args: tuple[Any, ...], fields: dict[str, Any]) -> UnderstudyError:
    error = kind.__new__(kind, *args)
    vars(error).update(fields)
    return error


def join_names(names: Iterable[str], *, word: str = "and") -> str:
    """Join names for a sentence: "a, b and c", or "none"; `word` comes before the last."""
    names = list(names)
    if not names:
        return "none"
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} {word} {names[-1]}"


def suggest_known_name(name: object, known: Iterable[str]) -> str:
    """Return a question such as "did you mean 'goto'? " if a known name is similar, otherwise an empty text."""
    folded = {str(each).casefold(): str(each) for each in known}
    similar = get_close_matches(str(name).casefold(), folded, n=1)
    return f"did you mean {folded[similar[0]]!r}? " if similar else ""


class KindError(UnderstudyError, json_type="KindError"):
    """A feature kind with invalid settings, or a value that does not belong to its kind."""

    def __init__(self, *, where: str, problem: str, remedy: str) -> None:
        self.where, self.problem, self.remedy = where, problem, remedy
        super().__init__(f"{where}: {problem}; {remedy}")


class DefinitionError(UnderstudyError, json_type="DefinitionError"):
    """A feature, behavior, automaton, lesson or kit whose definition contradicts itself."""

    def __init__(self, *, what: str, problem: str, remedy: str) -> None:
        self.what, self.problem, self.remedy = what, problem, remedy
        super().__init__(f"{what}: {problem}; {remedy}")


class UnknownName(UnderstudyError, json_type="UnknownName"):
    """A name that does not exist where it was used; the message lists the names that do."""

    def __init__(self, *, what: str, name: str, where: str, known: Sequence[str]) -> None:
        self.what, self.name, self.where, self.known = what, name, where, tuple(known)
        meant = suggest_known_name(name, known)
        has = f"{meant}It has" if meant else "it has"
        super().__init__(f"{where} has no {what} {name!r}; {has} {join_names(known)}")


class RecursionRefused(UnderstudyError, json_type="RecursionRefused"):
    """An automaton that contains itself, directly or through others; `cycle` lists the names on the way."""

    def __init__(self, *, cycle: Sequence[str], path: Path | str | None = None) -> None:
        self.cycle, self.path = tuple(cycle), None if path is None else str(path)
        super().__init__(
            f"{'' if path is None else f'{path}: '}automaton {cycle[0]!r} contains itself ({' -> '.join(cycle)}); "
            "an automaton may use only behaviors that do not lead back to it"
        )


class UnboundParameter(UnderstudyError, json_type="UnboundParameter"):
    """A parameter that is bound to no target although a run needs one."""

    def __init__(self, *, behavior: str, parameter: str, targets: Sequence[str]) -> None:
        self.behavior, self.parameter, self.targets = behavior, parameter, tuple(targets)
        super().__init__(
            f"parameter {parameter!r} of {behavior!r} is bound to nothing; "
            f"bind it to one of the targets {join_names(targets)}"
        )


class FileError(UnderstudyError, json_type="FileError"):
    """A file that cannot be read or has invalid content; `place` says where in the file."""

    def __init__(self, *, path: Path | str, place: str, problem: str, remedy: str) -> None:
        self.path, self.place, self.problem, self.remedy = str(path), place, problem, remedy
        at = f" at {place}" if place else ""
        super().__init__(f"{path}{at}: {problem}; {remedy}")


class OtherKit(FileError, json_type="OtherKit"):
    """A document that is sound, of an automaton that was taught with another kit than the one it is opened with."""


class LeftOutOfLibrary(UnknownName, json_type="LeftOut"):
    """A name that a library lacks because its automaton is of another kit; `reason` says what the kit lacks."""

    def __init__(self, *, what: str, name: str, where: str, known: Sequence[str], reason: str) -> None:
        super().__init__(what=what, name=name, where=where, known=known)
        self.reason = reason
        self.args = (f"{what} {name!r} was left out of {where}, since it is of another kit: {reason}",)


class SettingError(UnderstudyError, json_type="SettingError"):
    """A setting of a world, body or command with an invalid value."""

    def __init__(self, *, where: str, setting: str, problem: str, remedy: str) -> None:
        self.where, self.setting, self.problem, self.remedy = where, setting, problem, remedy
        super().__init__(f"{where}: {setting} {problem}; {remedy}")


class SessionError(UnderstudyError, json_type="SessionError"):
    """A step that the session cannot take in its present state."""
