"""What can be wrong with something a user gave, said so that the user can put it right.

Every error is one paragraph: what was wrong, where, and what would be right. Each keeps its data as fields, and
`exit_code` is what the command line ends with. None of them is raised after something was changed.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any, ClassVar


class UnderstudyError(Exception):
    """Something the user gave cannot be used; nothing was changed."""

    exit_code = 2
    json_type: ClassVar[str] = "UnderstudyError"
    """What programs that read `--json` know it by: it stays, whatever the class is called."""

    def __init_subclass__(cls, *, json_type: str = "", **rest: Any) -> None:
        """Name the class for `--json`; one of somebody else's may leave that to the name of the class."""
        super().__init_subclass__(**rest)
        cls.json_type = json_type or cls.__name__

    def __reduce__(self) -> tuple[Any, ...]:
        """Come whole out of another process: what is made of fields is not made again of its sentence."""
        return _again, (type(self), self.args, vars(self))


def _again(kind: type[UnderstudyError], args: tuple[Any, ...], fields: dict[str, Any]) -> UnderstudyError:
    error = kind.__new__(kind, *args)
    vars(error).update(fields)
    return error


def join_names(names: Iterable[str]) -> str:
    """Names for a sentence: 'a, b and c', or 'none'."""
    names = list(names)
    if not names:
        return "none"
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def suggest_known_name(name: object, known: Iterable[str]) -> str:
    """A question to put before what is known: "did you mean 'goto'? ", or nothing where no known name is similar."""
    folded = {str(each).casefold(): str(each) for each in known}
    similar = get_close_matches(str(name).casefold(), folded, n=1)
    return f"did you mean {folded[similar[0]]!r}? " if similar else ""


class KindError(UnderstudyError, json_type="KindError"):
    """A kind that makes no sense, or a value outside its kind."""

    def __init__(self, *, where: str, problem: str, remedy: str) -> None:
        self.where, self.problem, self.remedy = where, problem, remedy
        super().__init__(f"{where}: {problem}; {remedy}")


class DefinitionError(UnderstudyError, json_type="DefinitionError"):
    """A feature, behavior, automaton, lesson or kit whose definition contradicts itself."""

    def __init__(self, *, what: str, problem: str, remedy: str) -> None:
        self.what, self.problem, self.remedy = what, problem, remedy
        super().__init__(f"{what}: {problem}; {remedy}")


class UnknownName(UnderstudyError, json_type="UnknownName"):
    """A name that stands for nothing here."""

    def __init__(self, *, what: str, name: str, where: str, known: Sequence[str]) -> None:
        self.what, self.name, self.where, self.known = what, name, where, tuple(known)
        meant = suggest_known_name(name, known)
        has = f"{meant}It has" if meant else "it has"
        super().__init__(f"{where} has no {what} {name!r}; {has} {join_names(known)}")


class RecursionRefused(UnderstudyError, json_type="RecursionRefused"):
    """An automaton that contains itself."""

    def __init__(self, *, cycle: Sequence[str], path: Path | str | None = None) -> None:
        self.cycle, self.path = tuple(cycle), None if path is None else str(path)
        super().__init__(
            f"{'' if path is None else f'{path}: '}automaton {cycle[0]!r} contains itself ({' -> '.join(cycle)}); "
            "an automaton may use only behaviors that do not lead back to it"
        )


class UnboundParameter(UnderstudyError, json_type="UnboundParameter"):
    """A parameter with no target behind it where a run needs one."""

    def __init__(self, *, behavior: str, parameter: str, targets: Sequence[str]) -> None:
        self.behavior, self.parameter, self.targets = behavior, parameter, tuple(targets)
        super().__init__(
            f"parameter {parameter!r} of {behavior!r} is bound to nothing; "
            f"bind it to one of the targets {join_names(targets)}"
        )


class FileError(UnderstudyError, json_type="FileError"):
    """A file that cannot be read as what it should be."""

    def __init__(self, *, path: Path | str, place: str, problem: str, remedy: str) -> None:
        self.path, self.place, self.problem, self.remedy = str(path), place, problem, remedy
        at = f" at {place}" if place else ""
        super().__init__(f"{path}{at}: {problem}; {remedy}")


class SettingError(UnderstudyError, json_type="SettingError"):
    """A setting of a world, body or command that makes no sense."""

    def __init__(self, *, where: str, setting: str, problem: str, remedy: str) -> None:
        self.where, self.setting, self.problem, self.remedy = where, setting, problem, remedy
        super().__init__(f"{where}: {setting} {problem}; {remedy}")


class SessionError(UnderstudyError, json_type="SessionError"):
    """A step that the session cannot take now."""
