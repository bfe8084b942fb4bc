"""Command `understudy learn table`: learn from a table of examples, which is read before the learner is imported."""

from __future__ import annotations

from dataclasses import replace

from understudy.learning.csv_table import read_lesson_and_lines
from understudy.model.library import Kit, Library, make_lesson_kit
from understudy.ui.cli.lesson_options import LearnTableOptions
from understudy.ui.cli.loading import import_on_call
from understudy.ui.cli.options import parse_names

learn_lesson = import_on_call("understudy.ui.cli.commands.learn:learn_lesson")


def learn_table(options: LearnTableOptions) -> None:
    """Learn an automaton's transition functions from a table of examples."""
    options.check_name()
    lesson, lines = read_lesson_and_lines(options.table, name=options.name, flags=parse_names(options.flags))
    kit = make_lesson_kit(lesson.automaton, Library(Kit.from_parts()))
    learn_lesson(replace(lesson, kit=kit), options, lines=lines)
