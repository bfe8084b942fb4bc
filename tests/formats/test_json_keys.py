"""What `--json` prints, written out by its keys: results are values of the domain, whose fields must not move."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from tests.ui.cli.commands import ROOT, run

FIXTURES = ROOT / "tests" / "fixtures" / "v0_1_0"
NAMED = {"at", "conditions", "doing", "former", "notes", "options", "problems", "ranges", "region", "values"}
"""Keys of objects whose own keys are names of features, states or automata."""

KEYS = {
    "list -l {lib}":
    "library automata[name parameters states features examples watched uses used_by versions saved rebuilt] problems",
    "show harvest -l {lib}":
    "name parameters states[name behavior binding flag] features[name kind unit own] examples[number state next kind "
    "correction edited quarantined values source] watched uses used_by versions[number saved file] saved rebuilt "
    "stateless conditions options",
    "diff goto -l {lib}":
    "name from to changes[options conditions examples] moved[state next what gone new said examples[number happened "
    "how]]",
    "check {lib} harvest --world forage --worlds 2":
    "library world holds findings[automaton kind severity certain sentence states assumptions cells[condition ranges "
    "at] examples remedy trial] checked[name states boxes] unchecked ties",
    "simplify goto -l {lib} --pruning 3":
    "name pruning suggested[pruning left_out wrong wrong_pruned] leaves[before after] conditions decisions[number "
    "kind state shown before after] examples changes_before_presses moments_before_presses kept",
    "advise harvest -l {lib}":
    "name advice[kind sentence evidence state weight examples region]",
    "test {lib}":
    "library world works automata[name works examples moments_before former changed affected no_longer different "
    "otherwise watched overruled changes_before outcomes failed sentences] properties failures",
    "worlds":
    "worlds[name robots about goal limit_s features behaviors targets]",
    "worlds tests.own_worlds:Slope":
    "name robots tick_s readings[name unit about of_targets] channels[name unit about of_targets] targets features "
    "behaviors",
    "eval -l {lib} --behavior goto --bind A=station --seeds 0:2 --each --metric distance_to(A) --against {lib}":
    "behavior world seeds worlds success relative_to_expert median_s median_gathered expert_median_s failed_seeds "
    "seconds results[seed success seconds delivered gathered metrics[distance_to(A)]] success_interval goal "
    "metrics[distance_to(A)[median low high count]] problems comparison[against success[first second only_first "
    "only_second difference interval p] metrics[seconds[first second difference[median low high count] test[pairs "
    "equal p is_exact rank_biserial]] distance_to(A)[first second difference[median low high count] test[pairs equal "
    "p is_exact rank_biserial]]]] raised[feature shown raised elsewhere beyond text]",
    "why {runs}/forage.jsonl --time 5 -l {lib}":
    "scenario seed robot doing time_s decided_s former switched agents[sort agent ordered levels[automaton state "
    "since_s decision[time_s automaton before after conditions shown values read by_hand examples[number kind "
    "correction next shown_s source]] rests entry[time_s automaton before after conditions shown values read by_hand "
    "examples[number kind correction next shown_s source]]]] last_switch[time_s automaton before after conditions "
    "shown values read by_hand examples[number kind correction next shown_s source]]",
    "replay {runs}/forage.mcap -l {lib} --behavior goto --bind A=station":
    "recording whole library behavior robots ticks seconds decisions same differences[robot time_s until_s ticks "
    "recorded now decision[time_s automaton before after conditions shown values read by_hand examples[number kind "
    "correction next shown_s source]]] changed former",
    "falsify {lib} forage --worlds 3 --limit 5 -o {out}":
    "behavior world limit_s seconds interrupted random[runs failed low high seeds] directed failure[folder scenario "
    "seed found_by robustness wrong_s steps why command recording] notes",
    "run -l {lib} --seed 3 --seconds 1":
    "behavior world seed robots seconds goal success delivered total gathered path doing record",
}  # fmt: skip
"""What each command printed when its rows were classes of the command line."""


def format_keys(value: Any) -> str:
    """Format the keys of an object in order, those of objects in it, or of the first of several, in brackets."""
    if isinstance(value, list):
        return format_keys(value[0]) if value else ""
    if not isinstance(value, dict):
        return ""
    below = {key: "" if key in NAMED else format_keys(each) for key, each in value.items()}
    return " ".join(f"{key}[{keys}]" if keys else key for key, keys in below.items())


@pytest.mark.parametrize("command", KEYS)
def test_results_keep_their_keys(command: str, tmp_path: Path) -> None:
    library = shutil.copytree(FIXTURES / "library", tmp_path / "library")
    places = {"lib": library, "runs": FIXTURES / "runs", "out": tmp_path / "out"}
    result = run(*(word.format(**places) for word in command.split()), "--json")
    assert result.exit_code in (0, 1), result.stderr
    assert format_keys(json.loads(result.stdout)) == KEYS[command]
