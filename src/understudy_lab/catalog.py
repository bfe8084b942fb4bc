"""The published experiments by name; each is a module `study` in a folder of its own, with its `EXPERIMENT`."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from types import MappingProxyType

from understudy.errors import UnknownName
from understudy_lab.study import Experiment

QUESTIONS: Mapping[str, str] = MappingProxyType(
    {
        "forage": "Can a robot be taught to forage, and how well does it do it then?",
        "repertoire": "Which behaviors can be taught from a few examples each, and how well are they done then?",
        "servoing": "When does memory help a robot that follows what its camera sees?",
        "novices": "Can people who have never done it teach a robot in five minutes?",
        "coached": "Do people teach better, and with fewer examples, who follow the coach?",
        "hierarchy": "Does a robot learn with fewer examples when a task is taught in layers?",
        "learners": "What do other learners make of the same few decisions?",
        "ablation": "Which parts of the method matter, and how much?",
        "patrol": "Can a team be taught the patrol of the paper, and what does its coordinator bring?",
        "roles": "What is a team worth whose members differ, and what does its coordinator bring?",
        "swarm": "Can two hundred robots and three levels of coordinators be taught, and ten thousand run the same?",
        "unlearning": "Can bad examples be found by the corrections that they made necessary?",
        "slips": "How many corrections does unlearning save those who hit wrong buttons and press late?",
        "transfer": "Does what was taught in the 2-D world hold in physics, seen by rendered cameras?",
        "small": "How small are the lessons that robots learn from?",
    }
)
"""What each asks, in the order in which they are told."""

FOLDERS: Mapping[str, str] = MappingProxyType(
    {
        "repertoire": "behavior_suite",
        "coached": "coaching_benefit",
        "learners": "baselines",
        "roles": "mixed_teams",
        "slips": "noisy_teachers",
        "transfer": "sim_to_sim",
        "small": "lesson_size",
    }
)
"""The folders of experiments that are not called as their folder: published rows keep the experiments' names."""


def find_experiment(name: str) -> Experiment:
    """An experiment by its name."""
    if name not in QUESTIONS:
        raise UnknownName(what="experiment", name=name, where="the catalog", known=list(QUESTIONS))
    found: Experiment = import_module(f"understudy_lab.{FOLDERS.get(name, name)}.study").EXPERIMENT
    return found


def folder_of(name: str) -> Path:
    """Where an experiment lies, with its README and what it came to when it was published."""
    return Path(__file__).parent / FOLDERS.get(name, name)
