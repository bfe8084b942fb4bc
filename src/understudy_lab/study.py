"""The experiments of this package by name, and those of other packages."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from types import MappingProxyType

from understudy.entry_points import STUDIES, list_entry_points, load_instance
from understudy.errors import SettingError, UnknownName
from understudy.judging.study import ResultTable as ResultTable
from understudy.judging.study import Row as Row
from understudy.judging.study import Study as Study
from understudy.judging.study import StudyFindings as StudyFindings
from understudy.judging.study import StudyGoal as StudyGoal
from understudy.judging.study import StudyPlan as StudyPlan
from understudy.judging.study import Task as Task

QUESTIONS: Mapping[str, str] = MappingProxyType(
    {
        "forage": "Can a robot be taught to forage, and how well does it forage then?",
        "repertoire": "Which behaviors can be taught with few examples each, and how well do robots perform them?",
        "servoing": "When does memory help a robot that follows what its camera sees?",
        "novices": "Can people without experience teach a robot in five minutes?",
        "coached": "Do people who follow the coach teach better, and with fewer examples?",
        "hierarchy": "Does a robot learn with fewer examples when a task is taught in layers?",
        "learners": "What do other learners achieve with the same few decisions?",
        "ablation": "Which parts of the method matter, and how much?",
        "patrol": "Can a team be taught the patrol of the paper, and what does its coordinator contribute?",
        "roles": "What is a team of different robots worth, and what does its coordinator contribute?",
        "networks": "Do robots with a computer each work together as well over a network that loses messages?",
        "swarm": "Can two hundred robots and three levels of coordinators be taught, and can ten thousand do the same?",
        "wrong_feature": "How often is a switch learned on the wrong feature, and does the order of tests change it?",
        "unlearning": "Can bad examples be found from the corrections that they made necessary?",
        "slips": "How many corrections does unlearning save people who press wrong buttons and press late?",
        "transfer": "Do behaviors taught in the 2-D world work in simulated physics with rendered cameras?",
        "recordings": "Can a robot be taught by recordings of a stick, without any press?",
        "counterexamples": "Do lessons in worlds in which a robot fails help more than lessons at random places?",
        "searches": "How much sooner than chance does a directed search find worlds in which a robot seldom fails?",
        "small": "How small are the lessons from which robots learn?",
    }
)
"""The question of each experiment, in the order of the list."""

FOLDERS: Mapping[str, str] = MappingProxyType(
    {
        "repertoire": "behavior_suite",
        "coached": "coaching_benefit",
        "learners": "baselines",
        "networks": "lossy_networks",
        "roles": "mixed_teams",
        "slips": "noisy_teachers",
        "transfer": "sim_to_sim",
        "small": "lesson_size",
    }
)
"""The folders of experiments whose name differs from their folder's; published rows contain the names."""


REMEDY = "let the entry point name a Study of understudy.spi"


def list_questions() -> dict[str, str]:
    """Return the question of each experiment by its name; those of other packages come last.

    If an experiment of another package cannot be loaded, the reason replaces its question.
    """
    questions = dict(QUESTIONS)
    for name in sorted(list_entry_points(STUDIES)):
        try:
            questions.setdefault(name, find_experiment(name).question)
        except SettingError as error:
            questions[name] = str(error)
    return questions


def find_experiment(name: str) -> Study:
    """Return an experiment of this package, or of another one that offers it as an entry point, by its name."""
    others = sorted(list_entry_points(STUDIES))
    if name not in QUESTIONS and name in others:
        return load_instance(name, STUDIES, Study, where="understudy experiment", remedy=REMEDY)
    if name not in QUESTIONS:
        raise UnknownName(what="experiment", name=name, where="the catalog", known=[*QUESTIONS, *others])
    study: Study = import_module(f"understudy_lab.{FOLDERS.get(name, name)}.study").EXPERIMENT
    return study


def folder_of(name: str) -> Path:
    """Return the folder of an experiment, with its README and its published result."""
    return Path(__file__).parent / FOLDERS.get(name, name)
