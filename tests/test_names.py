"""Names: functions are verbs, and no public name of the product stands for two things."""

import ast
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest
from tests.sources import MODULES as ALL_MODULES
from tests.sources import ROOT, read_source

pytestmark = pytest.mark.xdist_group("sources")  # each module is parsed once
SOURCE = ROOT / "src" / "understudy"
MODULES = [path for path in ALL_MODULES if path.is_relative_to(SOURCE) and path.name != "__main__.py"]


def name_of(path: Path) -> str:
    parts = path.relative_to(SOURCE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def definitions(path: Path) -> Iterator[tuple[str, type[ast.AST]]]:
    """The public functions and classes that a module defines at its top level."""
    for statement in read_source(path).body:
        if isinstance(statement, ast.FunctionDef | ast.ClassDef) and not statement.name.startswith("_"):
            yield statement.name, type(statement)


def methods(path: Path) -> Iterator[tuple[str, str]]:
    """The public methods and properties of a module's public classes, each with its class."""
    for statement in read_source(path).body:
        if isinstance(statement, ast.ClassDef) and not statement.name.startswith("_"):
            for each in statement.body:
                if isinstance(each, ast.FunctionDef | ast.AsyncFunctionDef) and not each.name.startswith("_"):
                    yield statement.name, each.name


def homonyms() -> dict[str, set[str]]:
    """Public names by the places that define them, where there are several."""
    places = defaultdict[str, set[str]](set)
    for path in MODULES:
        module = name_of(path)
        if last := module.rpartition(".")[2]:
            places[last.removeprefix("_")].add(module)
        for name, _ in definitions(path):
            places[name].add(f"{module}:{name}")
    return {name: found for name, found in places.items() if len(found) > 1}


def is_one_subject(name: str, places: set[str]) -> bool:
    """Whether equal names are meant: by rule, what they name belongs together."""
    modules = {place for place in places if ":" not in place}
    functions = places - modules
    if functions and {place.partition(":")[0] for place in functions} <= modules:
        return len(functions) == 1 and is_one_subject(
            name, modules
        )  # a module and the one function it is there for
    if functions:
        return False
    outer = [module for module in modules if f"{module}.{name}" in modules]  # a package and its main module
    rest = modules - {f"{module}.{name}" for module in outer}
    rest = {module for module in rest if not module.startswith("ui.cli.commands.")}  # named as their command
    web = {module for module in rest if module.startswith("ui.web.")}  # message, action and view of a subject
    kernels = {
        module for module in rest if module.startswith("sim.kernels.")
    }  # named as the module they serve
    return len(rest - web - kernels) + bool(web) <= 1


ALLOWED = {
    "app": "each front end has one application object",
    "body": "the protocol, and its implementation in MuJoCo",
    "camera": "one subject: in the real robot, in the kernels, on the page",
    "clock": "one subject: time itself, and the session's time on the page",
    "coach": "the controller, and its messages and actions on the page",
    "learn": "the public function, and the command that calls it",
    "library": "the value, and its actions and view on the page",
    "messages": "messages of the page, and messages of ROS: each field's own term",
    "model": "MuJoCo's own term (MjModel)",
    "session": "the session, and its messages, actions and view on the page",
    "team": "one subject by layer: the runtime's, the scenario's, the page's",
    "world": "MuJoCo's world has the modules of the 2-D simulator for the same subjects",
}
"""Public names that may stand for several things, and why."""

NO_PARTICIPLES = {"feed", "need", "read", "seed", "send", "speed", "string", "bring", "hold"}
IRREGULAR = {
    "begun", "bound", "built", "cut", "drawn", "dealt", "found", "given", "gone", "held", "hidden", "kept", "known",
    "led", "left", "lost", "made", "meant", "paid", "put", "ran", "said", "seen", "sent", "shown", "sold", "sorted",
    "spoken", "stood", "taken", "taught", "thought", "told", "went", "won", "worn", "written",
}  # fmt: skip
METHODS_ALLOWED = {
    "armed": "the term for a robot that obeys",
    "delivered": "a count that a scenario's goal has under this name",
    "failed": "which agents are out of action, as opposed to finished",
    "finished": "which worlds have reached their goal, in all results",
    "finished_s": "when a world reached its goal",
    "gathered": "a count that a scenario's goal has under this name",
    "held": "in which runs a property held, in all results",
    "paused": "the state of a clock",
}
"""Participles that are a field's own term for a state or a result, and which."""


def test_no_public_name_stands_for_two_things() -> None:
    found = {name: sorted(places) for name, places in homonyms().items() if not is_one_subject(name, places)}
    assert {name: places for name, places in found.items() if name not in ALLOWED} == {}
    assert [name for name in ALLOWED if name not in found] == []  # allowed for nothing


def is_participle(name: str) -> bool:
    """Whether a name begins with a participle: `made`, `raised_flags`, `watching`."""
    first = name.partition("_")[0]
    return first in IRREGULAR or (first.endswith(("ed", "ing")) and first not in NO_PARTICIPLES)


def test_functions_are_no_participles() -> None:
    """A function says what it does: `make_kit`, not `made`."""
    functions = [
        (name_of(path), name)
        for path in MODULES
        for name, kind in definitions(path)
        if kind is ast.FunctionDef
    ]
    assert len(functions) > 1_000
    found = [f"{module}: {name}" for module, name in functions if is_participle(name)]
    assert not found, "functions that are participles:\n" + "\n".join(found)


def test_methods_are_no_participles() -> None:
    """A method says what it does and a property what it is: `find_raised`, `is_known`; not `raised`, `known`."""
    known = [(f"{name_of(path)}.{owner}", name) for path in MODULES for owner, name in methods(path)]
    assert len(known) > 1_000
    found = [
        f"{owner}: {name}" for owner, name in known if is_participle(name) and name not in METHODS_ALLOWED
    ]
    assert not found, "methods that are participles:\n" + "\n".join(found)
    assert set(METHODS_ALLOWED) <= {name for _, name in known}


HELPERS_ALLOWED = {
    "anything": "a hostile message, in a test of another toolchain whose sources are hashed",
    "failed": METHODS_ALLOWED["failed"],
    "failing_world": "a world in which a behavior fails",
    "held_evaluations": "evaluations that wait until they are let go on",
    "killed_processes": "processes that were killed",
    "missing_flag": "the name of a seeded defect, as reports have it",
    "planted_library": "a library with a planted defect",
    "removed_examples": "the name of a seeded defect, as reports have it",
    "scripted_drive": "a drive by a script",
    "sent": "the last command that a robot was sent",
    "sent_s": "when each message was sent",
    "shared_lesson": "the lesson of two drivers",
    "swapped": "the name of a seeded defect, as reports have it",
    "unused_feature": "the name of a seeded defect, as reports have it",
    "waiting_agent": "an agent that does not tick yet",
}
"""Helpers of tests that begin with a participle and are nouns, and what they are."""
HASHED = {"export", "fixtures", "peers"}
"""Folders of tests whose sources are hashed, or translated, for records that only other toolchains can renew."""
HELPER = re.compile(r"^ *(?:async )?def (?!_*test_)_*(\w+)\(", re.MULTILINE)


def test_helpers_of_tests_are_no_participles() -> None:
    """A helper says what it does or makes: `make_session`, not `taught`; `read_failures`, not `shown`."""
    folder = ROOT / "tests"
    paths = [path for path in sorted(folder.rglob("*.py")) if path.relative_to(folder).parts[0] not in HASHED]
    helpers = [
        (path.relative_to(folder), name)
        for path in paths
        for name in HELPER.findall(path.read_text(encoding="utf-8"))
    ]
    assert len(helpers) > 1_500
    offenders = [
        f"{path}: {name}" for path, name in helpers if is_participle(name) and name not in HELPERS_ALLOWED
    ]
    assert not offenders, "helpers of tests that are participles:\n" + "\n".join(offenders)
    assert set(HELPERS_ALLOWED) <= {name for _, name in helpers}


VAGUE = {"asked", "found", "given", "kept", "known", "made", "said", "seen", "shown", "told"}
"""Names that say nothing of a value."""
VARIABLES_ALLOWED = {
    "addons/checks/falsification/new_worlds.py: shown": "the values at which a flag was shown, as in `Criteria`",
    "judging/criteria.py: shown": "a field of a public class: the values at which a flag was shown",
    "judging/explanation_text.py: shown": "a field of `--json`",
    "judging/lesson_replay.py: shown": "a field of a public class: what the demonstrator showed",
    "judging/raised_range.py: shown": "a field of a public class: the values at which a flag was shown",
    "judging/simplify_preview.py: shown": "a field of `--json`",
    "learning/change_attribution.py: said": "a field of `--json`",
    "learning/explain.py: shown": "a field of a public class",
    "model/change_summary.py: said": "a field of `--json` and of the page",
    "addons/robots/camera/image_folder.py: shown": "a field that a command reads",
    "addons/recordings/recorded_inputs.py: kept": "the keyword of `Transport.subscribe`",
    "addons/robots/inputs.py: kept": "the keyword of `Transport.subscribe`",
    "addons/robots/recording_transport.py: kept": "the keyword of `Transport.subscribe`",
    "addons/robots/ros/dds.py: kept": "the keyword of `Transport.subscribe`",
    "addons/robots/ros/transport.py: kept": "the keyword of `Transport.subscribe`",
    "addons/robots/ros/zenoh.py: kept": "the keyword of `Transport.subscribe`",
    "addons/robots/team_network/remote_robot.py: kept": "the keyword of `Transport.subscribe`",
    "runtime/agents/messages.py: kept": "a field of messages between agents",
    "ui/web/views/lesson_test.py: shown": "a field that `simplify --json` prints under this name, too",
}
NAMED_PACKAGES = (
    "addons", "coaching", "jit", "judging", "learning", "model", "records", "runtime", "sim", "storage", "training",
    "ui/controller", "ui/web", "viz",
)  # fmt: skip
"""Packages in which variables and parameters, too, are named for what they hold."""


class Names(NamedTuple):
    """What a module names within its functions too, each with its line."""

    variables: list[tuple[int, str]]
    parameters: list[tuple[int, str, str]]
    """Annotated parameters, with their annotations."""
    docstrings: list[tuple[int, str]]
    """All texts that stand alone as a statement, such as those of attributes."""


@cache
def read_names(path: Path) -> Names:
    names = Names([], [], [])
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        match node:
            case ast.Name(id=name, ctx=ast.Store()):
                names.variables.append((node.lineno, name))
            case ast.arg(arg=name, annotation=annotation):
                names.variables.append((node.lineno, name))
                if annotation is not None:
                    names.parameters.append((node.lineno, name, ast.unparse(annotation)))
            case ast.Expr(value=ast.Constant(value=str(text))):
                names.docstrings.append((node.lineno, text))
    return names


def list_modules(packages: Iterable[str]) -> list[Path]:
    """List the modules of some packages of the product, relative to it."""
    return [
        path.relative_to(SOURCE) for package in packages for path in sorted((SOURCE / package).rglob("*.py"))
    ]


def test_variables_say_what_they_hold() -> None:
    """A variable is `report` or `names`, not `found` or `known`."""
    variables = [
        (path, *each) for path in list_modules(NAMED_PACKAGES) for each in read_names(SOURCE / path).variables
    ]
    assert len(variables) > 20_000
    offenders = [
        f"{path}:{line}: {name}"
        for path, line, name in variables
        if name in VAGUE and f"{path}: {name}" not in VARIABLES_ALLOWED
    ]
    assert not offenders, "variables that say nothing:\n" + "\n".join(offenders)


MEANT_PACKAGES = (
    "addons", "coaching", "jit", "judging", "learning", "model", "records", "runtime", "sim", "storage", "training",
    "ui/controller", "viz",
)  # fmt: skip
"""Packages whose parameters have these meanings."""
MEANINGS = {("kind", "RobotType"): "robot_type", ("outcome", "TickResult"): "result"}
"""What a parameter of a name and a type is called instead."""
SORTS = {"str", "str | None"}
"""The types of a parameter `sort`: the name of a sort of agents or, as in documents, of a feature's."""


def test_words_with_many_meanings_have_one() -> None:
    """A `kind` is none of robots, an `outcome` no result of a tick, and a `sort` one of agents."""
    parameters = [
        (path, *each)
        for path in list_modules(MEANT_PACKAGES)
        for each in read_names(SOURCE / path).parameters
    ]
    assert len(parameters) > 5_000
    offenders = [
        f"{path}:{line}: {name}: {annotation}"
        for path, line, name, annotation in parameters
        if any((name, each) in MEANINGS for each in annotation.split(" | "))
        or (name == "sort" and annotation not in SORTS)
    ]
    assert not offenders, "words with another meaning:\n" + "\n".join(offenders)


DIALECT = re.compile(
    r"\b(?:anew|afresh|nobody|somebody|whoever|ARCHITECTURE|HOUSE\.md|So (?:long|many|much|often))\b"
)
DIALECT_ALLOWED = {
    "learning/change_attribution.py": "values of `--json`: read anew, shown anew",
    "training/session.py": "the keyword `afresh` of `Session.test`",
}
"""Modules whose docstrings name a value or a keyword, and which."""
PLAIN_PACKAGES = sorted({*NAMED_PACKAGES, "ui/notebook", "ui/terminal"} - {"ui/web"})
"""Packages whose docstrings have no dialect, and refer to no page outside of the repository."""


def test_docstrings_have_no_dialect() -> None:
    """A docstring is plain technical English: no "so long after it", no "whoever"."""
    paths = [path for path in list_modules(PLAIN_PACKAGES) if path.as_posix() not in DIALECT_ALLOWED]
    docstrings = [(path, *each) for path in paths for each in read_names(SOURCE / path).docstrings]
    assert len(docstrings) > 4_000
    offenders = [f"{path}:{line}: {text}" for path, line, text in docstrings if DIALECT.search(text)]
    assert not offenders, "docstrings in dialect:\n" + "\n".join(offenders)
