"""The commands about a library: list, show, validate, rebuild, diff, learn."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from tests.make.automata import make_goto as taught_goto
from tests.make.goto_sessions import make_goto_session
from tests.sim.patrollers import ROBOTS, lead
from tests.ui.cli.commands import run, run_json

from understudy.learning.fit import learn_automaton
from understudy.model.learner_options import LearnerOptions, TreeOptions
from understudy.model.library import TrainedAutomaton
from understudy.storage.library_folder import save_automaton

TABLE = """state,next,kind,distance:continuous,ready:categorical(no|yes)
start,forward,directive,5,yes
forward,forward,default,5,yes
forward,done,directive,0.4,yes
"""


@pytest.fixture
def lessons(tmp_path: Path) -> Path:
    folder = tmp_path / "lessons"
    save_automaton(folder, taught_goto())
    original = taught_goto()
    assert original.lesson is not None
    return folder


def test_list(library: Path) -> None:
    told = run_json("list", "-l", library)
    assert [row["name"] for row in told["automata"]] == ["deposit", "forage", "goto", "harvest"]
    assert told["automata"][1]["uses"] == ["harvest", "deposit"]
    assert told["automata"][2]["used_by"] == ["deposit", "harvest"]
    assert "goto(A)" in run("list", "-l", library).stdout


def test_list_shows_the_rest_beside_a_bad_file(library: Path) -> None:
    (library / "forage.json").write_text("{")
    result = run("list", "-l", library, "--json")
    assert result.exit_code == 2
    told = json.loads(result.stdout)
    assert [row["name"] for row in told["automata"]] == ["deposit", "goto", "harvest"]
    assert "cut short" in told["problems"]["forage.json"]


@pytest.fixture
def crew(tmp_path: Path) -> Path:
    """A library of patrol: robots' automata, and a coordinator's in the folder of its squad."""
    folder = tmp_path / "patrol-library"
    for automaton in (ROBOTS.automaton(name) for name in ROBOTS.taught):
        save_automaton(folder, TrainedAutomaton(automaton))
    save_automaton(folder / "patrol", TrainedAutomaton(lead()))
    save_automaton(folder / "patrol", TrainedAutomaton(replace(lead(), transitions={})))
    return folder


@pytest.mark.parametrize("world", [(), ("--world", "patrol")])
def test_squads_libraries_are_listed_and_shown(crew: Path, world: tuple[str, ...]) -> None:
    told = run_json("list", "-l", crew, *world)
    assert [row["name"] for row in told["automata"]] == ["patrol", "servo", "wander", "patrol/lead"]
    assert told["automata"][-1]["versions"] == 1
    assert "patrol/lead" in run("list", "-l", crew, *world).stdout
    (crew / "patrol" / "broken.json").write_text("{")
    result = run("list", "-l", crew, *world, "--json")
    assert (result.exit_code, list(json.loads(result.stdout)["problems"])) == (2, ["patrol/broken.json"])
    for name in ("lead", "patrol/lead"):
        told = run_json("show", name, "-l", crew, *world)
        assert (told["name"], len(told["versions"])) == ("lead", 1)
        assert [state["behavior"] for state in told["states"]] == [None, "wander", "servo", "servo"]
    refused = run("show", "boss", "-l", crew, *world)
    assert "no automaton 'boss'; it has patrol, servo, wander, patrol/lead and patrol/broken" in " ".join(
        refused.output.split()
    )
    assert "cut short" in " ".join(run("show", "patrol/broken", "-l", crew, *world).output.split())


def test_a_folder_that_is_no_library_is_not_listed(library: Path) -> None:
    (library / "notes").mkdir()
    (library / "notes" / "settings.json").write_text("{}")
    told = run_json("list", "-l", library)
    assert (len(told["automata"]), told["problems"]) == (4, {})


def test_squads_libraries_are_validated(crew: Path) -> None:
    told = run_json("validate", "-l", crew, "--world", "patrol")
    assert told["checked"] == ["patrol", "servo", "wander", "patrol/lead"]
    assert run_json("validate", "patrol/lead", "-l", crew, "--world", "patrol")["checked"] == ["patrol/lead"]
    assert run_json("validate", "lead", "-l", crew, "--world", "patrol")["checked"] == ["patrol/lead"]
    (crew / "wander.json").unlink()
    result = run("validate", "-l", crew, "--world", "patrol", "--json")
    assert set(json.loads(result.stdout)["problems"]) == {"patrol", "patrol/lead"}


def test_a_library_is_not_valid_unseen_in_a_world_that_lacks_its_squads(crew: Path) -> None:
    """Robots' automata that need little fit many worlds; their coordinator's do not."""
    for name in ("patrol", "servo", "wander"):
        (crew / f"{name}.json").unlink()
    result = run("validate", "-l", crew, "--world", "arena", "--json")
    told = json.loads(result.stdout)
    assert (result.exit_code, told["checked"]) == (2, ["patrol/lead"])
    assert "scenario 'arena' has no squad or type of robots 'patrol'" in told["problems"]["patrol/lead"][0]


def test_show(lessons: Path, library: Path) -> None:
    told = run_json("show", "goto", "-l", lessons)
    assert [state["name"] for state in told["states"]] == ["start", "forward", "done"]
    assert told["examples"][1]["values"] == {
        "distance_to(A)": 5.5,
        "angle_to(A)": None,
        "ready": "yes",
        "bump": "no",
    }
    chosen = {"learner": "trees", "reaction_s": 0.2, "watched": True, "unlearning": False, "live": False}
    assert told["options"] == chosen
    assert any("distance_to(A)" in line for line in told["conditions"]["forward"])
    text = run("show", "goto", "-l", lessons).stdout
    assert "When it switches" in text
    assert "beside 2 watched examples" in text
    assert max(map(len, text.splitlines())) <= 80
    assert "goto(nearest_food)" in run("show", "harvest", "-l", library).stdout


def test_show_says_why_examples_are_in_quarantine_and_what_was_pruned(tmp_path: Path) -> None:
    lesson, reasons = make_goto_session(), {2: "too [late]", 3: "slipped", 5: "slipped"}
    examples = tuple(replace(each, quarantined=reasons.get(each.number, "")) for each in lesson.examples)
    held = replace(lesson, examples=examples, options=LearnerOptions(learner=TreeOptions(pruning=0.5)))
    save_automaton(tmp_path, TrainedAutomaton(learn_automaton(held), held))
    text = run("show", "goto", "-l", tmp_path).stdout
    assert "‡ in quarantine: it teaches nothing\n  2: too [late]\n  3, 5: slipped\n" in text
    assert "learns decision trees, pruned by 0.5\n" in text


def test_validate(library: Path) -> None:
    told = run_json("validate", "-l", library)
    assert told["valid"]
    assert told["checked"] == ["deposit", "forage", "goto", "harvest"]
    assert "all valid" in run("validate", "-l", library).stdout


def test_validate_finds_what_is_missing(library: Path) -> None:
    (library / "goto.json").unlink()
    result = run("validate", "-l", library, "--json")
    assert result.exit_code == 2
    assert set(json.loads(result.stdout)["problems"]) == {"deposit", "forage", "harvest"}
    assert "no behavior 'goto'" in run("validate", "deposit", "-l", library).stdout.replace("\n", " ")


def test_validate_says_which_scenario_a_library_is_of(library: Path) -> None:
    result = run("validate", "-l", library, "--world", "soccer")
    assert result.exit_code == 2
    assert "all valid in another scenario: give --world forage or" in " ".join(result.stdout.split())
    assert run_json("validate", "-l", library)["advice"] is None
    goto = library / "goto.json"
    goto.write_text(goto.read_text().replace('"distance_to"', '"depth_of"'))
    result = run("validate", "-l", library)
    assert "give --world SCENARIO; with a kit of your own" in " ".join(result.stdout.split())


def test_validate_gives_no_advice_on_a_file_that_is_broken_anywhere(library: Path) -> None:
    (library / "forage.json").write_text("{")
    told = run("validate", "-l", library, "--json").stdout
    assert json.loads(told)["advice"] is None


def test_stale_trees_are_noted_and_rebuilt(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    table, folder = tmp_path / "lesson.csv", tmp_path / "library"
    table.write_text(TABLE)
    assert run("learn", table, "-l", folder, "-n", "walk").exit_code == 0
    path = folder / "walk.json"
    path.write_text(path.read_text().replace("0.4, ", "0.5, "))
    assert run_json("list", "-l", folder)["automata"][0]["rebuilt"] is not None
    kit = tmp_path / "walking_kit.py"
    kit.write_text(
        "from understudy.model.behaviors import Behavior\n"
        "from understudy.model.features import Feature\n"
        "from understudy.model.value_kinds import BOOLEAN, Continuous\n"
        "from understudy.model.library import Kit\n"
        "kit = Kit.from_parts(Feature('distance', Continuous(), reading='distance'), Behavior('forward'),\n"
        "             Feature('ready', BOOLEAN, reading='ready'), Behavior('done'))\n"
    )
    monkeypatch.chdir(tmp_path)
    for arguments, expected in (
        ("validate", "built again"),
        ("rebuild", "1 automaton rebuilt"),
        ("validate", "all valid"),
    ):
        done = run(arguments, "-l", folder, "--kit", "walking_kit:kit")
        assert done.exit_code == 0
        assert expected in done.stdout
    assert len(list((folder / "versions" / "walk").iterdir())) == 1


def test_diff(tmp_path: Path) -> None:
    table, folder = tmp_path / "lesson.csv", tmp_path / "library"
    table.write_text(TABLE)
    run("learn", table, "-l", folder, "-n", "walk")
    table.write_text(TABLE.replace("0.4", "0.9") + "start,done,directive,0.1,no\n")
    run("learn", table, "-l", folder, "-n", "walk")
    told = run_json("diff", "walk", "-l", folder)
    assert told["from"] == "1"
    assert len(told["changes"]["examples"]) == 3
    assert told["changes"]["conditions"][0] == "  start"
    (done,) = (each for each in told["moved"] if each["state"] == "start" and each["next"] == "done")
    assert done["what"] == "appeared"
    assert [(who["happened"], who["how"]) for who in done["examples"]] == [("new", "shows it")]
    text = " ".join(run("diff", "walk", "-l", folder).stdout.split())
    assert f"start → done appeared: example {done['examples'][0]['number']} (new, shows it)" in text
    assert run_json("diff", "walk", "--to", "1", "-l", folder)["changes"] == {}
    assert "nothing changed" in run("diff", "walk", "--from", folder / "walk.json", "-l", folder).stdout


def test_diff_says_what_is_learned_before_what_was_shown(tmp_path: Path) -> None:
    """And of many examples the first; all of them where they are asked for."""
    table, folder = tmp_path / "lesson.csv", tmp_path / "library"
    table.write_text(TABLE)
    run("learn", table, "-l", folder, "-n", "walk")
    more = "".join(f"forward,done,directive,{0.5 + 0.01 * number:g},yes\n" for number in range(30))
    table.write_text(TABLE + more)
    run("learn", table, "-l", folder, "-n", "walk")
    text = run("diff", "walk", "-l", folder).stdout
    assert text.index("\nconditions\n") < text.index("\nbecause of\n") < text.index("\nexamples\n")
    assert (text.count("\n  + "), text.endswith("\n10 more: --all\n")) == (21, True)
    assert run("diff", "walk", "-l", folder, "--all").stdout.count("\n  + ") == 31
    assert list(run_json("diff", "walk", "-l", folder)["changes"]) == ["conditions", "examples"]


def test_learn(tmp_path: Path) -> None:
    table, rows = tmp_path / "lesson.csv", tmp_path / "rows.csv"
    table.write_text(TABLE)
    rows.write_text(
        "state,next,distance:continuous,ready:categorical(no|yes)\nforward,,0.3,yes\nforward,,9,\n"
    )
    told = run_json("learn", table, "--predict", rows)
    assert told["predictions"] == ["done", "forward"]
    assert set(told["states"]["forward"]) == {
        "conditions", "nodes", "depth", "contradictions", "disagreements", "watched", "overruled", "fit_ms",
    }  # fmt: skip
    assert "done when distance" in run("learn", table, "--predict", rows).stdout


def test_learn_says_what_it_decides_otherwise_than_the_version_that_it_replaces(tmp_path: Path) -> None:
    table, folder = tmp_path / "lesson.csv", tmp_path / "library"
    table.write_text(TABLE)
    learning = ("learn", table, "-l", folder, "-n", "walk")
    assert run_json(*learning)["changed"] == []  # there is none
    assert "decides otherwise" not in run(*learning).stdout  # it is the same
    table.write_text(TABLE.replace("0.4,yes", "0.4,no") + "forward,forward,confirmation,0.3,yes\n")
    shown = run(*learning).stdout
    assert "What it decides otherwise than the version before, beyond what new rows say:" in shown
    assert "  in forward, done now looks at ready, no longer at distance\n" in shown
    table.write_text(TABLE)
    (change,) = run_json(*learning)["changed"]
    assert change["said"] == "in forward, done now looks at distance, no longer at ready"
    assert (change["was"], change["now"]) == (["ready is no"], ["distance is at most 0.4"])


def test_learn_says_that_watched_examples_alone_teach_nothing(tmp_path: Path) -> None:
    table = tmp_path / "watched.csv"
    table.write_text("state,next,kind,distance:continuous\nforward,forward,watched,1\n", encoding="utf-8")
    assert run("learn", table).stdout == "Nothing was learned: no example was made by a press.\n"


def test_examples_that_are_decided_otherwise_are_named_by_their_lines(tmp_path: Path) -> None:
    table = tmp_path / "lesson.csv"
    table.write_text(  # an empty line, and a cell of two lines
        "state,next,kind,distance:continuous\n\nforward,forward,directive,2\n"
        'forward,"stop\n",directive,9\nforward,turn,directive,2\n'
    )
    told = run_json("learn", table)
    assert [each["place"] for each in told["contradicted"]] == ["line 6 (example 2)"]
    text = " ".join(run("learn", table).stdout.split())
    assert "line 6 (example 2): forward stays, and was shown to go to turn" in text
