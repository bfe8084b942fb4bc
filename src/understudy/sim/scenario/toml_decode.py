"""Read TOML files into plain values, and these into structs; errors name the key, the problem and a remedy."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import UnionType
from typing import Any, Literal, NamedTuple, TypeAlias, TypeVar, Union, get_args, get_origin, get_type_hints

import msgspec

from understudy.errors import FileError
from understudy.sim.scenario.scenario_errors import suggest_name
from understudy.sim.scenario.squad_schema import StrictStruct

KeySteps: TypeAlias = tuple[str | int, ...]
Described = TypeVar("Described", bound=StrictStruct)

_STEP = re.compile(r"\.(\w+)|\[(\d+)\]|(\[\.\.\.\])")
_EXPECTED = re.compile(r"Expected `(?P<type>.+?)`(?: of length (?P<length>.+?))?, got (?P<got>.+)")
_WORDS = {
    "float": "a number",
    "int": "a whole number",
    "str": "a text in quotes",
    "bool": "true or false",
    "array": "a list",
    "object": "a table of keys",
}


class DecodeProblem(NamedTuple):
    """The key of a value that does not fit, the problem, and a remedy."""

    key: str
    problem: str
    remedy: str


def parse_toml(content: str, path: Path | str) -> dict[str, Any]:
    """Parse the text of a TOML file into plain values; raise FileError with the place if it is not TOML."""
    try:
        return tomllib.loads(content.replace("\r\n", "\n"))
    except RecursionError:
        raise FileError(
            path=path, place="", problem="is nested too deeply", remedy="give tables of tables"
        ) from None
    except ValueError as error:
        problem, _, place = str(error).partition(" (at ")
        if not place.startswith("line"):  # it ends too early, or holds a number with thousands of digits
            lines = content.splitlines() or [""]
            place = f"line {len(lines)}, column {len(lines[-1]) + 1}"
        raise FileError(
            path=path, place=place.rstrip(")"), problem=f"is not TOML: {problem}", remedy="correct it there"
        ) from None


def decode_toml_values(document: Any, whole: type[Described]) -> Described | DecodeProblem:
    """Convert a document of plain values to a struct; return the first problem if something does not fit."""
    try:
        return msgspec.convert(document, whole)
    except (msgspec.ValidationError, ValueError, TypeError, OverflowError) as error:
        return _explain(document, str(error), whole)


def format_key_path(steps: KeySteps) -> str:
    """Format keys and indices as one path: types.pioneer.sensors[1]."""
    parts = (f"[{step}]" if isinstance(step, int) else f".{_key(step)}" for step in steps)
    return "".join(parts).removeprefix(".")


def _key(key: str) -> str:
    return key if re.fullmatch(r"[\w-]+", key) else f"{key!r:.60}"


def _explain(document: Any, message: str, whole: type[StrictStruct]) -> DecodeProblem:
    problem, _, path = message.partition(" - at `$")
    steps = _real_steps(document, message, path.rstrip("`"), whole)
    expected = _find_expected(document, steps, whole)
    if match := re.fullmatch(r"Object contains unknown field `(.*)`", problem, re.DOTALL):
        return _unknown_key(expected, (*steps, match[1]), match[1])
    if match := re.fullmatch(r"Object missing required field `(.*)`", problem):
        choices = [word for option in _options(expected) for word in _choices(option)]
        remedy = suggest_name("", choices, what="kind") if match[1] == "kind" else f"give {match[1]!r}"
        return DecodeProblem(format_key_path((*steps, match[1])), "is missing", remedy)
    if problem.startswith("Invalid"):
        text = str(_walk(document, steps))
        at = _find_expected(document, steps[:-1], whole) if steps and steps[-1] == "kind" else expected
        choices = [word for option in _options(at) for word in _choices(option)]
        what = "kind of sensor" if steps and steps[-1] == "kind" else "word"
        return DecodeProblem(
            format_key_path(steps),
            f"is {text!r:.60}, which is unknown",
            suggest_name(text, choices, what=what),
        )
    if match := _EXPECTED.fullmatch(problem):
        wanted = " or ".join(
            dict.fromkeys(_WORDS[word] for word in match["type"].split(" | ") if word in _WORDS)
        )
        length = f" of {match['length']}" if match["length"] else ""
        got = match["got"].strip("`")
        got = f"of length {got}" if length else _WORDS.get(got, got)
        return DecodeProblem(format_key_path(steps), f"is {got}", f"give {wanted}{length}")
    return DecodeProblem(
        format_key_path(steps), f"cannot be: {problem}", "give a value that the reference of this key allows"
    )


def _unknown_key(expected: Any, steps: KeySteps, key: str) -> DecodeProblem:
    keys = [
        name for option in _options(expected) if _is_part(option) for name in option.__struct_encode_fields__
    ]
    return DecodeProblem(format_key_path(steps), "is not a key here", suggest_name(key, keys, what="key"))


def _real_steps(document: Any, message: str, path: str, whole: type[StrictStruct]) -> KeySteps:
    """Return the keys and indices that lead to an error, from the path in msgspec's message.

    For the entries of a table msgspec writes `[...]` instead of the key. The key is then found by trial: it is the
    first one that gives the same error when the table has no other entries.
    """
    steps: KeySteps = ()
    for name, index, left_out in _STEP.findall(path):
        if not left_out:
            steps = (*steps, int(index) if index else name)
            continue
        table = _walk(document, steps)
        keys = list(table) if isinstance(table, Mapping) else []
        failing = (key for key in keys if _fails_alone(document, message, (*steps, key), whole))
        failing_key = next(failing, None)
        if failing_key is None:
            return steps
        document = _alone(document, steps, failing_key)
        steps = (*steps, failing_key)
    return steps


def _fails_alone(document: Any, message: str, steps: KeySteps, whole: type[StrictStruct]) -> bool:
    try:
        msgspec.convert(_alone(document, steps[:-1], str(steps[-1])), whole)
    except (msgspec.ValidationError, ValueError, TypeError, OverflowError) as error:
        return str(error) == message
    return False


def _alone(document: Any, steps: KeySteps, key: str) -> Any:
    """Return the document with only this key in the table at the end of the path."""
    if not steps:
        return {key: document[key]}
    if isinstance(document, Mapping):
        return {**document, steps[0]: _alone(document[steps[0]], steps[1:], key)}
    changed = list(document)
    changed[int(steps[0])] = _alone(document[steps[0]], steps[1:], key)
    return changed


def _walk(document: Any, steps: Sequence[str | int]) -> Any:
    for step in steps:
        document = document[step]
    return document


def _find_expected(document: Any, steps: KeySteps, whole: type[StrictStruct]) -> Any:
    """Return the type expected at these keys; None if the keys are unknown."""
    expected: Any = whole
    for number, step in enumerate(steps):
        inside = (_inside(option, step, _walk(document, steps[:number])) for option in _options(expected))
        expected = next((candidate for candidate in inside if candidate is not None), None)
    options = [option for option in _options(expected) if _is_part(option)]
    if len(options) > 1:
        kind = _kind(_walk(document, steps))
        return next((option for option in options if option.__struct_config__.tag == kind), expected)
    return expected


def _inside(expected: Any, step: str | int, value: Any) -> Any:
    origin, arguments = get_origin(expected), get_args(expected)
    if _is_part(expected) and isinstance(step, str):
        tag = expected.__struct_config__.tag
        fields = dict(zip(expected.__struct_encode_fields__, expected.__struct_fields__, strict=True))
        return (
            get_type_hints(expected).get(fields.get(step, "")) if tag is None or tag == _kind(value) else None
        )
    if origin is tuple and isinstance(step, int):
        return arguments[0] if arguments[-1] is Ellipsis else arguments[min(step, len(arguments) - 1)]
    return arguments[1] if arguments and isinstance(step, str) and origin is not tuple else None


def _options(expected: Any) -> tuple[Any, ...]:
    return get_args(expected) if get_origin(expected) in (Union, UnionType) else (expected,)


def _choices(option: Any) -> tuple[str, ...]:
    if _is_part(option):
        return (str(option.__struct_config__.tag),)
    return get_args(option) if get_origin(option) is Literal else ()


def _is_part(option: Any) -> bool:
    return isinstance(option, type) and issubclass(option, StrictStruct)


def _kind(value: Any) -> Any:
    return value.get("kind") if isinstance(value, Mapping) else None
