"""Names that files and other programs know, written out: none of them changes because something is renamed."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Iterator
from contextlib import suppress
from importlib import import_module
from inspect import signature
from pathlib import Path
from pkgutil import walk_packages
from typing import Any

import msgspec
import pytest
import typer
from tests.ui.cli.commands import run

import understudy
import understudy_lab
from understudy.errors import UnderstudyError
from understudy.judging.lesson_replay import DecisionChange, ReplayedPress
from understudy.judging.simplify_preview import BeforeAfter, ChangedDecision, ChangedMoments
from understudy.learning.change_attribution import ConditionChange, ExampleAttribution
from understudy.learning.pruning_suggestions import PruningSuggestion
from understudy.model.automaton import State
from understudy.storage.library_folder import SavedVersion
from understudy.ui.cli.command_group import CommandTable
from understudy.ui.cli.main import make_command_line
from understudy.ui.cli.old_spellings import OLD_SPELLINGS
from understudy.ui.cli.plugins import CommandEntry
from understudy_lab.ablation.variants import kit as ablation_kit

PAGE = Path(__file__).parents[2] / "page/src"
ERRORS = {  # name, exit code, what it is made of
    "AlreadyThere": (2, "names"),
    "ArmingRefused": (2, "robot problem remedy"),
    "CannotRepeat": (1, "problem remedy"),
    "DefinitionError": (2, "what problem remedy"),
    "EvaluationFailed": (1, "problem part"),
    "ExtraMissing": (2, "what extra"),
    "FileError": (2, "path place problem remedy"),
    "ImageError": (2, "problem remedy"),
    "JobFailed": (1, "problem"),
    "KindError": (2, "where problem remedy"),
    "LeftOut": (2, "what name where known reason"),
    "InvalidMapping": (2, ""),
    "OtherKit": (2, ""),
    "LawBroken": (2, "part law found"),
    "MessageRefused": (2, "type problem"),
    "NoDrawing": (2, "problem"),
    "PartsUnfinished": (2, "problem"),
    "PeerMissing": (2, "peer extra"),
    "RecordingFailed": (1, "path problem"),
    "RecursionRefused": (2, "cycle path"),
    "ScikitMissing": (2, "classifier"),
    "SessionError": (2, ""),
    "SettingError": (2, "where setting problem remedy"),
    "UnboundParameter": (2, "behavior parameter targets"),
    "UnderstudyError": (2, ""),
    "UnknownName": (2, "what name where known"),
    "Unreachable": (2, "what problem remedy"),
    "UnusableField": (2, "problem"),
    "UnusableMessage": (2, "problem"),
    "WatchdogFailed": (2, "robot problem"),
}
"""What `--json` says of an error: its name is its `type`, and what it is made of are further fields."""
MESSAGES = [
    "add_object", "add_obstacle", "add_property", "arm", "arm_robot", "bind_targets", "cancel_evaluation",
    "change_design", "choose_goal", "confirm", "confirm_press", "correct_slip", "define", "delete", "delete_property",
    "diff_versions", "discard", "drive", "duplicate", "edit", "evaluate", "go_back", "go_back_to_best", "go_to_mark",
    "go_to_property", "heartbeat", "keep_going", "label", "learn", "leave_failure", "let_drive", "list_versions",
    "move_object", "move_obstacle", "move_robot", "new", "new_world", "next_situation", "open", "open_failure",
    "open_library", "open_world", "pause", "pause_drive", "pick_color", "press", "property_choices", "prune",
    "quarantine", "read_world_grid", "recall", "redo", "release", "release_control", "remove", "remove_object",
    "remove_obstacle",
    "remove_property", "rename", "request_advice", "rerun_failures", "reset", "restart", "restore", "rewind",
    "run_world_grid", "save",
    "save_property", "save_world", "select_agent", "set_other_agents", "set_query_policy", "set_reaction_time",
    "set_up", "settle", "simplify", "skip", "speed", "split", "steer", "step", "stop", "stop_robot", "take_control",
    "test", "test_properties", "toggle_mode", "toggle_score", "toggle_watching", "trust", "undo",
    "visit_grid_world", "why",
]  # fmt: skip
"""What a page may send, in its field `do`."""
TAGS = {  # the field that says which sort of struct it is: the sorts, where the format is a file's or a page's
    "do": MESSAGES,
    "is": ["drive", "hello", "scene", "session", "team"],
    "kind": [
        "bumper", "camera", "cargo", "claimed", "holding", "lidar", "locator", "pose", "random", "since",
        "sonar", "stuck",
    ],
    "learns": ["scikit-learn", "trees"],
    "node": ["absent", "arc", "below", "go", "label", "stay"],
    "term": ["difference", "quotient", "reading"],
    "type": [
        "Accepted", "Acted", "Attended", "Began", "Occupied", "Placed", "Pressed", "Raised", "Snapshot", "Stepped",
        "Ticks", "Turned", "Went",
    ],
}  # fmt: skip
COMMANDS = {
    "": "--version --debug --install-completion --show-completion",
    "advise": "NAME --bind -b --most --library -l --world -w --kit --json",
    "bench": "--json",
    "bench crowding": "--json",
    "bench environments": "--json",
    "bench interpreter": "--json",
    "bench learning": "--json",
    "bench looks": "--json",
    "bench million": "--json",
    "bench patrol": "--json",
    "bench reading": "--json",
    "bench robots": "--json",
    "bench segmentation": "--json",
    "bench squads": "--json",
    "bench start": "--json",
    "bench swarm": "--json",
    "check": "[NAME]... --library -l --world -w --worlds --kit --fail-on --all --json",
    "demo": "TASK --seed --out -o --method --json",
    "diff": "NAME --from --to --all --library -l --world -w --kit --json",
    "draw": "NAME --out -o --children --force --library -l --world -w --kit --json",
    "drive": "--name -n --behaviors --features --agent -a --seed --no-record [SCENARIO] --world -w --library -l "
    "--kit --host --port --token --no-browser --json",
    "eval": "--behavior --library -l --seeds --goal --metric --limit --against --against-behavior --jobs -j --each "
    "--format --json [SCENARIO] --world -w --bind -b --kit",
    "experiment": "list|all|NAME --seeds --quick --data --out -o --jobs -j --part --gather --cluster "
    "--cluster-option --json",
    "export": "",
    "export automaton": "NAME --to --out -o --library -l --bind -b --float32 --world -w --kit --robot --run --json",
    "export dataset": "SOURCE... --to --out -o --json",
    "export table": "SOURCE --out -o --table --json",
    "export why": "TRACE --time -t --library -l --world -w --exported --agent -a --kit --json",
    "falsify": "NAME --library -l --world -w --property --vary --limit --seconds --worlds --seed --jobs -j "
    "--out -o --bind -b --kit --json",
    "falsify-body": "NAME --library -l MODULE:NAME --goal --limit --seconds --worlds --seed --jobs -j --out -o --bind "
    "-b --kit --json",
    "learn": "",
    "learn drive": "FILE... --driver --pairs --no-pairs --map --behaviors --define --split --features --targets "
    "--reaction --agent -a --kit --predict --library -l --name -n --json",
    "learn drivers": "FILE... --driver --trust --map --behaviors --define --split --features --targets --reaction "
    "--agent -a --kit --predict --library -l --name -n --json",
    "learn recording": "FILE.mcap --presses --states --features --flags --parameters --targets --reaction --agent -a "
    "--session --kit --predict --library -l --name -n --json",
    "learn table": "LESSON.csv --flags --predict --library -l --name -n --json",
    "list": "--library -l --world -w --kit --json",
    "more": "--json",
    "prepare": "[SCENARIO]... --json",
    "rebuild": "[NAME]... --library -l --world -w --kit --json",
    "replay": "FILE --map --library -l --behavior --bind -b --kit --json",
    "review": "FILE... --driver --trust --map --name -n --behaviors --features --targets --agent -a --library -l "
    "--kit --host --port --token --no-browser --json",
    "robots": "",
    "robots check": "FILE --seconds --json",
    "robots color": "FOLDER --name -n --robot --json",
    "robots layout": "FILE --json",
    "robots run": "FILE --behavior --library -l --record -r --seconds --bind -b --kit --json",
    "robots simulate": "WORLD --seed --domain --rate --router --write-files --apart --only --parent --seconds --json",
    "robots stop": "FILE --json",
    "robots stops": "FILE --last --json",
    "robots studio": "FILE --no-record --library -l --kit --host --port --token --no-browser --json",
    "robots teach": "FILE --no-record NAME --library -l --states --features --parameters --targets --flags --watched "
    "--plain --reaction --kit --json",
    "run": "--behavior --library -l --seed --record -r --trace --seconds --speed [SCENARIO] --world -w --bind -b "
    "--kit --json",
    "show": "NAME --all --library -l --world -w --kit --json",
    "simplify": "NAME --pruning -p --keep --library -l --world -w --kit --json",
    "studio": "--seed --failures [SCENARIO] --world -w --library -l --kit --host --port --token --no-browser --json",
    "teach": "--world -w --seed --failures NAME --library -l --states --features --parameters --targets --flags "
    "--watched --plain --reaction --kit --json",
    "team": "",
    "team agent": "--name --library -l --seconds --record TEAM --json",
    "team arm": "--name TEAM --json",
    "team logs": "--name TEAM --json",
    "team merge": "OUT RECORDING... --reference --json",
    "team push": "--library -l TEAM --json",
    "team status": "TEAM --json",
    "team stop": "--name TEAM --json",
    "test": "--library -l --world -w --failures --jobs -j --strict --kit --json",
    "validate": "[NAME]... --library -l --world -w --kit --json",
    "why": "RUN --time -t --agent -a --library -l --world -w --kit --json",
    "worlds": "[SCENARIO] --json",
}
"""Commands, their arguments as the help shows them, and their options."""
OLD_COMMANDS = {
    "agent": "TEAM --name --library --seconds --record --json",
    "export data": "SOURCE... --out -o --table --to --json",
    "falsify": "LIBRARY NAME --world -w --property --seconds --worlds --seed --limit --goal --vary --jobs -j "
    "--out -o --bind -b --kit --json",
    "learn": "[LESSON.csv] --predict --library -l --name -n --recording --driver --trust --presses --states "
    "--features --flags --parameters --targets --reaction --agent -a --session --map --behaviors "
    "--define --split --kit --json",
    "run": "[SCENARIO] --behavior --library -l --world -w --seed --record -r --trace --seconds --speed "
    "--replay --bind -b --robot --team --no-record --kit --json",
    "studio": "[SCENARIO] --world -w --library -l --kit --host --port --token --no-browser --seed --failures "
    "--robot --team --no-record --recording --driver --trust --map --name -n --behaviors --features "
    "--targets --agent -a --drive --json",
    "teach": "NAME --world -w --library -l --states --features --parameters --targets --flags --watched "
    "--plain --reaction --seed --failures --robot --no-record --kit --json",
    "why": "RUN --time -t --agent -a --library -l --world -w --exported --kit --json",
}
"""Commands that were renamed or parted, with all their arguments and options, which keep working."""


@pytest.fixture(scope="module", autouse=True)
def import_everything() -> None:
    """Import all modules, so that all classes are known; those of other people's packages may be missing."""
    for package in (understudy, understudy_lab):
        for module in walk_packages(package.__path__, f"{package.__name__}."):
            if module.name.endswith("__main__"):
                continue
            with suppress(ImportError):
                import_module(module.name)


def below(kind: type[Any]) -> Iterator[type[Any]]:
    """All classes derived from one, if they are part of the product."""
    for each in kind.__subclasses__():
        yield each
        yield from below(each)


def ours(kind: type[Any]) -> bool:
    return kind.__module__.startswith("understudy")


def test_names_of_errors() -> None:
    kinds: set[type[UnderstudyError]] = {UnderstudyError, *filter(ours, below(UnderstudyError))}
    assert {kind.json_type: (kind.exit_code, fields(kind)) for kind in kinds} == ERRORS


def fields(kind: type[UnderstudyError]) -> str:
    """What an error is made of: the arguments that it keeps by their names."""
    if "__init__" not in vars(kind):
        return ""
    _, *arguments = signature(kind.__init__).parameters
    return " ".join(arguments)


def test_names_of_errors_are_written_out() -> None:
    """The name of a class is not the name that programs know, so each class of ours says both."""
    unsaid = []
    for kind in filter(ours, below(UnderstudyError)):
        source = Path(str(import_module(kind.__module__).__file__)).read_text(encoding="utf-8")
        if not re.search(rf'class {kind.__name__}\([\w.]+, json_type="{kind.json_type}"\)', source):
            unsaid.append(kind.__qualname__)
    assert unsaid == []


def test_an_error_of_somebody_elses_is_called_as_its_class() -> None:
    class Theirs(UnderstudyError):
        """An error of another package."""

    assert Theirs.json_type == "Theirs"


def test_what_the_commands_print(monkeypatch: pytest.MonkeyPatch) -> None:
    result = run("show", "nothing", "-l", "/nowhere", "--json", monkeypatch=monkeypatch)
    error = json.loads(result.stdout)["error"]
    assert list(error) == ["type", "message", "path", "place", "problem", "remedy"]
    assert error["type"] == "FileError"


def test_tags() -> None:
    found: dict[str, set[str]] = {}
    for kind in filter(ours, below(msgspec.Struct)):
        config = kind.__struct_config__
        if config.tag is not None and not kind.__subclasses__():
            found.setdefault(config.tag_field, set()).add(config.tag)
    assert {field: sorted(tags) for field, tags in found.items()} == TAGS


def test_tags_are_written_out() -> None:
    """Left to msgspec, a tag is the name of its class."""
    unsaid = []
    for kind in filter(ours, below(msgspec.Struct)):
        config = kind.__struct_config__
        source = Path(str(import_module(kind.__module__).__file__)).read_text(encoding="utf-8")
        said = re.search(rf'class {kind.__name__}\([^)]*\btag="{config.tag}"', source)
        if config.tag is not None and not kind.__subclasses__() and not said:
            unsaid.append(kind.__qualname__)
    assert unsaid == []


def test_messages_of_the_page() -> None:
    """All that the page says is understood, and all that is understood is said by the page."""
    sources = [(PAGE / "protocol.ts").read_text(encoding="utf-8")]
    said = re.findall(r"\bdo:((?:\s*\|?\s*\"\w+\")+)", "\n".join(sources))
    assert sorted({tag for tags in said for tag in re.findall(r"\w+", tags)}) == MESSAGES


def commands(command: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[str, str]]:
    names = []
    for each in command.params:
        option = each.param_type_name == "option"
        names += [*each.opts, *each.secondary_opts] if option else [each.metavar or each.name.upper()]
    yield " ".join(path), " ".join(names)
    for name, inner in getattr(command, "commands", {}).items():
        yield from commands(inner, (*path, name))


def test_commands_and_their_options() -> None:
    assert dict(commands(typer.main.get_command(make_command_line()))) == COMMANDS


def test_old_commands_take_their_options() -> None:
    assert OLD_COMMANDS.keys() == OLD_SPELLINGS.keys() - {"export"}
    for name, words in OLD_COMMANDS.items():
        spelling = OLD_SPELLINGS[name]
        old = CommandTable([]).load(CommandEntry(name, spelling.run, "", options=spelling.options))
        ((_, taken),) = commands(old)
        assert {word for word in words.split() if word.startswith("-")} <= set(taken.split()), name


def test_features_that_are_functions() -> None:
    """They are called as their functions, and published rows and documents name them."""
    functions = {
        name: each for name, each in ablation_kit.features.items() if getattr(each, "function", None)
    }
    assert {name: each.parameters for name, each in functions.items()} == {
        "signed_angle_to": ("A",),
        "round_angle_to": ("A",),
        "sine_to": ("A",),
        "cosine_to": ("A",),
    }


def test_rows_of_commands_keep_their_keys() -> None:
    """Rows that `--json` prints are the fields of these types, in this order."""
    rows = {
        ReplayedPress: "number kind state shown now formerly",
        DecisionChange: "state formerly now moments",
        ChangedDecision: "number kind state shown before after",
        ChangedMoments: "state before after moments",
        BeforeAfter: "before after",
        PruningSuggestion: "pruning left_out wrong wrong_pruned",
        ConditionChange: "state next what gone new said examples",
        ExampleAttribution: "number happened how",
        SavedVersion: "number saved file",
        State: "name behavior binding flag",
    }
    for row, keys in rows.items():
        assert [field.name for field in dataclasses.fields(row)] == keys.split()
