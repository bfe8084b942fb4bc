"""How experiments are declared: their tasks, and what the tables, goals and figures make of a few rows."""

from __future__ import annotations

from typing import Any

import pytest

from understudy_lab.declaration import (
    Cell,
    ColumnPerGroup,
    Conclusion,
    CountGoal,
    Goal,
    LinePerGroup,
    Units,
    goals_among,
)
from understudy_lab.figures import Dots, Panels, by_group, by_value
from understudy_lab.lesson_stats import LiveComparison
from understudy_lab.rows import Count, Median, Rows, group_by, group_by_arm
from understudy_lab.study import StudyPlan


def make_row(seed: int, way: str, presses: int, success: float | None = 1.0, **task: Any) -> dict[str, Any]:
    result = {"rate": {"led": 2 * presses, "alone": presses}}
    return {"task": {"way": way, "seed": seed, **task}, "presses": presses, "success": success, "of": result}


ROWS = Rows(
    [
        make_row(1, "a", 10),
        make_row(2, "a", 20, 0.5),
        make_row(3, "a", 30, None),
        make_row(1, "b", 4),
        make_row(2, "b", 6, 0.9),
    ]
)
BY_WAY = group_by("way", ("a", "b"))

UNITS = [  # whether all tasks of one seed come first, the tasks
    (False, [("a", 5), ("a", 6), ("b", 5), ("b", 6)]),
    (True, [("a", 5), ("b", 5), ("a", 6), ("b", 6)]),
]


@pytest.mark.parametrize(("by_seed", "tasks"), UNITS)
def test_units(by_seed: bool, tasks: list[tuple[str, int]]) -> None:
    units = Units({"way": ("a", "b")}, by_seed=by_seed)
    assert units(StudyPlan([5, 6])) == [{"way": way, "seed": seed} for way, seed in tasks]


def test_rows_are_selected_and_grouped() -> None:
    assert [row["presses"] for row in ROWS.where(way="b")] == [4, 6]
    assert len(ROWS.where(method=None)) == 5
    assert ROWS.values("success") == [1.0, 0.5, 1.0, 0.9]
    assert (ROWS.seeds, ROWS.seed_range) == ([1, 2, 3], "1 to 3")
    assert {name: len(rows) for name, rows in BY_WAY(ROWS).items()} == {"a": 3, "b": 2}
    assert list(group_by("seed")(ROWS)) == [1, 2, 3]
    assert {name: len(rows) for name, rows in group_by("way", ("c", "a"))(ROWS).items()} == {"c": 0, "a": 3}


def test_arms_of_one_row_are_groups() -> None:
    rows = [{"task": {"seed": 1}, **make_row(1, "a", 10)["of"]}]
    assert [each[0]["rate"] for each in group_by_arm(("led", "alone"), "rate")(rows).values()] == [20, 10]
    assert [each[0]["led"] for each in group_by_arm(("rate",))(rows).values()] == [20]


SUMMARIES = [  # a summary, its text for way a, its number
    (Median("presses"), "20 (10–30)", 20.0),
    (Median("success", percent=True), "75 % (50–100)", 0.75),
    (Median(lambda row: row["of"]["rate"]["led"], 1), "40.0 (20.0–60.0)", 40.0),
    (Count(lambda row: row["presses"] > 15), "2 of 3", 2),
    (Count(lambda row: row["presses"] > 15, interval=True), "2 of 3 (21–94 %)", 2),
]


@pytest.mark.parametrize(("summary", "text", "number"), SUMMARIES)
def test_summaries(summary: Median | Count, text: str, number: float) -> None:
    rows = ROWS.where(way="a")
    assert (summary(rows), summary.number(rows)) == (text, number)


def test_a_table_has_lines_or_columns_for_groups() -> None:
    cells: dict[str, Cell] = {"presses": Median("presses"), "well": Count(lambda row: row["success"] == 1.0)}
    lines = LinePerGroup("{teachings} teachings, {seeds}", ["way"], BY_WAY, cells)(ROWS)
    assert (lines.title, lines.columns) == ("3 teachings, 1 to 3", ("way", "#presses", "#well"))
    assert lines.rows == [("a", "20 (10–30)", "1 of 3"), ("b", "5 (4–6)", "1 of 2")]
    columns = ColumnPerGroup("Ways", BY_WAY, cells)(ROWS)
    assert columns.columns == ("", "#a", "#b")
    assert columns.rows == [("presses", "20 (10–30)", "5 (4–6)"), ("well", "1 of 3", "1 of 2")]


GOALS = [  # a goal, what is wanted, what was measured, whether it was reached
    (Goal("g", "presses", ".0f", most=10), "at most 10", "10", True),
    (Goal("g", "presses", ".0f", most=9.9), "at most 10", "10", False),
    (Goal("g", Median("presses"), "×{:.1f}", least=10), "×10.0", "10 (4–30)", True),
    (Goal("g", lambda rows: 0.5, least=0.6, wanted="60 %"), "60 %", "50%", False),
    (Goal("g", lambda rows: 0.0, least=0, measured=lambda rows: f"{len(rows)} rows"), "0%", "5 rows", True),
    (CountGoal("g", 0.5, lambda row: row["presses"] > 6), "3 of 5", "3 of 5", True),
    (CountGoal("g", 0.61, lambda row: row["presses"] > 6), "4 of 5", "3 of 5", False),
    (CountGoal("g", 0.61, lambda row: row["presses"] > 6, round), "3 of 5", "3 of 5", True),
]


@pytest.mark.parametrize(("goal", "wanted", "measured", "held"), GOALS)
def test_goals(goal: Goal | CountGoal, wanted: str, measured: str, held: bool) -> None:
    judged = goal(ROWS)
    assert (judged.wanted, judged.measured, judged.held) == (wanted, measured, held)


def test_a_goal_reads_keys_of_a_summary() -> None:
    goal = Goal("of a summary", "speed.median", ".2f", least=0.8)
    (judge,) = goals_among(lambda found: found["b"], [goal], "b: ")
    judged = judge({"b": {"speed": {"median": 0.75}}})
    assert (judged.what, judged.measured, judged.held) == ("b: of a summary", "0.75", False)


def test_a_conclusion_leaves_out_what_is_not_there() -> None:
    conclude = Conclusion(
        prepare=BY_WAY,
        headline=lambda found: f"{len(found)} ways",
        tables=(lambda found: None, LinePerGroup("", ["way"], dict, {"presses": Median("presses")})),
        goals=(lambda found: None,),
        notes=("", lambda found: "Noted."),
        numbers=lambda found: {"a": len(found["a"])},
    )
    found = conclude(list(ROWS))
    assert (found.headline, len(found.tables), found.goals) == ("2 ways", 1, ())
    assert (found.notes, found.numbers) == (("Noted.",), {"a": 3})


def test_live_teachings_are_compared_with_others_of_their_seed() -> None:
    rows = [*ROWS, make_row(1, "a", 6, method="live"), make_row(9, "a", 1, method="live")]
    compared = LiveComparison("presses", {"success": "success"})
    conclude = Conclusion(lambda rows: f"{len(rows)} rows", (), live=compared)
    found = conclude(rows)
    assert found.headline == "5 rows"
    (table,) = found.tables
    assert table.rows[:2] == [
        ("examples", "6 (6–6)", "10 (10–10)"),
        ("examples, relative to the paper's training", "0.60 (0.60–0.60)", "1"),
    ]
    assert [(goal.measured, goal.held) for goal in found.goals] == [("0.60", True), ("+0.0", True)]
    assert conclude(ROWS).tables == ()


def test_panels_draw_groups_and_values() -> None:
    panels = Panels(
        (
            Dots("ways", "presses", by_group(BY_WAY, "presses", 2), limits=(0, None), dotted=1.0),
            Dots("values", "both", by_value({"presses": "p", "success": "s"})),
        ),
        rows=2,
    )
    first, second = panels(list(ROWS)).axes
    assert [label.get_text() for label in first.get_xticklabels()] == ["a", "b"]
    assert (first.get_title(), first.get_ylim()[0]) == ("ways", 0.0)
    assert second.get_ylabel() == "both"
