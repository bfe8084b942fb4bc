"""What the studio of 0.1.0 said, and what it says since: the meaning is the same, the words are plainer."""

from __future__ import annotations

import re
from typing import Any

REWORDED = [
    (
        r"Nothing is being trained: begin a new .*",
        "No automaton is open: teach something new, or open one from the library",
    ),
    (
        r"Direct the robot by pressing a state: that is how (\w+) is taught",
        r"Press a state to direct the robot: each press teaches \1",
    ),
    (r"(.*) when time goes on", r"\1 on the next tick"),
    (r"Done again: (.*)", r"Redone: \1"),
    (r"World (\d+) from its beginning(.*)", r"World \1, from the start\2"),
    (r"Somebody put it there\.", "Put into quarantine by hand."),
    (r"Promised from here: (.*)", r"Property from here: \1"),
    (r"Here it was promised: (.*)", r"Property from here: \1"),
    (r"No longer promised: (.*)", r"Property removed: \1"),
    (r"(|Property [\w ]+: )(\w+) within (.*)", r"\1\2 is raised within \3"),
    ("choose outcomes", "choose properties"),
    (r"It is as simple as you saw; (.*)", r"Simplified as shown; \1"),
    ("Chosen anew; .*", "Design changed; the examples are kept, and undo reverts this"),
    (r"(.*); undo takes (?:it|that) back", r"\1; undo reverts this"),
    (
        r"Testing: it decides by itself\. .*",
        "Testing: the automaton decides. Press a state's key where it is wrong",
    ),
    (
        r"Back at (\S+); the lesson stays, .*",
        r"Back at \1; the lesson is unchanged, and the run continues from here",
    ),
    (r"Robot (\d+) was put elsewhere; (.*)", r"Robot \1 was moved; \2"),
    (r"(\d+) times as fast as in life", r"\1 × real time"),
    (
        r"(.*) cannot be told: there is one robot; .*",
        r"\1 cannot be set: there is only one robot; open a scenario with more",
    ),
    (r"You are not watching", "Learning from silence: off"),
    (r"You watch: silence is consent", "Learning from silence: on"),
    (r"Where it is unsure it goes on, .*", "It marks moments at which it is unsure, and continues"),
    (r"(\w+) is called (\w+) now", r"Renamed \1 to \2"),
    (
        r"(\w+) is open again: let it try, .*",
        r"Opened \1: test it, and press the right state where it is wrong",
    ),
    (r"Paused: \. takes one step, .*", "Paused: . takes one step, space resumes"),
    (r"(\w+) started afresh; (.*)", r"\1 restarted; \2"),
    (r"this page only watches: .*", "this page is not in control: take over first"),
    (r"(.*): nothing has to be armed", r"\1 and need not be armed"),
    (r"Stopped\. Arm it again .*", "Stopped. Arm the robot again before it can move"),
    (r"(.*) is the one that will be trained", r"\1 will be trained"),
    (r"Show me what to do in (\w+)(.*)", r"Show me what to do in state \1\2"),
    (r"Did you mean that in (\w+)(.*)", r"Did you mean this in state \1\2"),
    (r"(.*), which are all one to me now\.", r"\1, which look the same to me now."),
]
"""Pattern of a whole text of 0.1.0, and what takes its place; several may apply, one after the other."""
ARC = re.compile(r"between (−?[\d.]+)° and (−?[\d.]+)°")
"""Angles between two: in 0.1.0 those through straight behind, too, where the second is the smaller number."""


def reword(value: Any) -> Any:
    """Return a message of 0.1.0 with all its texts as they are today."""
    match value:
        case dict():
            return {key: each if key == "say" else reword(each) for key, each in value.items()}
        case list():
            return [reword(each) for each in value]
        case str():
            for old, new in REWORDED:
                value = re.sub(f"^{old}$", new, value)
            return ARC.sub(_reword_arc, value)
        case _:
            return value


def _reword_arc(match: re.Match[str]) -> str:
    first, last = (float(each.replace("−", "-")) for each in match.groups())
    return match[0] if first < last else f"at least {match[1]}° or below {match[2]}°"
