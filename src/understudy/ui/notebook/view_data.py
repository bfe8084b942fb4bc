"""Describe a session as plain data for its views: what changes rarely, with the lesson, and with every tick."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np

from understudy.coaching.questions import QueryPolicy
from understudy.model.automaton import Automaton
from understudy.model.change_summary import ChangeSummary
from understudy.model.describe import format_value, list_conditions_by_switch
from understudy.sim.view import WorldView
from understudy.training.trainee import Mode
from understudy.ui.controller import formatting
from understudy.ui.controller.trainer import Trainer
from understudy.viz.appearance import choose_obstacle_colors, choose_robot_colors, list_object_marks
from understudy.viz.automaton_graph import Conditions
from understudy.viz.automaton_svg import draw_automaton_svg
from understudy.viz.palette import COLORS

_DRAWN = ("x", "y", "size", "square", "color", "full", "label")
"""What the page needs of an object's mark."""
PlainData: TypeAlias = dict[str, Any]
"""Data that JSON can represent."""


def describe_arena(trainer: Trainer, view: WorldView) -> PlainData:
    """Describe what does not move: the arena, its obstacles, and what each robot looks like (lengths in m)."""
    rows = zip(
        view.discs.x.tolist(),
        view.discs.y.tolist(),
        view.discs.radius.tolist(),
        choose_obstacle_colors(view),
        strict=True,
    )
    return {
        "scenario": trainer.body.scenario.name,
        "width": view.width,
        "height": view.height,
        "seed": trainer.seed,
        "robot": trainer.robot,
        "radii": view.robots.radius.tolist(),
        "colors": choose_robot_colors(view),
        "walls": view.walls.tolist(),
        "polygons": [corners.tolist() for corners in view.polygons],
        "discs": [list(row) for row in rows],
    }


def describe_objects(view: WorldView) -> list[PlainData]:
    """Describe the objects as other pictures draw them, too (lengths in m)."""
    return [{name: getattr(mark, name) for name in _DRAWN} for mark in list_object_marks(view)]


def pack_robots(view: WorldView) -> bytes:
    """Pack the robots as rows of little-endian float32: x, y (m), heading (rad), units of food on board."""
    robots = view.robots
    columns = (robots.x, robots.y, robots.heading, robots.stored)
    return np.stack(columns, axis=1).astype("<f4").tobytes()


def pack_trail(trainer: Trainer) -> bytes:
    """Pack the trail of the robot in training as rows of little-endian float32: x, y (m), oldest first."""
    return np.array(list(trainer.memory.trail), "<f4").tobytes()


def describe_lesson_data(trainer: Trainer) -> PlainData:
    """Describe what changes with the lesson only: states with their keys, and the picture of the automaton."""
    lesson, transitions = trainer.explainer.learn_lesson()
    automaton, keys, library = lesson.automaton, trainer.keys, trainer.session.library
    states = [
        {
            "name": state.name,
            "key": keys.plain.get(state.name, ""),
            "arrow": keys.arrows.get(state.name, ""),
            "runs": None if state.behavior is None else library.format_call(state.behavior, state.binding),
            "flag": state.flag,
        }
        for state in automaton.states
    ]
    conditions = list_conditions_by_switch(replace(automaton, transitions=transitions), lesson)
    return {
        "states": states,
        "transitions": _number_transitions(automaton, conditions),
        "svg": draw_automaton_svg(automaton, conditions),
    }


def _number_transitions(automaton: Automaton, conditions: Conditions) -> list[PlainData]:
    """Describe the transitions with their conditions, numbered and colored as in the picture."""
    order = {name: at for at, name in enumerate(automaton.state_names)}
    pairs = sorted(conditions, key=lambda pair: (order[pair[0]], order[pair[1]]))
    return [
        {
            "number": number,
            "from": begin,
            "to": end,
            "color": COLORS[order[begin] % len(COLORS)],
            "when": list(conditions[begin, end]),
        }
        for number, (begin, end) in enumerate(pairs, start=1)
    ]


def describe_moment(trainer: Trainer, view: WorldView) -> PlainData:
    """Describe what changes with every tick, apart from the places of robots and objects."""
    seen = trainer.session_view
    readings = [[str(bound), format_value(bound, seen.features[str(bound)])] for bound in trainer.features]
    return {
        "time": formatting.format_minutes(view.time_s),
        "state": seen.state,
        "path": list(seen.path),
        "readings": readings,
        "targets": [[round(x, 3), round(y, 3)] for x, y in trainer.list_target_places()],
    }


def describe_changes(change: ChangeSummary | None) -> PlainData | None:
    """Describe what is decided otherwise than before: a line, and each decision with its conditions."""
    if change is None:
        return None
    decisions = [(each.said, *each.list_differences()) for each in change.changes]
    return {
        "line": str(change),
        "decisions": [{"said": said, "gone": gone, "new": new} for said, gone, new in decisions],
    }


def describe_panel(trainer: Trainer, *, can_save: bool) -> PlainData:
    """Describe what the buttons and the status line show."""
    seen, question = trainer.session_view, trainer.coach.question
    said, score = trainer.status, trainer.score
    return {
        "title": f"{trainer.name}{formatting.format_targets(seen)}",
        "mode": seen.mode.value,
        "paused": trainer.paused,
        "flag": seen.flag,
        "waiting": seen.waiting,
        "examples": seen.examples,
        "undoable": seen.undoable,
        "redoable": seen.redoable,
        "corrected": trainer.corrected and seen.mode is not Mode.TESTING,
        "asks": trainer.coach.asking.when is QueryPolicy.PAUSE,
        "question": None
        if question is None
        else {"sentence": question.sentence, "answers": list(question.answers), "state": question.state},
        "status": {"text": said.text, "tone": said.tone},
        "changed": describe_changes(trainer.session.last_change),
        "score": {"text": score.describe(), "trend": score.trend, "on": score.enabled},
        "can_save": can_save,
        "unsaved": trainer.has_unsaved_changes,
    }
