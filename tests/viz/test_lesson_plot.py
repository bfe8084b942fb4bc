"""The plane of two features: where values of each kind lie, what is decided there, and what the plot refuses."""

from __future__ import annotations

from dataclasses import replace
from math import nan, radians
from typing import Any

import pytest
from matplotlib import pyplot
from matplotlib.colors import to_rgb
from matplotlib.patches import Rectangle

from understudy.errors import SettingError, UnknownName
from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, Feature, FlagFeature, TimeInState
from understudy.model.learner_options import LearnerOptions, SklearnOptions
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.value_kinds import Categorical, Continuous, Toroidal
from understudy.viz.feature_axis import FeatureAxis

DISTANCE = BoundFeature(Feature("distance", Continuous(), reading="range", unit="m"))
ANGLE = BoundFeature(Feature("angle", Toroidal(), reading="bearing", unit="rad"))
COLOR = BoundFeature(Feature("color", Categorical(("red", "green", "blue")), reading="color"))
LATE = BoundFeature(TimeInState())
AUTOMATON = Automaton("drive", (START, State("go", "forward"), State("stop")), (DISTANCE, ANGLE, COLOR, LATE))

SHOWN = [  # distance, angle (degrees), color, next state
    (2.0, 10.0, 0.0, "go"),
    (1.5, -20.0, 1.0, "go"),
    (0.3, 15.0, 1.0, "stop"),
    (0.2, -170.0, 2.0, "stop"),
]


def example(
    number: int, values: tuple[float, float, float], following: str, kind: ExampleKind, state: str = "go"
) -> Example:
    distance, angle, color = values
    return Example(number, state, (distance, radians(angle) % radians(360), color, 1.0), following, kind)


def lesson(*extra: Example) -> Lesson:
    kinds = {"go": ExampleKind.CONFIRMATION, "stop": ExampleKind.DIRECTIVE}
    made = [example(at, (a, b, c), after, kinds[after]) for at, (a, b, c, after) in enumerate(SHOWN)]
    return Lesson(AUTOMATON, (*made, *extra))


def regions(axes: Any) -> dict[tuple[float, float, float, float], str]:
    """The rectangles of the plane (left, right, low, high) with their hatches."""
    found = {}
    for patch in axes.patches:
        if isinstance(patch, Rectangle):
            (x, y), wide, tall = patch.get_xy(), patch.get_width(), patch.get_height()
            found[tuple(round(float(each), 3) for each in (x, x + wide, y, y + tall))] = (
                patch.get_hatch() or ""
            )
    return found  # type: ignore[return-value]


def legend(axes: Any) -> list[str]:
    return [text.get_text() for text in axes.get_legend().get_texts()]


def test_regions_and_boundaries() -> None:
    axes: Any = lesson().plot("distance", "angle")
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("distance (m)", "angle (°)")
    assert axes.get_ylim() == (-180.0, 180.0)
    assert [text.get_text() for text in axes.get_yticklabels()] == ["−180", "−90", "0", "90", "180"]
    found = regions(axes)
    assert sorted(found.values()) == ["", "\\\\"]
    (left, cut, *_), (cut2, right, *_) = sorted(found)
    assert cut == cut2 == pytest.approx(0.9)
    assert (left, right) == pytest.approx(axes.get_xlim())
    (border,) = axes.collections
    assert border.get_segments()[0][:, 0].tolist() == pytest.approx([0.9, 0.9])
    assert legend(axes) == ["stays in go", "goes to stop", "pressed: stop", "confirmed: go"]
    assert axes.get_title(loc="left") == "drive, state go"


def test_examples_have_marks_of_their_state_and_kind() -> None:
    extra = [
        example(10, (1.0, 0.0, 0.0), "go", ExampleKind.DEFAULT),
        example(11, (1.2, 0.0, 0.0), "go", ExampleKind.WATCHED),
        example(12, (2.0, 10.0, 0.0), "go", ExampleKind.CONFIRMATION),
        replace(example(13, (0.1, 90.0, 0.0), "go", ExampleKind.CONFIRMATION), quarantined="misled"),
        example(14, (9.0, 0.0, 0.0), "start", ExampleKind.DIRECTIVE, state="stop"),
    ]
    axes: Any = lesson(*extra).plot("distance", "angle", state="go")
    filled = [line for line in axes.lines if line.get_markerfacecolor() != "none"]
    marks = {
        (line.get_marker(), line.get_markersize(), to_rgb(line.get_markerfacecolor()) == (1, 1, 1)): len(
            line.get_xdata()
        )
        for line in filled
    }
    assert marks == {
        ("s", 7.5, False): 3, ("^", 7.5, False): 2, ("s", 7.5, True): 1, ("s", 3.5, True): 1, ("x", 11.0, False): 1,
    }  # fmt: skip
    rings = [line for line in axes.lines if line.get_markerfacecolor() == "none"]
    assert [ring.get_xydata().tolist() for ring in rings] == [[[2.0, pytest.approx(10.0)]]]
    assert legend(axes)[-5:] == [
        "pressed: stop",
        "confirmed: go",
        "default: go",
        "watched: go",
        "in quarantine",
    ]


def test_labels_are_places_on_an_axis() -> None:
    axes: Any = lesson().plot("color", "distance")
    assert axes.get_xlabel() == "color"
    assert axes.get_xlim() == (-0.5, 2.5)
    assert [text.get_text() for text in axes.get_xticklabels()] == ["red", "green", "blue"]
    assert sorted(x for line in axes.lines for x in line.get_xdata()) == [0.0, 1.0, 1.0, 2.0]


def test_absent_values_have_a_strip() -> None:
    axes: Any = lesson(example(9, (nan, 0.0, 0.0), "stop", ExampleKind.DIRECTIVE)).plot("distance", "angle")
    assert axes.get_xticklabels()[0].get_text() == "absent"
    strip = min(regions(axes))
    assert regions(axes)[strip] == "\\\\"
    xs = sorted(x for line in axes.lines for x in line.get_xdata())
    assert strip[0] < xs[0] < strip[1] < min(xs[1:])
    assert min(left for left, *_ in regions(axes) if left != strip[0]) > strip[1]  # with a gap between


def test_other_features_have_one_value_which_is_named() -> None:
    by_color = [example(at, (1.0 + at / 9, 0.0, color), after, ExampleKind.DIRECTIVE)
                for at, (color, after) in enumerate([(0.0, "go"), (1.0, "stop"), (1.0, "stop")])]  # fmt: skip
    made = Lesson(AUTOMATON, tuple(by_color))
    axes: Any = made.plot("angle", "time_in_state")
    assert [text.get_text() for text in axes.texts] == ["at color = green"]
    assert set(regions(axes).values()) == {"\\\\"}
    axes = made.plot("angle", "time_in_state", at={"color": "red"})
    assert [text.get_text() for text in axes.texts] == ["at color = red"]
    assert set(regions(axes).values()) == {""}
    assert not made.plot("angle", "color").texts


def test_a_classifier_has_regions_too() -> None:
    pytest.importorskip("sklearn")
    smooth = replace(
        lesson(), options=LearnerOptions(learner=SklearnOptions("KNeighborsClassifier", {"n_neighbors": 1}))
    )
    axes: Any = smooth.plot("distance", "color")
    assert set(regions(axes).values()) == {"", "\\\\"}
    assert [text.get_text() for text in axes.texts] == ["at angle = −2°, time_in_state = 1.0 s"]


def test_a_stateless_lesson_pools_its_states() -> None:
    made = Lesson(replace(AUTOMATON, stateless=True), lesson().examples)
    axes: Any = made.plot("distance", "angle")
    assert axes.get_title(loc="left") == "drive, all states"
    assert legend(axes)[:2] == ["next: go", "next: stop"]


ANGLES = [(0.0, 0.0), (179.0, 179.0), (180.0, 180.0), (181.0, -179.0), (359.0, -1.0)]


@pytest.mark.parametrize(("degree", "place"), ANGLES)
def test_angles_run_from_minus_180_to_180(degree: float, place: float) -> None:
    axis = FeatureAxis(ANGLE, [0.0], [])
    assert axis.position(radians(degree)) == pytest.approx(place)


def test_cells_lie_between_thresholds() -> None:
    axis = FeatureAxis(ANGLE, [0.0], [radians(10), radians(350)])
    assert [(round(cell.low), round(cell.high)) for cell in axis.cells] == [(-180, -10), (-10, 10), (10, 180)]
    assert axis.cells[0].sample == pytest.approx(radians(265))
    parts = axis.divide(36)
    assert len(parts) == 36
    assert parts[0].low == -180.0
    assert parts[-1].high == 180.0


MISTAKES: list[tuple[tuple[str, str], dict[str, Any], type[Exception], str]] = [
    (("distance", "angel"), {}, UnknownName, "did you mean 'angle'"),
    (("speed", "angle"), {}, UnknownName, "automaton 'drive' has no feature 'speed'; it has distance, angle"),
    (("angle", "angle"), {}, SettingError, "name two features"),
    (("distance", "angle"), {"state": "fly"}, UnknownName, "no state 'fly'"),
    (("distance", "angle"), {"state": "stop"}, SettingError, "'stop', which has no examples; name .* some: go"),
    (("distance", "angle"), {"at": {"color": "pink"}}, UnknownName, "feature color has no label 'pink'"),
    (("distance", "angle"), {"at": {"time_in_state": "long"}}, SettingError, "give a number"),
]  # fmt: skip


@pytest.mark.parametrize(("axes", "settings", "error", "said"), MISTAKES)
def test_mistakes(axes: tuple[str, str], settings: dict[str, Any], error: type[Exception], said: str) -> None:
    before = pyplot.get_fignums()  # other tests of this process may leave some
    with pytest.raises(error, match=said):
        lesson().plot(*axes, **settings)
    assert pyplot.get_fignums() == before


def test_a_state_must_be_named_if_there_are_several() -> None:
    both = lesson(example(9, (1.0, 0.0, 0.0), "go", ExampleKind.DIRECTIVE, state="start"))
    with pytest.raises(SettingError, match="name one of the states with examples: go, start"):
        both.plot("distance", "angle")
    with pytest.raises(SettingError, match="has no examples; show something first"):
        Lesson(AUTOMATON).plot("distance", "angle")


def test_one_name_with_two_targets_must_be_spelled_out() -> None:
    flag = BoundFeature(FlagFeature("done"))
    two = [
        BoundFeature(Feature("far", Continuous(), reading="range", of="A"), Binding(A=name))
        for name in ("x", "y")
    ]
    made = Lesson(
        Automaton("a", (START, State("go")), (*two, flag)),
        (Example(1, "go", (1.0, 2.0, 0.0), "go", ExampleKind.DIRECTIVE),),
    )
    with pytest.raises(UnknownName, match=r"'far'.*far\(x\)"):
        made.plot("far", "done")
    assert made.plot("far(x)", "done").get_xlabel() == "far(x)"
