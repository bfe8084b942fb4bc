"""Plots, by structure: every state, transition, test and interval is there, with its text, mark and unit."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from math import tau
from typing import Any

import numpy as np
import pytest
from matplotlib import pyplot
from matplotlib.patches import Circle, FancyBboxPatch, Polygon
from tests.make.run_frames import make_crossing
from tests.ui.cli.forage_parts import AUTOMATA, goto

from understudy.errors import SettingError
from understudy.judging.evaluation import Evaluation
from understudy.judging.intervals import exact_interval_of_share
from understudy.judging.outcomes import Outcomes
from understudy.model.automaton import START, Automaton, State
from understudy.model.describe import list_conditions_by_switch
from understudy.model.diff import diff_automata
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf
from understudy.runtime.link import link
from understudy.runtime.run_loop import Run
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.viz.automaton_graph import lay_out_taught, stack_graphs
from understudy.viz.automaton_plot import plot_graphs
from understudy.viz.axes import measure_points_per_unit
from understudy.viz.run_plot import plot_run

LIBRARY = Library.from_automata(FORAGE_KIT, *AUTOMATA)


def texts(axes: Any) -> list[str]:
    return [text.get_text() for text in axes.texts]


def patches(axes: Any, kind: type) -> list[Any]:
    return [patch for patch in axes.patches if type(patch) is kind]


def test_an_automaton() -> None:
    axes: Any = goto.plot()
    said, edges = texts(axes), len(list_conditions_by_switch(goto, None))
    assert edges == 13
    assert [text for text in said if text == "goto(A)"] == ["goto(A)"]
    assert Counter(said)["forward"] == 1
    assert {
        "5 states",
        "idles",
        "flag",
        "start → forward",
        "right → left",
        "distance_to(A) is below 0.3 m",
    } <= set(said)
    assert [Counter(said)[str(number)] for number in range(1, edges + 2)] == [2] * edges + [0]
    assert len(patches(axes, FancyBboxPatch)) == len(goto.states)
    assert len(patches(axes, Circle)) == 2 * edges + 1  # numbers in the graph and in the list, and the start
    assert len(patches(axes, Polygon)) == edges + 1
    dashed = [patch.get_linestyle() for patch in patches(axes, FancyBboxPatch)]
    assert dashed.count("-") + dashed.count("solid") == len(goto.states) - 1


def test_text_of_an_automaton_stays_in_the_axes_of_any_size() -> None:
    for size in [(9.0, 7.0), (6.0, 5.0), (5.0, 9.0)]:
        figure, axes = pyplot.subplots(figsize=size)
        assert goto.plot(axes) is axes
        figure.canvas.draw()
        frame = axes.get_window_extent().padded(2.0)
        for text in axes.texts:
            extent = text.get_window_extent()
            assert frame.x0 <= extent.x0 < extent.x1 <= frame.x1, text.get_text()
            assert frame.y0 <= extent.y0 < extent.y1 <= frame.y1, text.get_text()
        sizes = {round(float(text.get_fontsize()) / measure_points_per_unit(axes), 6) for text in axes.texts}
        assert sizes == {11.5, 12.0, 13.0, 15.0, 18.0}


def test_a_state_may_have_any_name() -> None:
    odd = Automaton(
        "$x_1$ & <b>", (START, State("$a$ <b>", "forward")), transitions={"start": Tree((make_leaf(1),))}
    )
    axes: Any = odd.plot()
    axes.figure.canvas.draw()
    assert "$a$ <b>" in texts(axes)


def test_several_automata_stand_below_each_other() -> None:
    graphs, width, height = stack_graphs([lay_out_taught(TrainedAutomaton(each)) for each in AUTOMATA])
    assert {graph.width for graph in graphs} == {width}
    axes: Any = plot_graphs(graphs)
    assert (axes.get_xlim(), axes.get_ylim()) == ((0.0, width), (height, 0.0))
    tops = [
        text.get_position()[1] for text in axes.texts if text.get_text() in {graph.title for graph in graphs}
    ]
    assert len(tops) >= len(AUTOMATA)


LABELS = Tree(
    (
        Node(TestKind.LABEL, 0, branches=(1, 2, STAY), absent=2),
        Node(TestKind.ARC, 1, low=5.0, high=0.3, yes=3, no=4),
        make_leaf(0),
        make_leaf(1),
        make_leaf(2),
    )
)


def test_a_tree_without_names() -> None:
    said = texts(LABELS.plot())
    assert said == [
        "label 1", "label 2 or absent", "label 3", "feature 1 is …", "yes", "no",
        "feature 2 is at least 5 or below 0.3", "state 2", "state 3", "state 1", "stays: never shown",
    ]  # fmt: skip


def test_a_tree_with_names_and_units() -> None:
    forward = goto.transitions["forward"]
    assert isinstance(forward, Tree)
    axes: Any = forward.plot(features=goto.features, states=goto.state_names)
    said = texts(axes)
    assert {"distance_to(A) is below 0.3 m", "angle_to(A) is between −17° and 17°"} <= set(said)
    assert Counter(said)["yes"] == Counter(said)["no"] == 3
    assert [name for name in said if name in goto.state_names] == ["done", "forward", "left", "right"]
    assert len(patches(axes, FancyBboxPatch)) == len(forward.nodes)
    assert len(axes.lines) == len(forward.nodes) - 1


def test_boxes_of_a_tree_do_not_overlap() -> None:
    nodes = [Node(TestKind.BELOW, at % 3, high=float(at), yes=2 * at + 1, no=2 * at + 2) for at in range(15)]
    tree = Tree((*nodes, *(make_leaf(at % 4) for at in range(16))))
    boxes = [
        patch.get_path().get_extents(patch.get_patch_transform())
        for patch in patches(tree.plot(), FancyBboxPatch)
    ]
    assert len(boxes) == 31
    assert not any(one.overlaps(other) for at, one in enumerate(boxes) for other in boxes[:at])


def make_two_versions() -> tuple[TrainedAutomaton, TrainedAutomaton]:
    """Two versions of goto: `left` is gone, `wait` is new, `right` does something else, `forward` turns later."""
    turned = Tree((Node(TestKind.ARC, 1, low=tau - 0.5, high=0.5, yes=1, no=2), make_leaf(1), make_leaf(2)))
    states = (
        START,
        goto.states[1],
        State("right", "rotate_left"),
        State("done", flag="done"),
        State("wait", "forward"),
    )
    later = replace(goto, states=states, transitions={"start": Tree((make_leaf(1),)), "forward": turned})
    return TrainedAutomaton(goto), TrainedAutomaton(later)


def test_what_changed() -> None:
    diff = diff_automata(*make_two_versions())
    axes: Any = diff.plot()
    said = texts(axes)
    assert {"− left", "+ wait", "± right", "start", "forward", "rotate_right → rotate_left"} <= set(said)
    assert {"− forward → left", "± forward → right"} <= set(said)
    assert "+ angle_to(A) is between 29° and −29°" in said or any(
        line.startswith("+ angle_to(A)") for line in said
    )
    assert any(line.startswith("− distance_to(A)") for line in said)
    assert "states +2 −2" in next(text for text in said if text.startswith("states"))
    looks = {box.get_linestyle() for box in patches(axes, FancyBboxPatch)}
    assert len(looks) >= 2


def test_nothing_changed() -> None:
    taught = TrainedAutomaton(goto)
    said = texts(diff_automata(taught, taught).plot())
    assert "nothing changed" in said
    assert not [text for text in said if text.startswith(("+ ", "− ", "± "))]


def outcomes(*seconds: float) -> Outcomes:
    whole = np.ones(len(seconds), np.int64)
    return Outcomes(np.array(seconds), np.full(len(seconds), 60.0), whole, whole)


NAN = float("nan")


def test_an_evaluation() -> None:
    result = Evaluation(
        "goto", "forage", (1, 2, 3, 4), outcomes(10.0, 30.0, NAN, 10.0), outcomes(5.0, 6.0, 7.0, 8.0)
    )
    axes: Any = result.plot()
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("time (s)", "share of 4 worlds finished")
    assert axes.get_title(loc="left") == "goto in forage"
    curves = {line.get_label(): line for line in axes.lines if not line.get_label().startswith("_")}
    low, high = exact_interval_of_share(3, 4)
    assert list(curves) == [
        f"goto: 3 of 4 (95 % interval {100 * low:.0f} to {100 * high:.0f} %)",
        "baseline: 4 of 4 (95 % interval 40 to 100 %)",
    ]
    curve, baseline = curves.values()
    assert curve.get_xdata()[:3].tolist() == [0.0, 10.0, 30.0]
    assert curve.get_ydata().tolist() == [0.0, 0.5, 0.75, 0.75]
    assert curve.get_linestyle() != baseline.get_linestyle()
    limits = [line.get_ydata()[-1] for line in axes.lines[:2]]
    assert limits == pytest.approx([low, high])
    assert axes.get_xlim()[1] >= 60.0  # one did not finish: up to its limit


def test_an_evaluation_in_which_nothing_finished() -> None:
    axes: Any = Evaluation("goto", "forage", (1,), outcomes(NAN), None).plot()
    assert [line.get_ydata().tolist() for line in axes.lines][-1] == [0.0, 0.0]


def test_a_run() -> None:
    world = Forage([42])
    run = Run.from_program(world, link(LIBRARY, "goto", {"A": "station"}))
    with pytest.raises(SettingError, match="record_paths"):
        run.plot()
    run.record_paths()
    for _ in range(60):
        run.tick()
    axes: Any = run.plot()
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x (m)", "y (m)")
    assert (axes.get_xlim(), axes.get_ylim()) == ((0.0, 12.0), (0.0, 12.0))
    names = [text.get_text() for text in axes.get_legend().get_texts()]
    assert names[-3:] == ["start of path", "end of path", "within reach"]
    assert set(names[:-3]) <= {*goto.state_names}
    drawn = [line for line in axes.lines if len(line.get_xdata()) > 2]
    moved = np.concatenate([np.array(line.get_xydata()) for line in drawn])
    assert np.hypot(*(moved[-1] - (world.view().robots.x[0], world.view().robots.y[0]))) < 0.2
    assert "station" in texts(axes)


def test_a_run_draws_into_axes_of_others() -> None:
    run = Run.from_program(Forage([1]), link(LIBRARY, "forward"))
    run.record_paths()
    run.tick()
    figure, (left, right) = pyplot.subplots(1, 2)
    assert run.plot(right) is right
    assert not left.lines
    assert len(figure.axes) == 2


@pytest.mark.parametrize("robots", [3, 4, 8])
def test_paths_of_several_robots_differ_without_colors(robots: int) -> None:
    frames = make_crossing(25, robots=robots)
    view = replace(frames[0].view.robots, type=np.zeros(robots, np.int64), team=np.zeros(robots, np.int64))
    alike = [
        frame._replace(
            view=replace(frame.view, robots=replace(frame.view.robots, type=view.type, team=view.team))
        )
        for frame in frames
    ]
    axes: Any = plot_run(alike)
    entries = [line for line in axes.get_legend().get_lines() if line.get_marker() == "None"][:robots]
    assert len({str(line._dash_pattern) + str(line.get_linestyle()) for line in entries}) == robots


class Blind:
    """A body that cannot be drawn."""

    agents, tick_s, time_s = 1, 0.1, 0.0
    readings, targets, channels = (), (), ()


def test_a_body_that_cannot_be_drawn() -> None:
    made = Run.from_program(Forage([1]), link(LIBRARY, "forward"))
    made.body = Blind()  # type: ignore[assignment]
    with pytest.raises(SettingError, match="Blind, which does not say where its agents are"):
        made.record_paths()
    other = Run.from_program(Forage([1, 2]), link(LIBRARY, "forward"))
    with pytest.raises(SettingError, match="world is 2 of 2"):
        other.record_paths(2)


def test_a_long_run_keeps_its_ends() -> None:
    run = Run.from_program(Forage([1]), link(LIBRARY, "forward"))
    run.record_paths()
    for _ in range(30):
        run.tick()
    assert run._recorder is not None
    times = [moment.view.time_s for moment in run._recorder.moments]
    assert times == pytest.approx([0.1 * tick for tick in range(31)])
    assert run._recorder.moments[-1].doing == ("",)
